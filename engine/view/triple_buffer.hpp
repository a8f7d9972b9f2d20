// One writer's newest value for one reader, on two threads of which neither waits for the other's work.
#pragma once

#include <array>
#include <mutex>
#include <utility>

namespace tessera::view {

template <class T>
class TripleBuffer {
 public:
  /// The writer's own; its last content is that of some earlier value.
  T& writing() { return slots_[write_]; }
  /// writing() is whole: the reader takes it next, whatever it has not taken is lost.
  void publish() {
    const std::lock_guard lock(mutex_);
    std::swap(write_, ready_);
    fresh_ = true;
  }
  /// The newest whole value becomes reading(). False where there is none newer than the last.
  bool take() {
    const std::lock_guard lock(mutex_);
    if (!fresh_) return false;
    std::swap(read_, ready_);
    fresh_ = false;
    return true;
  }
  /// The reader's own.
  T& reading() { return slots_[read_]; }

 private:
  std::array<T, 3> slots_{};
  std::mutex mutex_;  // held for the swap of two numbers
  int write_ = 0;
  int ready_ = 1;
  int read_ = 2;
  bool fresh_ = false;
};

}  // namespace tessera::view
