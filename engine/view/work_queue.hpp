// What one thread leaves for another to do, in order and bounded by bytes.
#pragma once

#include <condition_variable>
#include <mutex>
#include <vector>

namespace tessera::view {

template <class T>
class WorkQueue {
 public:
  explicit WorkQueue(std::size_t mostBytes) : mostBytes_(mostBytes) {}

  /// False, and nothing is left, where more than the bound would wait.
  bool push(T item, std::size_t bytes) {
    {
      const std::lock_guard lock(mutex_);
      if (bytes_ + bytes > mostBytes_ && !items_.empty()) return false;
      items_.push_back(std::move(item));
      bytes_ += bytes;
    }
    wake_.notify_one();
    return true;
  }
  /// All that waits; waits for something itself. Empty after stop().
  std::vector<T> take() {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [&] { return stopped_ || !items_.empty(); });
    std::vector<T> all;
    if (!stopped_) all.swap(items_);
    items_.clear();
    bytes_ = 0;
    return all;
  }
  void stop() {
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
    }
    wake_.notify_all();
  }
  [[nodiscard]] bool stopped() const {
    const std::lock_guard lock(mutex_);
    return stopped_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<T> items_;
  std::size_t bytes_ = 0;
  std::size_t mostBytes_;
  bool stopped_ = false;
};

}  // namespace tessera::view
