#include "apps/tessera/serve/coding.hpp"

namespace tessera::app {

CodingThread::CodingThread(VideoEncoder encoder) : encoder_(std::move(encoder)), thread_([this] { run(); }) {}

CodingThread::~CodingThread() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void CodingThread::push(YuvImage planes, std::uint32_t frame, bool iFrame, std::vector<Region> regions) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !next_; });
  next_ = Job{std::move(planes), frame, iFrame, std::move(regions)};
  changed_.notify_all();
}

void CodingThread::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !next_ && !busy_; });
}

std::vector<Result<EncodedFrame>> CodingThread::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(done_, {});
}

void CodingThread::run() {
  while (true) {
    std::optional<Job> job;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return next_ || ends_; });
      if (!next_) return;
      job.swap(next_);
      busy_ = true;
    }
    changed_.notify_all();
    auto coded =
        encoder_.encode(job->planes.view(), job->frame, {.iFrame = job->iFrame, .regions = job->regions});
    {
      const std::lock_guard lock(mutex_);
      done_.push_back(std::move(coded));
      busy_ = false;
    }
    changed_.notify_all();
  }
}

}  // namespace tessera::app
