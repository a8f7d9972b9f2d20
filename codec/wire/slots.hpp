// Numbers of a dense array, given out and taken back. Both ends of a stream keep one and do the same with it,
// so numbers of new entries need not be sent.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::wire {

class SlotPool {
 public:
  /// The slot freed last, or one behind all others.
  std::uint32_t take() {
    std::uint32_t slot = static_cast<std::uint32_t>(live_.size());
    if (free_.empty()) {
      live_.push_back(true);
    } else {
      slot = free_.back();
      free_.pop_back();
      live_[slot] = true;
    }
    return slot;
  }
  /// `slot` must be live.
  void give(std::uint32_t slot) {
    live_[slot] = false;
    free_.push_back(slot);
  }
  [[nodiscard]] bool live(std::uint32_t slot) const { return slot < live_.size() && live_[slot]; }
  /// Slots that were ever in use at once: the length of the array.
  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(live_.size()); }
  [[nodiscard]] std::uint32_t used() const { return size() - static_cast<std::uint32_t>(free_.size()); }

 private:
  std::vector<bool> live_;
  std::vector<std::uint32_t> free_;
};

}  // namespace tessera::wire
