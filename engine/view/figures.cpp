#include "engine/view/figures.hpp"

#include <algorithm>

namespace tessera::view {

const char* nameOf(Stage stage) {
  constexpr std::array<const char*, kStages> kNames = {"server", "receive", "decode",  "apply",
                                                       "wait",   "upload",  "display", "total"};
  return kNames[static_cast<std::size_t>(stage)];
}

void Latency::add(Stage stage, double milliseconds) {
  constexpr std::size_t kKept = 4096;
  const std::lock_guard lock(mutex_);
  Ring& ring = rings_[static_cast<std::size_t>(stage)];
  if (ring.values.size() < kKept) {
    ring.values.push_back(milliseconds);
    return;
  }
  ring.values[ring.next] = milliseconds;
  ring.next = (ring.next + 1) % kKept;
}

double Latency::median(Stage stage) const {
  std::vector<double> values;
  {
    const std::lock_guard lock(mutex_);
    values = rings_[static_cast<std::size_t>(stage)].values;
  }
  if (values.empty()) return -1.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void Rate::add(std::uint64_t total, double seconds) {
  if (start_ < 0.0 || total < startTotal_) {
    start_ = seconds;
    startTotal_ = total;
    return;
  }
  const double passed = seconds - start_;
  if (passed < 1.0) return;
  last_ = 8e-6 * static_cast<double>(total - startTotal_) / passed;
  start_ = seconds;
  startTotal_ = total;
}

}  // namespace tessera::view
