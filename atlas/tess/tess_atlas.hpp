// The tessellation gatherer (Hladky 2019): each visible triangle has a slot of its own, whose samples are
// even on the picture.
#pragma once

#include <span>
#include <string>

#include "atlas/gatherer.hpp"
#include "atlas/tess/tess_memory.hpp"
#include "atlas/tess/tess_split.hpp"
#include "glsl/shared/blocks.h"

namespace tessera {

/// How samples are spawned. All write the same texels.
enum class TessGather : std::uint8_t {
  Raster,   // a fragment a texel of the slots' rectangles
  Compute,  // a thread a sample, over a prefix sum of the triangles' samples
  Tess,     // a tessellation vertex a sample (Hladky 2019, sec. 3.1)
  Deferred  // tessellation vertices note which samples there are, a thread each shades them
};

/// How display finds a point of a triangle among the samples of its L.
enum class TessDecode : std::uint8_t {
  Exact,  // what is linear over the triangle is reproduced
  Plain   // Hladky 2019, eq. 4: off by up to 0.15 of a step between samples on the lines from the corners
};

/// By default what was fastest on every context measured (ratios of gather in README): groups of 64 to 512
/// are within each other's spread, groups of 32 behind on one, the other ways 1.5 to 10 times as slow.
struct TessSpawn {
  TessGather gather = TessGather::Compute;
  int group = 64;  // threads of a group of Compute and Deferred: 32, 64, 128, 256 or 512
};

struct TessAtlasOptions {
  TessMemoryOptions memory;
  AtlasFormat format = AtlasFormat::Srgb8;
  TessSpawn spawn;
  TessDecode decode = TessDecode::Exact;
};

/// "raster", "tess", "deferred" or "compute-N".
std::string nameOf(const TessSpawn& spawn);
/// Fails for a group that is not one of the five.
Result<void> check(const TessSpawn& spawn);

class TessAtlas final : public Gatherer {
 public:
  /// Fails where check(spawn) does, an option is out of range, or the texture is past this context's limits.
  /// `triangles` is the number of triangle numbers, see triangleNumber; `batches` the triangles of each.
  static Result<TessAtlas> create(gl::ProgramCache& programs, const TessAtlasOptions& options,
                                  std::uint32_t triangles, std::span<const glsl::BatchGpu> batches);

  void selectLevels(const VisibleSet& visible, std::uint32_t viewCount, const gl::Program* measure) override;
  void allocate(const VisibleSet& visible) override;
  void emit(const VisibleSet& visible) override;
  void bind() const override;
  void beginShading() const override;
  void shadeBatch(const gl::Program& program, std::uint32_t batch) const override;
  void drawBatches(std::uint32_t first, std::uint32_t count, std::uint32_t list) const override;
  [[nodiscard]] bool rasters() const override { return spawn_.gather == TessGather::Raster; }
  [[nodiscard]] bool encodes() const override { return true; }
  [[nodiscard]] const AtlasTexture& atlas() const override { return atlas_; }
  [[nodiscard]] std::uint64_t readSamples() const override { return memory_.readStatistics().samples; }
  void endShading() const override;
  [[nodiscard]] std::size_t bytes() const override;
  [[nodiscard]] GatherStatistics readStatistics() const override;
  [[nodiscard]] std::vector<std::uint8_t> readKinds() const override;

  /// The files of the gather program, and what they are compiled with besides the material's switches.
  struct GatherProgram {
    std::vector<std::string> files;
    gl::Defines defines;
  };
  static GatherProgram gatherProgram(const TessAtlasOptions& options);
  /// What display's programs are compiled with.
  static gl::Defines displayDefines(const TessAtlasOptions& options);
  /// Another way to spawn the samples of what is placed, from the next beginShading() on. The programs must
  /// be its own.
  void setSpawn(const TessSpawn& spawn);
  [[nodiscard]] const TessSpawn& spawn() const { return spawn_; }

  [[nodiscard]] const TessSplit& split() const { return split_; }
  [[nodiscard]] const TessMemory& memory() const { return memory_; }
  [[nodiscard]] TessMemory& memory() { return memory_; }

 private:
  /// Counts each batch's samples, and says where those of its entries begin.
  void countSamples() const;
  /// Has the tessellator note them.
  void enumerate() const;

  TessMemory memory_;
  TessSplit split_;
  AtlasTexture atlas_;
  std::uint32_t batchCount_ = 0;
  std::uint32_t triangles_ = 0;
  TessSpawn spawn_;
  gl::Buffer entryOf_;   // uint[triangles + kSplitNumbers]: its entry
  gl::Buffer entries_;   // TessEntry[entries]
  gl::Buffer vertices_;  // TessVertex[3 * entries]
  gl::Buffer batches_;   // BatchGpu[batches], firstEntry as of this frame
  gl::Buffer corners_;   // TessCorner[3 * entries]
  gl::Buffer
      commands_;  // TessCommand[(3 + kDisplayLists) * batches]: entries, raster, pieces, display's lists
  gl::Buffer emptyCommands_;
  gl::Buffer pieces_;   // uvec2[]: entry, first sample
  gl::Buffer starts_;   // uint[entries]
  gl::Buffer groups_;   // TessGroups[batches]
  gl::Buffer samples_;  // uint[]: entry of each sample, for TessGather::Deferred
  gl::VertexArray displayArray_;
  gl::VertexArray gatherArray_;
  const gl::Program* emit_ = nullptr;
  const gl::Program* scan_ = nullptr;
  const gl::Program* bases_ = nullptr;
  const gl::Program* enumerate_ = nullptr;
};

}  // namespace tessera
