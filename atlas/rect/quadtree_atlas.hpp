// The memory of the rectangular atlas by QuadtreeAllocator: the same frames as RectMemory makes on the GPU,
// on one CPU thread, with the same level selection, controller of S and resets. What differs is the
// allocator.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/rect/quadtree.hpp"
#include "glsl/shared/rect_memory.h"

namespace tessera {

/// What the visible set would ideally take: the measuring pass sums it up for the GPU, see glsl::IdealSum.
struct IdealTexels {
  std::uint64_t scalable = 0;  // texels of the patches above the smallest block: I - d
  std::uint64_t fresh = 0;     // of them, those of patches that the last frame did not see
  std::uint32_t least = 0;     // patches at the smallest block: d of them
};
/// `states` and `epoch` are those that the last frame left; states are all zero and the epoch is 1 before the
/// first.
IdealTexels sumIdeal(const glsl::AtlasConfig& config, std::span<const std::uint32_t> patches,
                     std::span<const glsl::PatchMeasure> measures, std::span<const glsl::PatchState> states,
                     std::uint32_t epoch);

class QuadtreeAtlas {
 public:
  /// Of `config` all counts that concern level selection and pressure; the roots of the quadtree are squares
  /// of the superblock's size.
  explicit QuadtreeAtlas(const glsl::AtlasConfig& config);

  /// A frame: `patches` are the visible ones, each once and below config.patchInstances, with their measures
  /// and what sumIdeal() makes of them.
  void frame(std::span<const std::uint32_t> patches, std::span<const glsl::PatchMeasure> measures,
             const IdealTexels& ideal);

  /// As on the GPU, see PatchState; a patch without a block has level 0 and no particular origin.
  [[nodiscard]] std::span<const glsl::PatchState> patchStates() const { return states_; }
  [[nodiscard]] std::uint32_t epoch() const { return epoch_; }
  [[nodiscard]] std::uint32_t resets() const { return epoch_ - 1; }
  // Of the last frame, see RectStatistics.
  [[nodiscard]] std::uint32_t failures() const { return failures_; }
  [[nodiscard]] std::uint32_t blocksReduced() const { return reduced_; }
  [[nodiscard]] std::uint32_t blocksWaiting() const { return waiting_; }
  [[nodiscard]] std::uint32_t blocksMade() const { return made_; }
  [[nodiscard]] std::uint32_t blocksFreed() const { return freed_; }
  [[nodiscard]] float pressureBias() const { return bias_; }
  [[nodiscard]] float target() const { return pressure_.target; }
  [[nodiscard]] const QuadtreeAllocator& allocator() const { return allocator_; }

 private:
  void request(std::uint32_t patch, const glsl::PatchMeasure& measure);
  bool take(glsl::PatchState& state, glsl::uint level);
  void release(const glsl::PatchState& state);
  void assign();

  glsl::AtlasConfig config_;
  QuadtreeAllocator allocator_;
  glsl::PressureState pressure_;
  std::uint32_t epoch_ = 1;
  std::uint32_t number_ = 0;
  std::uint32_t failures_ = 0;
  std::uint32_t reduced_ = 0;
  std::uint32_t waiting_ = 0;
  std::uint32_t made_ = 0;
  std::uint32_t freed_ = 0;  // without another one being asked for
  float bias_ = 0.0f;
  std::vector<glsl::PatchState> states_;
  std::vector<std::uint32_t> marks_;    // the frame each patch was last visible in
  std::vector<std::uint32_t> live_;     // the last frame's visible patches
  std::vector<std::uint32_t> pending_;  // patches that wait for a block
  std::vector<std::uint32_t> sorted_;
  std::array<std::uint32_t, glsl::kLevels> asked_{};  // of pending_, by level
};

}  // namespace tessera
