#include "atlas/patch_draw.hpp"

#include <algorithm>
#include <vector>

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

PatchDraw::PatchDraw(std::uint32_t patchInstances, std::uint32_t entries,
                     std::span<const glsl::BatchGpu> batches)
    : entries_(std::size_t{patchInstances} * sizeof(glsl::uint)),
      vertices_(std::size_t{4} * entries * sizeof(glsl::DisplayVertex)),
      gather_(std::size_t{4} * entries * sizeof(glsl::GatherVertex)),
      batches_(batches, 0) {
  std::uint32_t longest = 0;
  std::vector<glsl::DrawCommand> commands;
  for (const glsl::BatchGpu& batch : batches) {
    longest = std::max(longest, batch.entryCapacity);
    commands.push_back({0, 1, 0, 4 * batch.firstEntry, 0});
  }
  commands_ = gl::Buffer(commands);
  emptyCommands_ = gl::Buffer(commands, 0);
  indices_ = gl::Buffer(entryIndices(longest), 0);
  vertexArray_ = gl::VertexArray::make();
  vertexArray_.indices(indices_);
  vertexArray_.attribute(0, vertices_, 3, sizeof(glsl::DisplayVertex));
  const GLuint array = vertexArray_.get();
  const auto addInteger = [&](GLuint attribute, std::size_t offset) {
    gl::api().EnableVertexArrayAttrib(array, attribute);
    gl::api().VertexArrayAttribIFormat(array, attribute, 1, GL_UNSIGNED_INT, static_cast<GLuint>(offset));
    gl::api().VertexArrayAttribBinding(array, attribute, 0);
  };
  addInteger(1, offsetof(glsl::DisplayVertex, texel));
  addInteger(2, offsetof(glsl::DisplayVertex, block));
}

void PatchDraw::emit(const gl::Program& program, const VisibleSet& visible) const {
  visible.bind();
  bind();
  // The last frame's counts came from a shader.
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl::api().CopyNamedBufferSubData(emptyCommands_.get(), commands_.get(), 0, 0,
                                   static_cast<GLsizeiptr>(commands_.size()));
  program.use();
  gl::dispatchIndirect(visible.dispatch());
}

void PatchDraw::bind() const {
  entries_.bindStorage(BIND_DRAW_ENTRIES);
  vertices_.bindStorage(BIND_DRAW_VERTICES);
  gather_.bindStorage(BIND_GATHER_VERTICES);
  commands_.bindStorage(BIND_DRAW_COMMANDS);
  batches_.bindStorage(BIND_BATCHES);
}

void PatchDraw::draw(std::uint32_t firstBatch, std::uint32_t count) const {
  gl::api().BindVertexArray(vertexArray_.get());
  gl::api().BindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.get());
  gl::api().MultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT,
                                      reinterpret_cast<const void*>(firstBatch * sizeof(glsl::DrawCommand)),
                                      static_cast<GLsizei>(count), 0);
}

std::size_t PatchDraw::bytes() const {
  return entries_.size() + vertices_.size() + gather_.size() + commands_.size() + indices_.size();
}

std::uint64_t PatchDraw::readVertices() const {
  constexpr std::uint64_t kVertices = 4;  // a draw entry
  constexpr std::uint64_t kIndices = 6;
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  std::uint64_t entries = 0;
  for (const glsl::DrawCommand& command :
       commands_.readAll<glsl::DrawCommand>(commands_.size() / sizeof(glsl::DrawCommand)))
    entries += command.count / kIndices;
  return entries * kVertices;
}

}  // namespace tessera
