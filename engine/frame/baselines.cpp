// What the atlas is compared with: forward's picture upsampled, and warped to another view.
#include <glm/gtc/type_ptr.hpp>

#include "engine/frame/engine_state.hpp"
#include "glsl/shared/bindings.h"

namespace tessera {

Result<void> Engine::upsample(int width, int height) {
  State& s = *s_;
  if (s.upsampleColumns == nullptr) return fail("{}: the plan has no upsampling", s.scene.file);
  if (!s.picture.color) return fail("{}: no picture was drawn yet to be upsampled", s.scene.file);
  const int fromWidth = s.picture.color.width();
  const int fromHeight = s.picture.color.height();
  if (width < fromWidth || height < fromHeight)
    return fail("upsampling from {} x {} to {} x {}: not larger", fromWidth, fromHeight, width, height);
  const auto guard = s.guard();
  if (!s.upsampledRows || s.upsampledRows.width() != width || s.upsampledRows.height() != fromHeight)
    s.upsampledRows = gl::Texture(GL_RGBA16F, width, fromHeight);
  s.pass("upsample-rows", [&] {
    s.upsampleRows->use();
    s.picture.encoded.bind(UNIT_PICTURE);
    gl::api().BindImageTexture(0, s.upsampledRows.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA16F);
    gl::dispatchOver(width, fromHeight);
  });
  s.spare.resize(width, height, &s.depth);
  s.pass("upsample-columns", [&] {
    s.upsampleColumns->use();
    s.upsampledRows.bind(UNIT_PICTURE);
    gl::api().BindImageTexture(0, s.spare.encoded.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
    const glm::vec4 background = s.encodedBackground();
    gl::api().ProgramUniform4fv(s.upsampleColumns->get(), LOCATION_BACKGROUND, 1, &background.x);
    gl::dispatchOver(width, height);
  });
  State::afterPictureStore();
  std::swap(s.picture, s.spare);
  s.throughLens = false;
  return {};
}

Result<void> Engine::warp(const View& from, const View& to) {
  State& s = *s_;
  if (s.warp == nullptr) return fail("{}: the plan has no warping", s.scene.file);
  if (!s.picture.color || s.picture.color.width() != from.width || s.picture.color.height() != from.height)
    return fail("{}: no picture of {} x {} was drawn yet to be warped", s.scene.file, from.width,
                from.height);
  const auto guard = s.guard();
  const glm::dmat4 toClip = viewProjection(to, from.eye);
  const glm::dmat3 rays = pixelToRay(from);
  glm::dmat4 columns(0.0);
  for (int i = 0; i < 3; ++i) columns[i] = toClip * glm::dvec4(rays[i], 0.0);
  columns[3] = toClip * glm::dvec4(0.0, 0.0, 0.0, 1.0 / from.zNear);
  const glm::mat4 placeToClip(columns);
  const glm::vec4 background = s.encodedBackground();
  s.spare.resize(to.width, to.height, &s.depth);
  if (!s.emptyVertices.get()) s.emptyVertices = gl::VertexArray::make();
  s.pass("warp", [&] {
    const gl::Framebuffer& target = s.spare.encodedFramebuffer;
    gl::api().BindFramebuffer(GL_FRAMEBUFFER, target.get());
    gl::api().Viewport(0, 0, to.width, to.height);
    gl::apply({.depth = gl::DepthTest::GreaterEqual, .depthWrite = true});
    const float farthest = 0.0f;
    gl::api().ClearNamedFramebufferfv(target.get(), GL_COLOR, 0, &background.x);
    gl::api().ClearNamedFramebufferfv(target.get(), GL_DEPTH, 0, &farthest);
    s.warp->use();
    s.picture.encoded.bind(UNIT_PICTURE);
    s.picture.depth.bind(UNIT_DEPTH);
    gl::api().ProgramUniformMatrix4fv(s.warp->get(), LOCATION_VIEW, 1, GL_FALSE, glm::value_ptr(placeToClip));
    gl::api().BindVertexArray(s.emptyVertices.get());
    gl::api().DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 2 * (from.width + 2), from.height + 1);
  });
  std::swap(s.picture, s.spare);
  s.throughLens = false;
  return {};
}

}  // namespace tessera
