// Counts that need a blocking readback: for reports and tests.
#include <algorithm>
#include <array>
#include <cstring>

#include "engine/frame/engine_state.hpp"
#include "glsl/shared/tess_measure.h"

namespace tessera {

namespace {

/// The geometry of a patch instance and the instance it belongs to.
struct PatchPlace {
  const glsl::PatchGeometry& geometry;
  const Instance& instance;
};

PatchPlace placeOf(const DrawScene& draw, std::uint32_t patch) {
  const std::uint32_t index = draw.instanceOfPatch[patch];
  const Instance& instance = draw.instances[index];
  return {draw.patches[draw.patchOffset[instance.primitive] + patch - draw.patchBase[index]], instance};
}

}  // namespace

std::uint64_t Engine::visibleTriangles() const {
  std::uint64_t triangles = 0;
  if (!s_->visible) return triangles;
  const auto guard = s_->guard();
  if (s_->tess) return s_->visible->read().size();
  for (const std::uint32_t patch : s_->visible->read())
    triangles += placeOf(s_->draw, patch).geometry.triangles;
  return triangles;
}

double Engine::readBackgroundShare() const {
  if (!s_->visible || s_->viewPixels == 0) return 0.0;
  const auto guard = s_->guard();
  return static_cast<double>(s_->visible->readEmptyPixels()) / static_cast<double>(s_->viewPixels);
}

std::vector<std::uint32_t> Engine::readVisiblePixels() const {
  if (!s_->visible) return {};
  const auto guard = s_->guard();
  return s_->visible->readPixels();
}

std::vector<std::uint32_t> Engine::readIds() const {
  const State& s = *s_;
  const gl::Texture& texture = s.ids();
  if (!texture) return {};
  const auto guard = s.guard();
  const auto bytes = gl::readTexture(texture, GL_RED_INTEGER, GL_UNSIGNED_INT, sizeof(std::uint32_t));
  const auto width = static_cast<std::size_t>(texture.width());
  const auto height = static_cast<std::size_t>(texture.height());
  std::vector<std::uint32_t> ids(width * height);
  for (std::size_t y = 0; y < height; ++y)
    std::memcpy(ids.data() + y * width, bytes.data() + (height - 1 - y) * width * sizeof(std::uint32_t),
                width * sizeof(std::uint32_t));
  return ids;
}

double Engine::slantOf(std::uint32_t id, const View& view) const {
  const State& s = *s_;
  const PatchPlace place = placeOf(s.draw, (id >> 2U) - 1);
  const glsl::PatchGeometry& g = place.geometry;
  const std::array<std::uint32_t, 5> fan = {g.v0, g.v1, g.v2, g.v3, g.v4};
  const std::size_t part = std::min<std::size_t>(id & 3U, 2);
  const auto corner = [&](std::uint32_t vertex) {
    const glm::dvec3 world(s.now.world[place.instance.node] *
                           glm::dvec4(s.scene.vertices.position[vertex], 1.0));
    return glm::vec3(world - view.eye);
  };
  const glsl::TessMeasure measure =
      glsl::measureTriangle(corner(fan[0]), corner(fan[part + 1]), corner(fan[part + 2]),
                            static_cast<float>(view.pixelsPerRadian()));
  const float longest = glsl::longestOf(measure);
  if (!(longest > glsl::kSingleLength)) return 0.0;
  return static_cast<double>(longest / std::max(measure.height, glsl::kFlattest * longest));
}

std::uint64_t Engine::samplesPartlyInView(const View& view) const {
  const State& s = *s_;
  if (!s.atlas) return 0;
  const auto guard = s.guard();
  const auto states = s.atlas->memory().patchStates().readAll<glsl::PatchState>(s.draw.patchInstances);
  const glm::dmat4 toClip = viewProjection(view, {0.0, 0.0, 0.0});
  std::uint64_t samples = 0;
  for (const std::uint32_t patch : s.visible->read()) {
    const PatchPlace place = placeOf(s.draw, patch);
    const glsl::PatchGeometry& g = place.geometry;
    const bool leaves = [&] {
      for (const std::uint32_t vertex : {g.v0, g.v1, g.v2, g.v3, g.v4}) {
        const glm::dvec4 world =
            s.now.world[place.instance.node] * glm::dvec4(s.scene.vertices.position[vertex], 1.0);
        const glm::dvec4 clip = toClip * world;
        if (clip.w <= 0.0 || std::max(std::abs(clip.x), std::abs(clip.y)) > clip.w) return true;
      }
      return false;
    }();
    if (leaves) samples += glsl::levelTexels(states[patch].level);
  }
  return samples;
}

}  // namespace tessera
