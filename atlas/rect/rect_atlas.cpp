#include "atlas/rect/rect_atlas.hpp"

namespace tessera {

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

  atlas.draw_ = PatchDraw(patchInstances, entries, batches);
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
  memory_.bind();
  draw_.emit(*emit_, visible);
}

void RectAtlas::bind() const { draw_.bind(); }

void RectAtlas::drawBatches(std::uint32_t first, std::uint32_t count, std::uint32_t /*list*/) const {
  draw_.draw(first, count);
}

std::size_t RectAtlas::bytes() const { return atlas_.texture.bytes() + draw_.bytes() + memory_.bytes(); }

}  // namespace tessera
