// Passes of the atlas: place, shade, display.
#include <algorithm>
#include <cmath>

#include <glm/gtc/type_ptr.hpp>

#include "engine/frame/engine_state.hpp"
#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

void setVec2(const gl::Program& program, GLint location, float x, float y) {
  gl::api().ProgramUniform2f(program.get(), location, x, y);
}

}  // namespace

Result<void> Engine::place(std::span<const View> views, const PlaceOptions& options) {
  State& s = *s_;
  if (options.foveation)
    if (auto good = check(*options.foveation); !good) return good;
  if (options.lens)
    if (auto good = check(*options.lens); !good) return good;
  Gatherer* gatherer = s.gatherer();
  if (gatherer == nullptr || views.empty()) return {};
  if (s.texel && (options.foveation || options.lens))
    return fail("{}: texel shading takes its levels from pixels: neither foveation nor a lens changes them",
                s.scene.file);
  const auto guard = s.guard();
  const auto placed = views.first(std::min(views.size(), kMaxViews));
  auto measure = s.measureProgram(options);
  if (!measure) return tl::unexpected(measure.error());
  s.moveAnchor(s.anchorFor(placed.front()));
  s.placedAnchor = s.anchor;
  s.bindScene();
  s.setViews(placed);
  if (*measure != nullptr) s.setDensities(placed, options);
  const auto count = static_cast<std::uint32_t>(placed.size());
  s.pass("levels", [&] { gatherer->selectLevels(*s.visible, count, *measure); });
  s.pass("memory", [&] { gatherer->allocate(*s.visible); });
  s.pass("emit", [&] { gatherer->emit(*s.visible); });
  return {};
}

void Engine::shade(const View& view, const ShadeOptions& options) {
  State& s = *s_;
  const Gatherer* gatherer = s.gatherer();
  if (gatherer == nullptr) return;
  const auto guard = s.guard();
  s.moveAnchor(s.placedAnchor);
  s.bindScene();
  s.setViews({&view, 1});
  gatherer->bind();
  const AtlasTexture& atlas = gatherer->atlas();
  const auto width = static_cast<float>(atlas.texture.width());
  const auto height = static_cast<float>(atlas.texture.height());
  const float textureBias =
      std::isnan(options.textureBias) ? 0.0f : std::clamp(options.textureBias, -2.0f, 1.0f);
  s.pass("gather", [&] {
    gl::apply({.encodeSrgb = !gatherer->encodes()});
    gatherer->beginShading();
    s.counted([&] {
      for (std::uint32_t b = 0; b < s.draw.batches.size(); ++b) {
        const BatchPrograms& programs = s.batchPrograms[b];
        programs.gather->use();
        if (gatherer->rasters()) setVec2(*programs.gather, LOCATION_SIZE, 2.0f / width, 2.0f / height);
        if (programs.shading.usesUv0 || programs.shading.usesUv1)
          programs.gather->set(LOCATION_TEXTURE_BIAS, textureBias);
        s.buffers.bindMaterial(s.draw.batches[b].material, programs.shading);
        gatherer->shadeBatch(*programs.gather, b);
      }
    });
    gatherer->endShading();
  });
}

void Engine::display(const View& view, DisplayMode mode) {
  State& s = *s_;
  const auto guard = s.guard();
  s.moveAnchor(s.gatherer() != nullptr ? s.placedAnchor : s.anchorFor(view));
  s.bindScene();
  s.setViews({&view, 1});
  s.beginPicture(view);
  // Background in the encoding of the target: display copies encoded texels, so its clear must be encoded
  // too.
  const glm::vec4 linearBackground(s.options.background, 0.0f);
  const glm::vec4 background = s.encodedBackground();
  // Always through the framebuffer that is drawn to next: zink (Mesa 22.3) defers clears, and applies one
  // that was made through another view of the texture in the wrong encoding.
  const auto clear = [&](const gl::Framebuffer& target, const float* color) {
    gl::api().ClearNamedFramebufferfv(target.get(), GL_COLOR, 0, color);
    gl::api().ClearNamedFramebufferfv(target.get(), GL_DEPTH, 0, &s.depth.farthest);
  };
  const Gatherer* gatherer = s.gatherer();
  if (gatherer == nullptr) {
    gl::apply({.depthWrite = true, .encodeSrgb = true});
    clear(s.picture.framebuffer, &linearBackground.x);
    s.drawTransparent(view, "rect-transparent", s.picture.depth);
    return;
  }
  gatherer->bind();
  const AtlasTexture& atlas = gatherer->atlas();
  const float texelX = 1.0f / static_cast<float>(atlas.texture.width());
  const float texelY = 1.0f / static_cast<float>(atlas.texture.height());
  atlas.display().bind(UNIT_ATLAS);
  const bool linear = atlas.format != AtlasFormat::Srgb8;

  // Of the two forms the plan may have only one; that one draws, whichever was asked for.
  const bool planned =
      s.graph.find(mode == DisplayMode::Deferred ? "display-deferred" : "display") != nullptr;
  const bool deferred = planned ? mode == DisplayMode::Deferred : mode != DisplayMode::Deferred;
  if (deferred && s.deferred != nullptr) {
    s.pass("display-deferred", [&] {
      s.deferred->use();
      s.ids().bind(UNIT_ID);
      gl::api().BindImageTexture(0, s.picture.encoded.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
      setVec2(*s.deferred, LOCATION_SIZE, texelX, texelY);
      const glm::mat3 rays(pixelToRay(view));
      gl::api().ProgramUniformMatrix3fv(s.deferred->get(), LOCATION_VIEW, 1, GL_FALSE, glm::value_ptr(rays));
      gl::api().ProgramUniform4fv(s.deferred->get(), LOCATION_BACKGROUND, 1, &background.x);
      gl::dispatchOver(view.width, view.height);
    });
    s.drawTransparent(view, "rect-transparent", s.idDepth());
    State::afterPictureStore();
    return;
  }
  s.pass("display", [&] {
    const gl::Framebuffer& target = linear ? s.picture.framebuffer : s.picture.encodedFramebuffer;
    gl::api().BindFramebuffer(GL_FRAMEBUFFER, target.get());
    gl::api().Viewport(0, 0, view.width, view.height);
    gl::apply({.depth = s.depth.nearer, .depthWrite = true, .encodeSrgb = linear});
    clear(target, linear ? &linearBackground.x : &background.x);
    for (std::uint32_t first = 0; first < s.draw.batches.size();) {
      const Batch& batch = s.draw.batches[first];
      if (batch.blend) break;  // the last ones: drawTransparent shows them
      std::uint32_t last = first + 1;
      while (!batch.mask && last < s.draw.batches.size() && !s.draw.batches[last].mask &&
             !s.draw.batches[last].blend && s.draw.batches[last].doubleSided == batch.doubleSided)
        ++last;
      const BatchPrograms& programs = s.batchPrograms[first];
      if (batch.mask) {
        s.buffers.bindMaterial(batch.material, programs.depth);
      }
      // Entries are counter-clockwise in the world, mirrored or not (see the emit passes).
      gl::applyCulling(!batch.doubleSided, false);
      for (std::size_t list = 0; list < programs.display.size(); ++list) {
        programs.display[list]->use();
        setVec2(*programs.display[list], LOCATION_SIZE, texelX, texelY);
        gatherer->drawBatches(first, last - first, static_cast<std::uint32_t>(list));
      }
      first = last;
    }
  });
  s.drawTransparent(view, "rect-transparent", s.picture.depth);
}

}  // namespace tessera
