// The tessellation gatherer (Hladky 2019): each visible triangle has a slot of its own, whose samples are even on the
// picture.
#pragma once

#include <span>

#include "atlas/gatherer.hpp"
#include "atlas/tess/tess_memory.hpp"
#include "glsl/shared/blocks.h"

namespace tessera {

struct TessAtlasOptions {
  TessMemoryOptions memory;
  AtlasFormat format = AtlasFormat::Srgb8;
};

class TessAtlas final : public Gatherer {
 public:
  /// `triangles` is the number of triangle numbers, see triangleNumber; `batches` the triangles of each.
  static Result<TessAtlas> create(gl::ProgramCache& programs, const TessAtlasOptions& options,
                                  std::uint32_t triangles, std::span<const glsl::BatchGpu> batches);

  void selectLevels(const VisibleSet& visible, std::uint32_t viewCount, const gl::Program* measure) override;
  void allocate(const VisibleSet& visible) override;
  void emit(const VisibleSet& visible) override;
  void bind() const override;
  void shadeBatch(std::uint32_t batch) const override;
  void drawBatches(std::uint32_t first, std::uint32_t count) const override;
  [[nodiscard]] const AtlasTexture& atlas() const override { return atlas_; }
  [[nodiscard]] std::uint64_t readSamples() const override { return memory_.readStatistics().samples; }
  [[nodiscard]] std::size_t bytes() const override;

  [[nodiscard]] const TessMemory& memory() const { return memory_; }
  [[nodiscard]] TessMemory& memory() { return memory_; }

 private:
  TessMemory memory_;
  AtlasTexture atlas_;
  std::uint32_t batchCount_ = 0;
  gl::Buffer entryOf_;        // uint[triangles]: its entry
  gl::Buffer entries_;        // TessEntry[entries]
  gl::Buffer vertices_;       // TessVertex[3 * entries]
  gl::Buffer batches_;        // BatchGpu[batches]
  gl::Buffer commands_;       // TessCommand[2 * batches]: display, then gather
  gl::Buffer emptyCommands_;
  gl::VertexArray displayArray_;
  gl::VertexArray gatherArray_;
  const gl::Program* emit_ = nullptr;
};

}  // namespace tessera
