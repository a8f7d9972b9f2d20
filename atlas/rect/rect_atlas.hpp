// The rectangular gatherer: patches in blocks of one texture (Mueller 2021, ch. 3). It places the visible
// set, is shaded into by whoever owns the materials, and is drawn from for any view.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "atlas/gatherer.hpp"
#include "atlas/patch_draw.hpp"
#include "atlas/rect/memory.hpp"

namespace tessera {

struct RectAtlasOptions {
  RectMemoryOptions memory;
  AtlasFormat format = AtlasFormat::Srgb8;
};

class RectAtlas final : public Gatherer {
 public:
  /// `entries` is how many draw entries all patch instances need (a triple needs two), `batches` how many
  /// draws.
  static Result<RectAtlas> create(gl::ProgramCache& programs, const RectAtlasOptions& options,
                                  std::uint32_t patchInstances, std::uint32_t entries,
                                  std::span<const glsl::BatchGpu> batches);

  void selectLevels(const VisibleSet& visible, std::uint32_t viewCount, const gl::Program* measure) override;
  /// The three phases; afterwards every visible patch has a block or its record texel.
  void allocate(const VisibleSet& visible) override;
  void emit(const VisibleSet& visible) override;
  void bind() const override;
  /// With a program of pass/gather.vert in use.
  void shadeBatch(const gl::Program& /*program*/, std::uint32_t batch) const override {
    draw_.draw(batch, 1);
  }
  /// With a program of pass/display.vert in use.
  void drawBatches(std::uint32_t first, std::uint32_t count, std::uint32_t list) const override;
  [[nodiscard]] const AtlasTexture& atlas() const override { return atlas_; }
  [[nodiscard]] std::uint64_t readSamples() const override { return memory_.readStatistics().samples; }
  [[nodiscard]] std::size_t bytes() const override;
  [[nodiscard]] GatherStatistics readStatistics() const override;
  [[nodiscard]] std::vector<std::uint8_t> readKinds() const override;

  [[nodiscard]] const RectMemory& memory() const { return memory_; }
  [[nodiscard]] RectMemory& memory() { return memory_; }

 private:
  RectMemory memory_;
  AtlasTexture atlas_;
  PatchDraw draw_;
  const gl::Program* emit_ = nullptr;
};

}  // namespace tessera
