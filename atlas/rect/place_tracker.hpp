// Follows where visible patches are from frame to frame, from their states alone: nothing that an allocator
// says of itself is believed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "glsl/shared/rect_memory.h"

namespace tessera {

/// What became of the patches that two frames in a row show with a block.
struct PlaceChanges {
  bool reset = false;             // memory was reset between the two
  std::uint32_t stayed = 0;       // without a reset, patches at the same level as before
  std::uint32_t kept = 0;         // of those, the ones at the same place
  std::uint32_t moved = 0;        // patches whose place or size changed, by a reset or not
  std::uint64_t movedTexels = 0;  // of the blocks that those have now
};

class PlaceTracker {
 public:
  explicit PlaceTracker(std::uint32_t patchInstances) : last_(patchInstances) {}
  /// The next frame: its visible patches, the states of all patches after it, and the atlas's epoch.
  PlaceChanges follow(std::span<const std::uint32_t> visible, std::span<const glsl::PatchState> states,
                      std::uint32_t epoch);

 private:
  struct Place {
    std::uint32_t origin = 0;
    std::uint32_t size = 0;
    std::uint32_t frame = 0;  // in which the patch was last visible with a block; frames count from 1
  };
  std::vector<Place> last_;
  std::uint32_t frame_ = 0;
  std::uint32_t epoch_ = 0;
};

}  // namespace tessera
