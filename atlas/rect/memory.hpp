// Memory of the rectangular atlas on the GPU: which block each visible patch has. Based on Mueller 2021,
// sec. 3.4 and 3.5. All state lives in GPU buffers; a frame reads nothing back.
#pragma once

#include <cstdint>
#include <optional>

#include "atlas/rect/memory_twin.hpp"
#include "engine/gl/program.hpp"
#include "engine/gl/readback.hpp"
#include "glsl/shared/rect_memory.h"

namespace tessera {

/// How memory is managed (Mueller 2021, sec. 3.6.3). S0 is the one to use; the others are there to be
/// compared with.
enum class AtlasStrategy : std::uint8_t {
  S0,  // columns of one width in a superblock, stacks of free blocks, reset under pressure
  S1,  // a superblock holds blocks of one size
  S2,  // and freed blocks are lost until their superblock is empty
  S3   // and memory is never reset
};

/// log2 of the side of the superblocks that suit an atlas of `width` x `height` texels: 8, or the largest of
/// which it holds 16. With fewer than there are widths of blocks, some widths find no superblock though most
/// of the atlas is free. Measured with `tessera compare` on sponza and littlest_tokyo, 640 x 360, 0.0625 to 1
/// Mpix: this is the size of the best picture, or within 0.003 of MSSIM of it.
int superblockLog2Of(int width, int height);

/// The defaults were measured with `tessera atlas-bench` over the tours of sponza and the atrium, 1000 frames
/// each at 4 Mpix and 1920 x 1080: no request failed, and the largest live share of those that moved few
/// texels. Superblocks of 128 hold 2 % more, but cost 0.01 of MSSIM where patches are near; those of 512 run
/// out of memory.
struct RectMemoryOptions {
  int width = 4096;        // texels; a multiple of the superblock, at most 16384
  int height = 2048;       // texels; a multiple of the superblock; record rows come on top
  int superblockLog2 = 0;  // [1, 10], or 0 for superblockLog2Of(); at most 65536 superblocks
  int smallestLog2 = 0;    // [0, 10], at most largestLog2 and superblockLog2; no side of a block is shorter
                           // than 2^this, but a patch that finds no memory has one texel
  int largestLog2 = 10;    // [0, 10]; none is longer; what exceeds the superblock is clamped to it
  int aspectLog2 = 10;     // [1, 10]; width to height of a block is at most 2^this
  AtlasStrategy strategy = AtlasStrategy::S0;
  bool merge = true;        // S0: merge free siblings, and cut free blocks for what the stacks lack
  float mergeShare = 0.5f;  // [0, 1]; share of the atlas cut into blocks beyond which siblings are merged
  float bias = 0.0f;  // [-16, 16]; log2 of area off every block: 1 halves the texels, -2 quadruples them
  bool pressureBias = true;  // raise the bias when the visible set asks for more than the target S
  float biasFloor = 0.0f;    // [-4, 0]; the lowest pressure bias: 0 shades no finer than the picture, -2 uses
                             // room to spare for up to four times the texels (Mueller 2021, sec. 4.2)
  float targetShare = 0.85f;    // (0, 1]; S of the first frame, as a share of the atlas
  float targetLargest = 0.95f;  // [targetShare, 1]; S never grows past this
  float targetCut = 0.95f;      // (0, 1); factor on S when memory ran out or passed the high-water mark
  float targetGrowth = 1.002f;  // [1, 2]; factor on S in a frame after the quiet time
  int quietFrames = 40;         // [0, 1e6]; frames without pressure after which S grows
  float softWater = 0.8f;       // (0, 1]; share of the atlas that is live beyond which S shrinks by 1 /
                                // targetGrowth; with merge only
  float highWater = 0.9f;       // (0, 1]; share of the atlas cut into blocks beyond which memory is reset
  float hysteresis = 0.2f;      // [0, 2] in log2 of area and of aspect beyond half a step; negative for none
};

/// What a frame did. Texels are those of the superblocks unless said otherwise; live, end, stack,
/// inaccessible and free ones are all there are.
struct RectStatistics {
  std::uint32_t visiblePatches = 0;
  std::uint64_t samples = 0;      // texels to shade: blocks of visible patches, and one for each record
  std::uint64_t liveTexels = 0;   // blocks of visible patches
  std::uint64_t endTexels = 0;    // not yet cut, at the end of partly filled superblocks
  std::uint64_t stackTexels = 0;  // free blocks on stacks
  std::uint64_t inaccessibleTexels =
      0;                         // freed, but lost until their superblock is empty: strategies S2 and S3
  std::uint64_t freeTexels = 0;  // free superblocks
  std::uint32_t freeSuperblocks = 0;
  std::uint32_t records = 0;     // visible patches at one texel, failures included
  std::uint32_t blocksMade = 0;  // given to a patch, moved ones included
  std::uint32_t blocksMoved =
      0;  // patches with a block in the last frame that asked for another: level or reset
  std::uint64_t movedTexels = 0;  // of the blocks that those asked for
  std::uint32_t blocksFreed =
      0;  // given back for good, but for those that a reset takes from what went out of sight
  std::uint32_t blocksMerged = 0;
  std::uint32_t blocksReduced = 0;  // made smaller than asked for, for want of memory
  std::uint32_t blocksWaiting = 0;  // of earlier frames, smaller than their patches still want
  std::uint32_t failures = 0;       // requests that found no memory
  std::uint32_t resets = 0;         // since creation
  std::uint32_t frames = 0;         // since creation
  bool resetPending = false;        // asked for, and held back
  float load = 0.0f;                // share of the atlas cut into blocks
  float bias = 0.0f;                // constant and pressure bias together, log2 of area
  float target = 0.0f;              // S, texels
};

class RectMemory {
 public:
  RectMemory() = default;
  /// All memory that will ever be used is allocated here. Fails when a size is out of range or the stacks are
  /// larger than this context's storage blocks.
  static Result<RectMemory> create(gl::ProgramCache& programs, const RectMemoryOptions& options,
                                   std::uint32_t patchInstances);

