#include "atlas/tess/tess_atlas.hpp"

#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

constexpr std::uint32_t kEntryVertices = 3;
constexpr std::uint32_t kRasterVertices = 12;  // two rectangles

void drawIndirect(GLenum mode, const gl::VertexArray& array, const gl::Buffer& commands, std::uint32_t first,
                  std::uint32_t count) {
  gl::api().BindVertexArray(array.get());
  gl::api().BindBuffer(GL_DRAW_INDIRECT_BUFFER, commands.get());
  gl::api().MultiDrawArraysIndirect(mode, reinterpret_cast<const void*>(first * sizeof(glsl::TessCommand)),
                                    static_cast<GLsizei>(count), 0);
}

}  // namespace

std::string nameOf(const TessSpawn& spawn) {
  switch (spawn.gather) {
    case TessGather::Raster:
      return "raster";
    case TessGather::Tess:
      return "tess";
    case TessGather::Deferred:
      return "deferred";
    case TessGather::Compute:
      break;
  }
  return "compute-" + std::to_string(spawn.group);
}

Result<void> check(const TessSpawn& spawn) {
  for (const int group : {32, 64, 128, 256, 512})
    if (spawn.group == group) return {};
  return fail("gather: a group of {} threads is not one of 32, 64, 128, 256, 512", spawn.group);
}

Result<TessAtlas> TessAtlas::create(gl::ProgramCache& programs, const TessAtlasOptions& options,
                                    std::uint32_t triangles, std::span<const glsl::BatchGpu> batches) {
  if (auto good = check(options.spawn); !good) return tl::unexpected(good.error());
  TessAtlas atlas;
  auto memory = TessMemory::create(programs, options.memory, triangles);
  if (!memory) return tl::unexpected(memory.error());
  atlas.memory_ = std::move(*memory);
  auto split = TessSplit::create(programs, triangles, static_cast<std::uint32_t>(batches.size()));
  if (!split) return tl::unexpected(split.error());
  atlas.split_ = std::move(*split);
  auto emit = programs.get({"pass/tess_emit.comp"});
  if (!emit) return tl::unexpected(emit.error());
  atlas.emit_ = *emit;
  auto scan = programs.get({"pass/tess_scan.comp"});
  if (!scan) return tl::unexpected(scan.error());
  atlas.scan_ = *scan;
  auto bases = programs.get({"pass/tess_bases.comp"});
  if (!bases) return tl::unexpected(bases.error());
  atlas.bases_ = *bases;
  auto enumerate =
      programs.get({"pass/tess_spawn.vert", "pass/tess_enumerate.tesc", "pass/tess_enumerate.tese"});
  if (!enumerate) return tl::unexpected(enumerate.error());
  atlas.enumerate_ = *enumerate;
  auto texture =
      AtlasTexture::create(atlas.memory_.textureWidth(), atlas.memory_.textureHeight(), options.format);
  if (!texture) return tl::unexpected(texture.error());
  atlas.atlas_ = std::move(*texture);

  std::vector<glsl::TessCommand> commands;
  std::size_t entries = 0;
  for (const std::uint32_t vertices : {kEntryVertices, kRasterVertices})
    for (const glsl::BatchGpu& batch : batches) commands.push_back({0, 1, vertices * batch.firstEntry, 0});
  // A triangle has another piece for each time that it has as many texels as a tessellator spawns.
  const auto area =
      static_cast<std::size_t>(options.memory.width) * static_cast<std::size_t>(options.memory.height);
  const std::size_t morePieces = area / glsl::kTessMostSamples;
  std::size_t pieces = 0;
  for (const glsl::BatchGpu& batch : batches) {
    commands.push_back({0, 1, static_cast<glsl::uint>(pieces), 0});
    pieces += batch.entryCapacity + morePieces;
    entries += batch.entryCapacity;
  }
  for (std::uint32_t list = 0; list < glsl::kDisplayLists; ++list)
    for (const glsl::BatchGpu& batch : batches) {
      const std::uint32_t entry = batch.firstEntry + (list == glsl::kDisplayAffine ? 0 : batch.entryCapacity);
      commands.push_back({0, 1, kEntryVertices * entry, 0});
    }
  // All of the pieces of triangles may be one batch's, and move what follows.
  pieces += glsl::kSplitNumbers;
  entries += glsl::kSplitNumbers;
  atlas.pieces_ = gl::Buffer(pieces * sizeof(glsl::uvec2));
  atlas.starts_ = gl::Buffer(entries * sizeof(glsl::uint));
  atlas.groups_ = gl::Buffer(batches.size() * sizeof(glsl::TessGroups));
  atlas.batchCount_ = static_cast<std::uint32_t>(batches.size());
  atlas.triangles_ = triangles;
  atlas.batches_ = gl::Buffer(batches, 0);
  atlas.commands_ = gl::Buffer(commands);
  atlas.emptyCommands_ = gl::Buffer(commands, 0);
  atlas.entryOf_ = gl::Buffer((std::size_t{triangles} + glsl::kSplitNumbers) * sizeof(glsl::uint));
  atlas.entries_ = gl::Buffer(entries * sizeof(glsl::TessEntry));
  atlas.vertices_ = gl::Buffer(kEntryVertices * entries * sizeof(glsl::TessVertex));
  atlas.corners_ = gl::Buffer(kEntryVertices * entries * sizeof(glsl::TessCorner));
  atlas.displayArray_ = gl::VertexArray::make();
  atlas.displayArray_.attribute(0, atlas.corners_, 4, sizeof(glsl::TessCorner));
  const GLuint array = atlas.displayArray_.get();
  for (const GLuint location : {1u, 2u}) {
    gl::api().EnableVertexArrayAttrib(array, location);
    gl::api().VertexArrayAttribBinding(array, location, 0);
  }
  gl::api().VertexArrayAttribFormat(array, 1, 3, GL_FLOAT, GL_FALSE, offsetof(glsl::TessCorner, a));
  gl::api().VertexArrayAttribIFormat(array, 2, 3, GL_UNSIGNED_INT, offsetof(glsl::TessCorner, place0));
  atlas.gatherArray_ = gl::VertexArray::make();
  atlas.setSpawn(options.spawn);
  return atlas;
}

