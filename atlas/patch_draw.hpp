// What gatherers of patches draw: the visible patches' corners, binned by batch so that a batch is one draw.
#pragma once

#include <cstdint>
#include <span>

#include "atlas/visible_set.hpp"
#include "glsl/shared/blocks.h"

namespace tessera {

class PatchDraw {
 public:
  PatchDraw() = default;
  /// `entries` is how many draw entries all patch instances need (a triple needs two), `batches` how many
  /// draws.
  PatchDraw(std::uint32_t patchInstances, std::uint32_t entries, std::span<const glsl::BatchGpu> batches);

  /// Writes the visible patches by a program of pass/rect_emit.comp, whose other buffers are bound.
  void emit(const gl::Program& program, const VisibleSet& visible) const;
  void bind() const;
  void draw(std::uint32_t firstBatch, std::uint32_t count) const;
  [[nodiscard]] std::size_t bytes() const;
  /// Vertices that display reads of what emit() wrote; blocking readback.
  [[nodiscard]] std::uint64_t readVertices() const;

 private:
  gl::Buffer entries_;   // uint[patch instances]: first draw entry | mirrored << 31
  gl::Buffer vertices_;  // DisplayVertex[4 * entries]
  gl::Buffer gather_;    // GatherVertex[4 * entries]
  gl::Buffer batches_;   // BatchGpu[batches]
  gl::Buffer commands_;  // DrawCommand[batches]
  gl::Buffer emptyCommands_;
  gl::Buffer indices_;
  gl::VertexArray vertexArray_;
};

}  // namespace tessera
