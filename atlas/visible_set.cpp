#include "atlas/visible_set.hpp"

#include <algorithm>

#include "glsl/shared/bindings.h"

namespace tessera {

Result<VisibleSet> VisibleSet::create(gl::ProgramCache& programs, VisibleElement element,
                                      std::uint32_t capacity, bool pixels) {
  VisibleSet set;
  gl::Defines defines;
  if (element == VisibleElement::Triangle) defines.emplace("TRIANGLES", "1");
  if (pixels) {
    defines.emplace("PIXELS", "1");
    auto inOrder = programs.get({"pass/visible_pixels.comp"});
    if (!inOrder) return tl::unexpected(inOrder.error());
    set.inOrder_ = *inOrder;
    set.pixels_ = gl::Buffer(std::size_t{capacity} * sizeof(std::uint32_t));
    set.seen_ = gl::Buffer(std::size_t{capacity} * sizeof(std::uint32_t));
  }
  auto mark = programs.get({"pass/visible_mark.comp"}, defines);
  if (!mark) return tl::unexpected(mark.error());
  defines.emplace("LAYERS", "1");
  auto markLayers = programs.get({"pass/visible_mark.comp"}, defines);
  if (!markLayers) return tl::unexpected(markLayers.error());
  auto finish = programs.get({"pass/visible_finish.comp"});
  if (!finish) return tl::unexpected(finish.error());
  set.mark_ = *mark;
  set.markLayers_ = *markLayers;
  set.finish_ = *finish;
  set.element_ = element;
  set.capacity_ = capacity;
  set.list_ = gl::Buffer((std::size_t{1} + capacity) * sizeof(std::uint32_t));
  set.marks_ = gl::Buffer(std::size_t{capacity} * sizeof(std::uint32_t));
  set.dispatch_ = gl::Buffer(4 * sizeof(std::uint32_t));
  return set;
}

void VisibleSet::begin() {
  // Frame numbers start at 1, so that freshly zeroed marks mean "never seen"; after 2^32 - 1 frames all start
  // over.
  // The last frame's shaders wrote what is cleared here.
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  if (++frame_ == 0) {
    marks_.fill(0);
    frame_ = 1;
  }
  list_.fill(0, 0, sizeof(std::uint32_t));
  dispatch_.fill(0, 3 * sizeof(std::uint32_t), sizeof(std::uint32_t));
  if (pixels_) pixels_.fill(0);
}

void VisibleSet::add(const gl::Texture& ids) {
  bindMarking();
  ids.bind(UNIT_ID);
  const gl::Program& mark = ids.layers() > 0 ? *markLayers_ : *mark_;
  mark.use();
  mark.set(LOCATION_FRAME, frame_);
  constexpr int kGroup = 16;
  gl::api().DispatchCompute(static_cast<GLuint>((ids.width() + kGroup - 1) / kGroup),
                            static_cast<GLuint>((ids.height() + kGroup - 1) / kGroup),
                            static_cast<GLuint>(std::max(ids.layers(), 1)));
  gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void VisibleSet::finish() {
  bind();
  finish_->use();
  gl::api().DispatchCompute(1, 1, 1);
}

void VisibleSet::bind() const {
  list_.bindStorage(BIND_VISIBLE);
  marks_.bindStorage(BIND_VISIBLE_MARK);
  dispatch_.bindStorage(BIND_DISPATCH);
}

void VisibleSet::bindMarking() const {
  bind();
  if (pixels_) pixels_.bindStorage(BIND_VISIBLE_PIXELS);
}

std::vector<std::uint32_t> VisibleSet::read() const {
  const auto count = list_.readAll<std::uint32_t>(1)[0];
  return list_.readAll<std::uint32_t>(count, sizeof(std::uint32_t));
}

std::uint32_t VisibleSet::readEmptyPixels() const {
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  return dispatch_.readAll<std::uint32_t>(1, 3 * sizeof(std::uint32_t))[0];
}

std::vector<std::uint32_t> VisibleSet::readPixels() const {
  if (!pixels_) return {};
  bindMarking();
  seen_.bindStorage(BIND_VISIBLE_SEEN);
  gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
  inOrder_->use();
  gl::dispatchIndirect(dispatch_);
  const auto count = list_.readAll<std::uint32_t>(1)[0];
  return seen_.readAll<std::uint32_t>(count);
}

}  // namespace tessera