  // Both calls read BIND_VISIBLE, allocate BIND_VISIBLE_MARK, and measure the scene's buffers and BIND_VIEWS,
  // which the caller has bound. `dispatch` holds the groups of RECT_GROUP over the visible list as uvec3 at
  // offset 0.

  /// The ideal size of every visible patch, over `viewCount` views, 1 to RECT_VIEWS. `program` is another
  /// permutation of pass/rect_measure.comp, or null for the plain one.
  void measure(const gl::Buffer& dispatch, std::uint32_t viewCount, const gl::Program* program = nullptr);
  /// Level selection and the three phases. Afterwards each visible patch's PatchState says where it lives.
  /// `frame` is the value that the marks of visible patches have.
  void allocate(const gl::Buffer& dispatch, std::uint32_t frame);
  /// Binds what later passes read: patch states and atlas state.
  void bind() const;

  /// Frees everything at the next allocate() that may reset.
  void reset() { resetAsked_ = true; }
  /// While held, no allocate() resets memory, neither by reset() nor by pressure: a stream waits for its next
  /// I-frame. RectStatistics::resetPending says that one is due.
  void holdReset(bool held) { resetHeld_ = held; }
  /// The constant bias from the next frame on, see RectMemoryOptions::bias.
  void setBias(float bias);

  /// The texture: superblocks, and below them a texel a patch instance.
  [[nodiscard]] int textureWidth() const { return static_cast<int>(config_.width); }
  [[nodiscard]] int textureHeight() const;
  [[nodiscard]] std::size_t bytes() const;

  /// Statistics of the newest frame of which they have arrived: RectStatistics::frames says which. None
  /// before any have, always some from then on. They are of every frame while the GPU is up to kReadbacks - 2
  /// frames behind; farther behind some frames are left out. Never waits.
  [[nodiscard]] std::optional<RectStatistics> latestStatistics();
  static constexpr std::size_t kReadbacks = 4;

  // For tests and reports: these wait for the GPU.
  [[nodiscard]] RectStatistics readStatistics() const;
  [[nodiscard]] glsl::AtlasState readState() const;
  /// States of the patches that the last allocate() placed.
  [[nodiscard]] std::vector<glsl::PatchState> readVisible() const;
  /// Live blocks are those that patch states hold, visible or not.
  [[nodiscard]] MemorySnapshot readSnapshot() const;

  [[nodiscard]] gl::Buffer& stateBuffer() { return state_; }
  [[nodiscard]] const gl::Buffer& patchStates() const { return patches_; }
  [[nodiscard]] gl::Buffer& measures() { return measures_; }

 private:
  void bindPhases() const;

  glsl::AtlasConfig config_{};
  bool resetAsked_ = false;
  bool resetHeld_ = false;
  gl::Buffer state_;        // AtlasState
  gl::Buffer stacks_;       // uint[]: the block stacks, one behind the other
  gl::Buffer superblocks_;  // uint[2 * superblocks]: the stack of free ones, and texels live in each
  gl::Buffer mergeMap_;     // uint[]: a bit a pair of texels
  gl::Buffer patches_;      // PatchState[patch instances]
  gl::Buffer measures_;     // PatchMeasure[patch instances], in the order of the visible list
  gl::Buffer live_;         // uint count, uint ids[]: the last frame's visible list
  const gl::Program* measure_ = nullptr;
  const gl::Program* plan_ = nullptr;
  const gl::Program* merge_ = nullptr;
  const gl::Program* request_ = nullptr;
  const gl::Program* provision_ = nullptr;
  const gl::Program* assign_ = nullptr;
  gl::Readback readback_;
};

}  // namespace tessera
