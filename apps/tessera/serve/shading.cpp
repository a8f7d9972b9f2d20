#include "apps/tessera/serve/shading.hpp"

namespace tessera::app {

void holdReset(Engine& engine, bool held) {
  if (RectAtlas* atlas = engine.atlas(); atlas != nullptr) atlas->memory().holdReset(held);
  if (TessAtlas* tess = engine.tess(); tess != nullptr) tess->memory().holdReset(held);
}

void shadeForVideo(Engine& engine, const View& from, const ShadeOptions& options, bool iFrame) {
  const gl::Texture& atlas = engine.gatherer()->atlas().encoded;
  if (iFrame) gl::api().ClearTexImage(atlas.get(), 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  engine.shade(from, options);
}

wire::VisibleFrame visibleFrame(std::span<const wire::VisibleElement> elements,
                                std::span<const wire::ObjectTransform> objects, const wire::Camera& camera,
                                const View& own, const View& later) {
  const double reach = glm::length(later.eye - own.eye) + 4.0 * own.zNear;
  return {elements, objects, {}, wire::boundOf(camera, kVertexPixels, reach), own.eye};
}

}  // namespace tessera::app
