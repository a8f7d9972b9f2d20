// What the atlas is compared with: forward's picture upsampled, and warped to another view.
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

WarpSource Engine::warpSource(const View& drawn) const {
  return {&s_->picture.encoded, &s_->picture.depth, drawn};
}

Result<void> Engine::warp(const View& from, const View& to) {
  State& s = *s_;
  if (!s.warp) return fail("{}: the plan has no warping", s.scene.file);
  const auto guard = s.guard();
  Result<void> drawn;
  s.spare.resize(to.width, to.height, &s.depth);
  s.pass("warp", [&] {
    drawn = s.warp->draw(Warp::Mesh, warpSource(from), to, s.spare.encodedFramebuffer, s.encodedBackground());
  });
  if (!drawn) return fail("{}: {}", s.scene.file, drawn.error().message);
  std::swap(s.picture, s.spare);
  s.throughLens = false;
  return {};
}

}  // namespace tessera
