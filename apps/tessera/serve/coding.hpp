// Video is coded on a thread of its own, while the next frame is shaded.
#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "codec/video.hpp"

namespace tessera::app {

class CodingThread {
 public:
  explicit CodingThread(VideoEncoder encoder);
  /// Waits for the frame under way.
  ~CodingThread();
  CodingThread(const CodingThread&) = delete;
  CodingThread& operator=(const CodingThread&) = delete;

  /// Waits while the frame before is coded.
  void push(YuvImage planes, std::uint32_t frame, bool iFrame, std::vector<Region> regions);
  /// Waits until all that was pushed is coded.
  void finish();
  /// What is coded since the last call, in order; errors of the encoder among it. Never waits.
  std::vector<Result<EncodedFrame>> take();

 private:
  struct Job {
    YuvImage planes;
    std::uint32_t frame;
    bool iFrame;
    std::vector<Region> regions;
  };
  void run();

  VideoEncoder encoder_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Job> next_;
  bool busy_ = false;
  bool ends_ = false;
  std::vector<Result<EncodedFrame>> done_;
  std::thread thread_;
};

}  // namespace tessera::app
