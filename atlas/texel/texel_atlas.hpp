// Texel Shading as a gatherer (Hillesland & Yang 2016), the baseline of Hladky 2019, sec. 5.2: charts
// with mip levels, of which those tiles are shaded that pixels touch. See glsl/shared/texel.h.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "atlas/gatherer.hpp"
#include "atlas/patch_draw.hpp"
#include "glsl/shared/texel.h"

namespace tessera {

struct TexelAtlasOptions {
  int width = 4096;          // texels, [64, 16384], a multiple of 8
  int height = 2048;         // texels, [64, 16384], a multiple of 8; record rows come on top
  float bias = 0.0f;         // [-16, 16]; log2 of area: 1 halves the samples
  bool pressureBias = true;  // raise the bias when pixels ask for more tiles than there are slots
  float biasFloor = 0.0f;    // [-4, 0]; the lowest pressure bias
  AtlasFormat format = AtlasFormat::Srgb8;
};

/// What a frame did.
struct TexelStatistics {
  std::uint32_t visible = 0;  // patches; each has a record of one texel
  std::uint32_t marked = 0;   // tiles that pixels asked for
  std::uint32_t lost = 0;     // of them those past what can be written down
  std::uint32_t tiles = 0;    // that have a slot
  std::uint32_t slots = 0;
  std::uint64_t samples = 0;  // texels to shade, records included
  std::uint32_t kept = 0;     // tiles that had their slot in the last frame
  std::uint32_t coarser = 0;  // levels by which all tiles were made coarser, for want of slots
  std::uint32_t frames = 0;   // since creation
  float bias = 0.0f;          // constant and pressure bias together, log2 of area
  /// Of the threads that shade tiles, those that have no texel to shade.
  [[nodiscard]] double wasted() const {
    return tiles == 0 ? 0.0 : 1.0 - static_cast<double>(samples - visible) / (64.0 * tiles);
  }
};

class TexelAtlas final : public Gatherer {
 public:
  /// `charts`: one a patch instance; `entries` and `batches` as RectAtlas::create. Fails when an option is
  /// out of range or the texture is past this context's limits.
  static Result<TexelAtlas> create(gl::ProgramCache& programs, const TexelAtlasOptions& options,
                                   std::span<const glsl::TexelChart> charts, std::uint32_t entries,
                                   std::span<const glsl::BatchGpu> batches);

  void beginViews() override;
  void addViews(const gl::Texture& ids, std::span<const glm::mat3> pixelToRay) override;
  /// Levels are those of pixels, which addViews has seen: nothing is left to do.
  void selectLevels(const VisibleSet& /*visible*/, std::uint32_t /*viewCount*/,
                    const gl::Program* /*measure*/) override {}
  /// Without new views since the last one: nothing.
  void allocate(const VisibleSet& visible) override;
  void emit(const VisibleSet& visible) override;
  void bind() const override;
  void beginShading() const override;
  void shadeBatch(const gl::Program& program, std::uint32_t batch) const override;
  void endShading() const override;
  void drawBatches(std::uint32_t first, std::uint32_t count, std::uint32_t list) const override;
  [[nodiscard]] bool rasters() const override { return false; }
  [[nodiscard]] bool encodes() const override { return true; }
  [[nodiscard]] const AtlasTexture& atlas() const override { return atlas_; }
  [[nodiscard]] std::uint64_t readSamples() const override { return readCounts().samples; }
  [[nodiscard]] std::size_t bytes() const override;

  // These wait for the GPU.
  [[nodiscard]] TexelStatistics readCounts() const;
  [[nodiscard]] GatherStatistics readStatistics() const override;
  /// The tiles of the last frame that was placed.
  [[nodiscard]] std::vector<glsl::TexelTile> readTiles() const;

 private:
  /// What the passes before shading read and write.
  void bindMemory() const;
  [[nodiscard]] glsl::TexelState readState() const;

  AtlasTexture atlas_;
  PatchDraw draw_;
  glsl::TexelConfig config_{};
  std::uint32_t current_ = 0;  // half of table and tiles
  bool open_ = false;          // views were added that no allocate() has taken
  gl::Buffer state_;           // TexelState
  gl::Buffer charts_;          // TexelChart[patch instances]
  gl::Buffer table_;           // uint[2][table][2]
  gl::Buffer wanted_;          // uvec2[2 * wanted]
  gl::Buffer tiles_;           // TexelTile[2 * slots]
  gl::Buffer queue_;           // TexelTile[slots]
  gl::Buffer stack_;           // uint[slots]
  gl::Buffer batches_;         // TexelBatch[batches]
  gl::Buffer emptyBatches_;
  const gl::Program* openPass_ = nullptr;
  const gl::Program* mark_ = nullptr;
  const gl::Program* markLayers_ = nullptr;
  const gl::Program* fit_ = nullptr;
  const gl::Program* clear_ = nullptr;
  const gl::Program* coarsen_ = nullptr;
  const gl::Program* release_ = nullptr;
  const gl::Program* assign_ = nullptr;
  const gl::Program* emit_ = nullptr;
  const gl::Program* scan_ = nullptr;
  const gl::Program* queuePass_ = nullptr;
};

}  // namespace tessera
