#include "atlas/tess/tess_atlas.hpp"

#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

constexpr std::uint32_t kDisplayVertices = 3;   // an entry
constexpr std::uint32_t kGatherVertices = 12;  // two rectangles

void drawIndirect(const gl::VertexArray& array, const gl::Buffer& commands, std::uint32_t first, std::uint32_t count) {
  gl::api().BindVertexArray(array.get());
  gl::api().BindBuffer(GL_DRAW_INDIRECT_BUFFER, commands.get());
  gl::api().MultiDrawArraysIndirect(GL_TRIANGLES, reinterpret_cast<const void*>(first * sizeof(glsl::TessCommand)),
                                    static_cast<GLsizei>(count), 0);
}

}  // namespace

Result<TessAtlas> TessAtlas::create(gl::ProgramCache& programs, const TessAtlasOptions& options,
                                    std::uint32_t triangles, std::span<const glsl::BatchGpu> batches) {
  TessAtlas atlas;
  auto memory = TessMemory::create(programs, options.memory, triangles);
  if (!memory) return tl::unexpected(memory.error());
  atlas.memory_ = std::move(*memory);
  auto emit = programs.get({"pass/tess_emit.comp"});
  if (!emit) return tl::unexpected(emit.error());
  atlas.emit_ = *emit;
  auto texture = AtlasTexture::create(atlas.memory_.textureWidth(), atlas.memory_.textureHeight(), options.format);
  if (!texture) return tl::unexpected(texture.error());
  atlas.atlas_ = std::move(*texture);

  std::vector<glsl::TessCommand> commands;
  std::size_t entries = 0;
  for (const std::uint32_t vertices : {kDisplayVertices, kGatherVertices})
    for (const glsl::BatchGpu& batch : batches) commands.push_back({0, 1, vertices * batch.firstEntry, 0});
  for (const glsl::BatchGpu& batch : batches) entries += batch.entryCapacity;
  atlas.batchCount_ = static_cast<std::uint32_t>(batches.size());
  atlas.batches_ = gl::Buffer(batches, 0);
  atlas.commands_ = gl::Buffer(commands);
  atlas.emptyCommands_ = gl::Buffer(commands, 0);
  atlas.entryOf_ = gl::Buffer(std::size_t{triangles} * sizeof(glsl::uint));
  atlas.entries_ = gl::Buffer(entries * sizeof(glsl::TessEntry));
  atlas.vertices_ = gl::Buffer(3 * entries * sizeof(glsl::TessVertex));
  atlas.displayArray_ = gl::VertexArray::make();
  atlas.displayArray_.attribute(0, atlas.vertices_, 4, sizeof(glsl::TessVertex));
  atlas.gatherArray_ = gl::VertexArray::make();
  return atlas;
}

void TessAtlas::selectLevels(const VisibleSet& visible, std::uint32_t viewCount, const gl::Program* measure) {
  visible.bind();
  memory_.measure(visible.dispatch(), viewCount, measure);
}

void TessAtlas::allocate(const VisibleSet& visible) {
  visible.bind();
  memory_.allocate(visible.dispatch(), visible.frame());
}

void TessAtlas::emit(const VisibleSet& visible) {
  visible.bind();
  bind();
  memory_.bind();
  // The last frame's counts came from a shader.
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl::api().CopyNamedBufferSubData(emptyCommands_.get(), commands_.get(), 0, 0,
                                   static_cast<GLsizeiptr>(commands_.size()));
  emit_->use();
  emit_->set(LOCATION_COUNT, batchCount_);
  gl::api().BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, visible.dispatch().get());
  gl::api().DispatchComputeIndirect(0);
}

void TessAtlas::bind() const {
  entryOf_.bindStorage(BIND_DRAW_ENTRIES);
  vertices_.bindStorage(BIND_DRAW_VERTICES);
  entries_.bindStorage(BIND_GATHER_VERTICES);
  commands_.bindStorage(BIND_DRAW_COMMANDS);
  batches_.bindStorage(BIND_BATCHES);
}

void TessAtlas::shadeBatch(std::uint32_t batch) const {
  drawIndirect(gatherArray_, commands_, batchCount_ + batch, 1);
}

void TessAtlas::drawBatches(std::uint32_t first, std::uint32_t count) const {
  drawIndirect(displayArray_, commands_, first, count);
}

std::size_t TessAtlas::bytes() const {
  return atlas_.texture.bytes() + memory_.bytes() + entryOf_.size() + entries_.size() + vertices_.size() +
         commands_.size();
}

}  // namespace tessera
