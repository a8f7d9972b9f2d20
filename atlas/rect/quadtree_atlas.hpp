// The memory of the rectangular atlas by QuadtreeAllocator: the same frames as RectMemory makes on the GPU,
// with the same level selection and controller of S, on one CPU thread. Unlike them it does not reset when
// the camera jumps, and a patch that got a smaller block asks again each frame.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/rect/quadtree.hpp"
#include "glsl/shared/rect_memory.h"

namespace tessera {

/// What the visible set would ideally take: the measuring pass sums it up for the GPU.
struct IdealTexels {
  std::uint64_t scalable = 0;  // texels of the patches above the smallest block: I - d
  std::uint32_t least = 0;     // patches at the smallest block: d of them
};
IdealTexels sumIdeal(const glsl::AtlasConfig& config, std::span<const glsl::PatchMeasure> measures);

class QuadtreeAtlas {
 public:
  /// Of `config` all counts that concern level selection and pressure; the roots of the quadtree are squares
  /// of the superblock's size.
  explicit QuadtreeAtlas(const glsl::AtlasConfig& config);

  /// A frame: `patches` are the visible ones, each once and below config.patchInstances, with their measures.
  void frame(std::span<const std::uint32_t> patches, std::span<const glsl::PatchMeasure> measures,
             const IdealTexels& ideal);

  /// As on the GPU, see PatchState; a patch without a block has level 0 and no particular origin.
  [[nodiscard]] std::span<const glsl::PatchState> patchStates() const { return states_; }
  [[nodiscard]] std::uint32_t epoch() const { return epoch_; }
  [[nodiscard]] std::uint32_t resets() const { return epoch_ - 1; }
  [[nodiscard]] std::uint32_t failures() const { return failures_; }
  /// Requests that got a smaller block than asked for, for want of memory.
  [[nodiscard]] std::uint32_t blocksReduced() const { return reduced_; }
  [[nodiscard]] std::uint32_t blocksMade() const { return made_; }
  [[nodiscard]] std::uint32_t blocksFreed() const { return freed_; }
  [[nodiscard]] float pressureBias() const { return bias_; }
  [[nodiscard]] float target() const { return pressure_.target; }
  [[nodiscard]] const QuadtreeAllocator& allocator() const { return allocator_; }

 private:
  void request(std::uint32_t patch, const glsl::PatchMeasure& measure);
  void release(glsl::PatchState& state);
  void assign();

  glsl::AtlasConfig config_;
  QuadtreeAllocator allocator_;
  glsl::PressureState pressure_;
  std::uint32_t epoch_ = 1;
  std::uint32_t number_ = 0;
  std::uint32_t failures_ = 0;
  std::uint32_t reduced_ = 0;
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