void TessAtlas::selectLevels(const VisibleSet& visible, std::uint32_t viewCount, const gl::Program* measure) {
  memory_.bind();
  memory_.setViewCount(viewCount);
  entryOf_.bindStorage(BIND_DRAW_ENTRIES);
  split_.list(visible);
  memory_.measure(split_.dispatch(), measure);
}

void TessAtlas::allocate(const VisibleSet& visible) {
  visible.bind();
  split_.bind();
  memory_.allocate(split_.dispatch(), visible.frame());
}

void TessAtlas::emit(const VisibleSet&) {
  split_.bind();
  bind();
  memory_.bind();
  // The last frame's counts came from a shader.
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl::api().CopyNamedBufferSubData(emptyCommands_.get(), commands_.get(), 0, 0,
                                   static_cast<GLsizeiptr>(commands_.size()));
  split_.makeRoom();
  corners_.bindStorage(BIND_TESS_CORNERS);
  emit_->use();
  emit_->set(LOCATION_COUNT, batchCount_);
  emit_->set(LOCATION_FRAME, triangles_);
  gl::dispatchIndirect(split_.dispatch());
}

void TessAtlas::bind() const {
  entryOf_.bindStorage(BIND_DRAW_ENTRIES);
  vertices_.bindStorage(BIND_DRAW_VERTICES);
  entries_.bindStorage(BIND_GATHER_VERTICES);
  commands_.bindStorage(BIND_DRAW_COMMANDS);
  batches_.bindStorage(BIND_BATCHES);
  pieces_.bindStorage(BIND_TESS_PIECES);
}

void TessAtlas::setSpawn(const TessSpawn& spawn) {
  spawn_ = spawn;
  if (spawn.gather != TessGather::Deferred || samples_) return;
  // Slots lie in the atlas, and texels of their own in the record rows.
  samples_ = gl::Buffer(static_cast<std::size_t>(atlas_.texture.width()) *
                        static_cast<std::size_t>(atlas_.texture.height()) * sizeof(glsl::uint));
}

void TessAtlas::countSamples() const {
  starts_.bindStorage(BIND_TESS_STARTS);
  groups_.bindStorage(BIND_TESS_GROUPS);
  scan_->use();
  scan_->set(LOCATION_COUNT, static_cast<unsigned>(spawn_.group));
  gl::api().DispatchCompute(batchCount_, 1, 1);
  gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
}

