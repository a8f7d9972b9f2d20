// Memory of the tessellation gatherer's atlas on the GPU: which slot each visible triangle has. All state
// lives in GPU buffers; a frame reads nothing back.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/gl/program.hpp"
#include "glsl/shared/tess_atlas.h"

namespace tessera {

struct TessMemoryOptions {
  int width = 4096;             // texels, [256, 16384]
  int height = 2048;            // texels, [256, 16384]; record rows come on top
  float bias = 0.0f;            // [-16, 16]; log2 of area off every triangle: 1 halves the samples
  bool pressureBias = true;     // raise the bias when the visible set asks for more than the target S
  float biasFloor = 0.0f;       // [-4, 0]; the lowest pressure bias
  float targetShare = 0.5f;     // (0, 1]; S of the first frame, as a share of the atlas
  float targetLargest = 0.9f;   // [targetShare, 1]
  float targetCut = 0.95f;      // (0, 1)
  float targetGrowth = 1.002f;  // [1, 2]
  int quietFrames = 40;         // [0, 1e6]
  float highWater = 1.0f;       // (0, 1]; share of the atlas in cells beyond which memory is reset
  float hysteresis = 0.05f;     // [0, 1] in log2 of length; negative for none
  /// [kAllSlanted, kNoneSlanted]; longest edge to height beyond which a triangle is slanted. At as many
  /// samples Ls are the worse pictures (they have 1.73 samples a pixel of an equilateral triangle):
  /// of 1.3, 1.6, 2, 3 and 4 up to 1.6 is best in sponza (MSSIM 0.963, 0.962, 0.959, 0.949), and has Ls where
  /// triangles are nearly equilateral.
  float slanted = 1.6f;
  static constexpr float kAllSlanted = 0.5f;   // below what any triangle has
  static constexpr float kNoneSlanted = 1e9f;  // beyond what flat ones count as
};

/// What a frame did. Texels are of cells, in rectangles without any, or lost between them.
struct TessStatistics {
  std::uint32_t visible = 0;     // triangles, and pieces of split ones
  std::uint32_t singles = 0;     // of one texel, failures included
  std::uint64_t samples = 0;     // texels to shade
  std::uint64_t lSamples = 0;    // of them in Ls
  std::uint64_t inside = 0;      // texels of Oversampling whose samples lie in their triangle
  std::uint64_t outside = 0;     // and those beyond it, for filtering; a few of `samples` have no texel
  std::uint32_t slanted = 0;     // triangles with Oversampling
  std::uint64_t liveTexels = 0;  // of slots that hold a triangle, visible or not
  std::uint64_t cellTexels = 0;  // of all cells
  std::uint64_t freeTexels = 0;  // of rectangles without cells
  std::uint32_t moved = 0;
  std::uint64_t movedTexels = 0;
  std::uint32_t freed = 0;
  std::uint32_t failures = 0;  // triangles that found no memory
  std::uint32_t resets = 0;    // since creation
  std::uint32_t frames = 0;    // since creation
  float bias = 0.0f;           // constant and pressure bias together, log2 of area
  float target = 0.0f;         // S, texels
};

class TessMemory {
 public:
  TessMemory() = default;
  /// Fails when an option is out of range.
  static Result<TessMemory> create(gl::ProgramCache& programs, const TessMemoryOptions& options,
                                   std::uint32_t triangles);

  /// Of the views that sizes are measured from, [1, TESS_VIEWS].
  void setViewCount(std::uint32_t viewCount);
  // As RectMemory::measure and allocate, over a visible set of triangles.
  void measure(const gl::Buffer& dispatch, const gl::Program* program);
  void allocate(const gl::Buffer& dispatch, std::uint32_t frame);
  void bind() const;

  void reset() { resetAsked_ = true; }
  void holdReset(bool held) { resetHeld_ = held; }

  [[nodiscard]] int textureWidth() const { return static_cast<int>(config_.width); }
  [[nodiscard]] int textureHeight() const;
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] gl::Buffer& stateBuffer() { return state_; }
  [[nodiscard]] gl::Buffer& measures() { return measures_; }

  // These wait for the GPU.
  [[nodiscard]] TessStatistics readStatistics() const;
  /// By number: of the triangles, then of pieces.
  [[nodiscard]] std::vector<glsl::TessState> readStates() const;
  /// Numbers of the triangles and pieces that the last allocate() placed.
  [[nodiscard]] std::vector<glsl::uint> readVisible() const;
  [[nodiscard]] std::vector<glsl::TessBin> readBins() const;
  [[nodiscard]] glsl::TessAtlasState readState() const;

 private:
  void bindPhases() const;

  glsl::TessConfig config_{};
  bool resetAsked_ = false;
  bool resetHeld_ = false;
  gl::Buffer state_;     // TessAtlasState
  gl::Buffer bins_;      // TessBin[bins]
  gl::Buffer runs_;      // TessRun[runs]
  gl::Buffer stacks_;    // uint[]: free slots, a stack a bin
  gl::Buffer states_;    // TessState[triangles + kSplitNumbers]
  gl::Buffer measures_;  // TessMeasure[as many], in the order of the visible list
  gl::Buffer live_;      // uint count, uint ids[]: the last frame's visible list
  const gl::Program* measure_ = nullptr;
  const gl::Program* plan_ = nullptr;
  const gl::Program* request_ = nullptr;
  const gl::Program* provision_ = nullptr;
  const gl::Program* assign_ = nullptr;
};

}  // namespace tessera
