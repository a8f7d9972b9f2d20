#include "atlas/rect/rect_atlas.hpp"

#include <algorithm>
#include <array>

#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

// Two triangles an entry; the same pattern serves every batch through its base vertex.
std::vector<std::uint32_t> entryIndices(std::uint32_t entries) {
  std::vector<std::uint32_t> indices;
  indices.reserve(std::size_t{6} * entries);
  for (std::uint32_t i = 0; i < entries; ++i)
    for (const std::uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) indices.push_back(4 * i + corner);
  return indices;
}

}  // namespace

Result<RectAtlas> RectAtlas::create(gl::ProgramCache& programs, const RectAtlasOptions& options,
                                    std::uint32_t patchInstances, std::uint32_t entries,
                                    std::span<const glsl::BatchGpu> batches) {
  RectAtlas atlas;
  auto memory = RectMemory::create(programs, options.memory, patchInstances);
  if (!memory) return tl::unexpected(memory.error());
  atlas.memory_ = std::move(*memory);
  auto emit = programs.get({"pass/rect_emit.comp"});
  if (!emit) return tl::unexpected(emit.error());
  atlas.emit_ = *emit;

  auto texture =
      AtlasTexture::create(atlas.memory_.textureWidth(), atlas.memory_.textureHeight(), options.format);
  if (!texture) return tl::unexpected(texture.error());
  atlas.atlas_ = std::move(*texture);

  atlas.entries_ = gl::Buffer(std::size_t{patchInstances} * sizeof(glsl::uint));
  atlas.vertices_ = gl::Buffer(std::size_t{4} * entries * sizeof(glsl::DisplayVertex));
  atlas.gather_ = gl::Buffer(std::size_t{4} * entries * sizeof(glsl::GatherVertex));
  std::uint32_t longest = 0;
  std::vector<glsl::DrawCommand> commands;
  for (const glsl::BatchGpu& batch : batches) {
    longest = std::max(longest, batch.entryCapacity);
    commands.push_back({0, 1, 0, 4 * batch.firstEntry, 0});
  }
  atlas.batches_ = gl::Buffer(batches, 0);
  atlas.commands_ = gl::Buffer(commands);
  atlas.emptyCommands_ = gl::Buffer(commands, 0);
  atlas.indices_ = gl::Buffer(entryIndices(longest), 0);
  atlas.vertexArray_ = gl::VertexArray::make();
  atlas.vertexArray_.indices(atlas.indices_);
  atlas.vertexArray_.attribute(0, atlas.vertices_, 3, sizeof(glsl::DisplayVertex));
  const GLuint array = atlas.vertexArray_.get();
  gl::api().EnableVertexArrayAttrib(array, 1);
  gl::api().VertexArrayAttribIFormat(array, 1, 1, GL_UNSIGNED_INT, offsetof(glsl::DisplayVertex, texel));
  gl::api().VertexArrayAttribBinding(array, 1, 0);
  return atlas;
}

void RectAtlas::selectLevels(const VisibleSet& visible, std::uint32_t viewCount, const gl::Program* measure) {
  visible.bind();
  memory_.measure(visible.dispatch(), viewCount, measure);
}

void RectAtlas::allocate(const VisibleSet& visible) {
  visible.bind();
  memory_.allocate(visible.dispatch(), visible.frame());
}

void RectAtlas::emit(const VisibleSet& visible) {
  visible.bind();
  bind();
  memory_.bind();
  // The last frame's counts came from a shader.
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl::api().CopyNamedBufferSubData(emptyCommands_.get(), commands_.get(), 0, 0,
                                   static_cast<GLsizeiptr>(commands_.size()));
  emit_->use();
  gl::api().BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, visible.dispatch().get());
  gl::api().DispatchComputeIndirect(0);
}

void RectAtlas::bind() const {
  entries_.bindStorage(BIND_DRAW_ENTRIES);
  vertices_.bindStorage(BIND_DRAW_VERTICES);
  gather_.bindStorage(BIND_GATHER_VERTICES);
  commands_.bindStorage(BIND_DRAW_COMMANDS);
  batches_.bindStorage(BIND_BATCHES);
}

void RectAtlas::drawBatches(std::uint32_t first, std::uint32_t count) const {
  gl::api().BindVertexArray(vertexArray_.get());
  gl::api().BindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.get());
  gl::api().MultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT,
                                      reinterpret_cast<const void*>(first * sizeof(glsl::DrawCommand)),
                                      static_cast<GLsizei>(count), 0);
}

std::size_t RectAtlas::bytes() const {
  return atlas_.texture.bytes() + entries_.size() + vertices_.size() + gather_.size() + commands_.size() +
         indices_.size() + memory_.bytes();
}

}  // namespace tessera
