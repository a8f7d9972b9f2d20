// Debug pictures, and checks that read the atlas back.
#include <array>
#include <cmath>
#include <cstring>

#include <glm/gtc/type_ptr.hpp>

#include "engine/frame/engine_state.hpp"
#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

constexpr const char* kScreenModes[] = {"0", "1", "2", "3"};  // see pass/debug_screen.comp

}  // namespace

Result<Image> Engine::debugView(DebugView what, const View& view) {
  State& s = *s_;
  if (s.gatherer() == nullptr)
    return fail("{}: the plan has no atlas, so there is nothing to show of it", s.scene.file);
  const auto guard = s.guard();
  if (what == DebugView::Atlas) return readAtlas();
  if (!s.atlas) return fail("{}: this view is the rectangular atlas's", s.scene.file);
  gl::Texture target(GL_RGBA8, what == DebugView::Blocks ? s.atlas->atlas().texture.width() : view.width,
                     what == DebugView::Blocks ? s.atlas->atlas().texture.height() : view.height);
  s.moveAnchor(s.placedAnchor);
  s.bindScene();
  s.atlas->bind();
  gl::api().MemoryBarrier(GL_ALL_BARRIER_BITS);
  if (what == DebugView::Blocks) {
    auto program = s.programs.get({"pass/debug_blocks.vert", "pass/debug_blocks.frag"});
    if (!program) return tl::unexpected(program.error());
    const std::array<const gl::Texture*, 1> colors = {&target};
    const gl::Framebuffer framebuffer(colors);
    gl::apply({});
    const std::array<float, 4> dark = {0.05f, 0.05f, 0.05f, 1.0f};
    gl::api().ClearNamedFramebufferfv(framebuffer.get(), GL_COLOR, 0, dark.data());
    gl::api().BindFramebuffer(GL_FRAMEBUFFER, framebuffer.get());
    gl::api().Viewport(0, 0, target.width(), target.height());
    (*program)->use();
    gl::api().ProgramUniform2f((*program)->get(), LOCATION_SIZE, 2.0f / static_cast<float>(target.width()),
                               2.0f / static_cast<float>(target.height()));
    s.atlas->drawBatches(0, static_cast<std::uint32_t>(s.draw.batches.size()), 0);
  } else {
    auto program =
        s.programs.get({"pass/debug_screen.comp"}, {{"MODE", kScreenModes[static_cast<std::size_t>(what)]}});
    if (!program) return tl::unexpected(program.error());
    s.setViews({&view, 1});
    s.atlas->memory().bind();
    s.ids().bind(UNIT_ID);
    gl::api().BindImageTexture(0, target.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
    (*program)->use();
    const glm::mat3 rays(pixelToRay(view));
    gl::api().ProgramUniformMatrix3fv((*program)->get(), LOCATION_VIEW, 1, GL_FALSE, glm::value_ptr(rays));
    gl::dispatchOver(view.width, view.height);
  }
  return flipped(target.width(), target.height(), gl::readTexture(target, GL_RGBA, GL_UNSIGNED_BYTE, 4));
}

std::uint64_t Engine::nonFiniteTexels() const {
  const Gatherer* gatherer = s_->gatherer();
  if (gatherer == nullptr) return 0;
  const AtlasFormat format = gatherer->atlas().format;
  if (format != AtlasFormat::Rgba16f && format != AtlasFormat::R11g11b10f) return 0;
  const auto guard = s_->guard();
  const auto bytes = gl::readTexture(gatherer->atlas().texture, GL_RGBA, GL_FLOAT, 4 * sizeof(float));
  std::uint64_t bad = 0;
  for (std::size_t i = 0; i < bytes.size(); i += 4 * sizeof(float)) {
    std::array<float, 4> texel{};
    std::memcpy(texel.data(), bytes.data() + i, sizeof(texel));
    for (const float value : texel)
      if (!std::isfinite(value)) {
        ++bad;
        break;
      }
  }
  return bad;
}

}  // namespace tessera
