// The rectangular gatherer: patches in blocks of one texture (Mueller 2021, ch. 3). It places the visible
// set, is shaded into by whoever owns the materials, and is drawn from for any view.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "atlas/rect/memory.hpp"
#include "atlas/visible_set.hpp"
#include "engine/gl/program.hpp"
#include "glsl/shared/blocks.h"

namespace tessera {

enum class AtlasFormat : std::uint8_t {
  Srgb8,   // display-encoded 8 bits a channel: what a video codec takes
  Rgba16f  // linear half floats: nothing is lost, and a value that is not finite can be found
};

struct RectAtlasOptions {
  RectMemoryOptions memory;
  AtlasFormat format = AtlasFormat::Srgb8;
};

class RectAtlas {
 public:
  /// `entries` is how many draw entries all patch instances need (a triple needs two), `batches` how many
  /// draws.
  static Result<RectAtlas> create(gl::ProgramCache& programs, const RectAtlasOptions& options,
                                  std::uint32_t patchInstances, std::uint32_t entries,
                                  std::span<const glsl::BatchGpu> batches);

  /// Level of each visible patch; the views are in the uniform buffer BIND_VIEWS. `measure`: see
  /// RectMemory::measure.
  void selectLevels(const VisibleSet& visible, std::uint32_t viewCount, const gl::Program* measure = nullptr);
  /// The three phases; afterwards every visible patch has a block or its record texel.
  void allocate(const VisibleSet& visible);
  /// Writes what shading and display draw.
  void emit(const VisibleSet& visible);

  /// Starts shading: binds the atlas as the framebuffer. Then, a batch at a time, drawBatch() with a program
  /// of pass/gather.vert in use.
  void beginShading() const;
  void drawBatch(std::uint32_t batch) const { drawBatches(batch, 1); }
  /// Draws the entries of consecutive batches, for display, with a program of pass/display.vert in use.
  void drawBatches(std::uint32_t first, std::uint32_t count) const;
  /// Binds vertices and buffers that gather and display read.
  void bind() const;

  [[nodiscard]] const gl::Texture& texture() const { return texture_; }
  /// The texture as display samples it: encoded values where the format has them, so that a fetch is a copy.
  [[nodiscard]] const gl::Texture& displayTexture() const { return encoded_ ? encoded_ : texture_; }
  [[nodiscard]] AtlasFormat format() const { return format_; }
  [[nodiscard]] const RectMemory& memory() const { return memory_; }
  [[nodiscard]] RectMemory& memory() { return memory_; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  RectMemory memory_;
  AtlasFormat format_ = AtlasFormat::Srgb8;
  gl::Texture texture_;
  gl::Texture encoded_;
  gl::Framebuffer framebuffer_;
  gl::Buffer entries_;   // uint[patch instances]: first draw entry | mirrored << 31
  gl::Buffer vertices_;  // DisplayVertex[4 * entries]
  gl::Buffer gather_;    // GatherVertex[4 * entries]
  gl::Buffer batches_;   // BatchGpu[batches]
  gl::Buffer commands_;  // DrawCommand[batches]
  gl::Buffer emptyCommands_;
  gl::Buffer indices_;
  gl::VertexArray vertexArray_;
  const gl::Program* emit_ = nullptr;
};

}  // namespace tessera
