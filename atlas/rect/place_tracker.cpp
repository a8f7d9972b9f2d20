#include "atlas/rect/place_tracker.hpp"

namespace tessera {

PlaceChanges PlaceTracker::follow(std::span<const std::uint32_t> visible,
                                  std::span<const glsl::PatchState> states, std::uint32_t epoch) {
  PlaceChanges changes;
  changes.reset = frame_ > 0 && epoch != epoch_;
  epoch_ = epoch;
  const std::uint32_t before = frame_++;
  for (const std::uint32_t patch : visible) {
    const glsl::PatchState& now = states[patch];
    const std::uint32_t size = now.level & glsl::kLevelSize;
    if (now.epoch != epoch || glsl::levelWidth(size) == 0) continue;
    Place& last = last_[patch];
    if (before > 0 && last.frame == before) {
      const bool sameSize = last.size == size;
      const bool samePlace = sameSize && last.origin == now.origin;
      if (sameSize && !changes.reset) {
        ++changes.stayed;
        changes.kept += samePlace ? 1 : 0;
      }
      if (!samePlace) {
        ++changes.moved;
        changes.movedTexels += glsl::levelTexels(size);
      }
    }
    last = {now.origin, size, frame_};
  }
  return changes;
}

}  // namespace tessera