void TessAtlas::enumerate() const {
  samples_.bindStorage(BIND_TESS_SAMPLES);
  bases_->use();
  bases_->set(LOCATION_COUNT, batchCount_);
  gl::api().DispatchCompute(1, 1, 1);
  gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  enumerate_->use();
  gl::api().PatchParameteri(GL_PATCH_VERTICES, 1);
  gl::api().Enable(GL_RASTERIZER_DISCARD);
  for (std::uint32_t batch = 0; batch < batchCount_; ++batch) {
    enumerate_->set(LOCATION_COUNT, batch);
    drawIndirect(GL_PATCHES, gatherArray_, commands_, 2 * batchCount_ + batch, 1);
  }
  gl::api().Disable(GL_RASTERIZER_DISCARD);
  gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void TessAtlas::beginShading() const {
  // A draw wants a complete framebuffer even for what it discards, and a host may have none bound.
  if (spawn_.gather != TessGather::Compute) Gatherer::beginShading();
  if (spawn_.gather == TessGather::Raster) return;
  const gl::Texture& target = atlas_.display();
  gl::api().BindImageTexture(0, target.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, target.format());
  if (spawn_.gather == TessGather::Tess) {
    gl::api().PatchParameteri(GL_PATCH_VERTICES, 1);
    gl::api().Enable(GL_RASTERIZER_DISCARD);
    return;
  }
  countSamples();
  if (spawn_.gather == TessGather::Deferred) enumerate();
}

void TessAtlas::endShading() const {
  if (spawn_.gather == TessGather::Tess) gl::api().Disable(GL_RASTERIZER_DISCARD);
  if (spawn_.gather != TessGather::Raster)
    gl::api().MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
                            GL_FRAMEBUFFER_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

gl::Defines TessAtlas::displayDefines(const TessAtlasOptions& options) {
  gl::Defines defines;
  if (options.decode == TessDecode::Plain) defines.emplace("PLAIN_DECODE", "1");
  return defines;
}

TessAtlas::GatherProgram TessAtlas::gatherProgram(const TessAtlasOptions& options) {
  GatherProgram program;
  if (options.format == AtlasFormat::Srgb8) program.defines.emplace("ENCODED", "1");
  switch (options.spawn.gather) {
    case TessGather::Raster:
      program.files = {"pass/tess_raster.vert", "pass/tess_raster.frag"};
      break;
    case TessGather::Compute:
    case TessGather::Deferred:
      program.files = {"pass/tess_gather.comp"};
      program.defines.emplace("GROUP", std::to_string(options.spawn.group));
      if (options.spawn.gather == TessGather::Deferred) program.defines.emplace("LISTED", "1");
      break;
    case TessGather::Tess:
      program.files = {"pass/tess_spawn.vert", "pass/tess_spawn.tesc", "pass/tess_spawn.tese"};
      break;
  }
  return program;
}

void TessAtlas::shadeBatch(const gl::Program& program, std::uint32_t batch) const {
  switch (spawn_.gather) {
    case TessGather::Raster:
      drawIndirect(GL_TRIANGLES, gatherArray_, commands_, batchCount_ + batch, 1);
      return;
    case TessGather::Compute:
    case TessGather::Deferred:
      program.set(LOCATION_COUNT, batch);
      gl::dispatchIndirect(groups_, batch * sizeof(glsl::TessGroups));
      return;
    case TessGather::Tess:
      drawIndirect(GL_PATCHES, gatherArray_, commands_, 2 * batchCount_ + batch, 1);
      return;
  }
}

void TessAtlas::drawBatches(std::uint32_t first, std::uint32_t count, std::uint32_t list) const {
  drawIndirect(GL_TRIANGLES, displayArray_, commands_, (3 + list) * batchCount_ + first, count);
}

std::size_t TessAtlas::bytes() const {
  return atlas_.texture.bytes() + memory_.bytes() + split_.bytes() + entryOf_.size() + entries_.size() +
         vertices_.size() + corners_.size() + commands_.size() + pieces_.size() + starts_.size() +
         groups_.size() + samples_.size();
}

}  // namespace tessera
