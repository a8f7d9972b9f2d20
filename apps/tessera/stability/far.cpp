// Scenes far from the origin, tiny and huge ones.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "apps/tessera/stability/case.hpp"
#include "apps/tessera/stability/exact.hpp"
#include "engine/scene/build.hpp"

namespace tessera::stability {

namespace {

/// A lit and textured room corner with a board in it, under node 1.
Scene corner() {
  Scene scene = build::emptyScene();
  scene.nodes.resize(2);
  Material material;
  material.roughnessFactor = 0.5f;
  material.metallicFactor = 0.2f;
  material.baseColor.image = build::addCheckers(scene, 64, 8);
  const auto lit = build::addMaterial(scene, material);
  build::place(scene, build::addGrid(scene, {-2, -1, 0}, {4, 0, 0}, {0, 0, -4}, 5, 5, lit), 1);
  build::place(scene, build::addGrid(scene, {-2, -1, -4}, {4, 0, 0}, {0, 3, 0}, 4, 3, lit), 1);
  build::place(scene, build::addGrid(scene, {-0.7f, -0.6f, -2}, {1.5f, 0.3f, 0}, {0, 0.8f, -0.6f}, 1, 1, lit),
               1);
  return scene;
}

/// A point light makes wrong positions visible, a directional one with a shadow wrong matrices.
Stage lights(const glm::dvec3& offset, bool point = true) {
  Stage stage;
  StageLight sun;
  sun.light.type = LightType::Directional;
  sun.light.castsShadow = true;
  sun.keys.push_back(
      {0.0, offset + glm::dvec3(1, 5, 2), offset + glm::dvec3(0.2, 0, -2), glm::vec3(1.0f), 2.0f});
  stage.lights.push_back(sun);
  if (!point) return stage;
  StageLight lamp;
  lamp.keys.push_back({0.0, offset + glm::dvec3(0.4, 0.3, -1.5), offset, glm::vec3(1.0f), 4.0f});
  stage.lights.push_back(lamp);
  return stage;
}

std::vector<View> viewsFrom(const glm::dvec3& offset, double scale = 1.0) {
  return {look(offset + scale * glm::dvec3(0.3, 0.5, 1.5), offset + scale * glm::dvec3(0, -0.2, -3), 60.0,
               0.01 * scale),
          look(offset + scale * glm::dvec3(-1.2, -0.8, -0.7), offset + scale * glm::dvec3(0.5, -0.6, -3),
               70.0, 0.01 * scale)};
}

Shot shotAt(const glm::dvec3& offset, double scale = 1.0) {
  Shot shot{corner(), lights(offset, scale == 1.0), viewsFrom(offset, scale)};
  shot.scene.nodes[1].translation = offset;
  shot.scene.nodes[1].scale = glm::dvec3(scale);
  build::finish(shot.scene);
  return shot;
}

/// The same with another scene's worth of triangles where the origin is, which the views do not show.
Shot islandAt(const glm::dvec3& offset) {
  Shot shot = shotAt(offset);
  const std::size_t count = shot.scene.instances.size();
  for (std::size_t i = 0; i < count; ++i) build::place(shot.scene, shot.scene.instances[i].primitive, 0);
  // The shadow map covers the whole scene, so its texels would be as large as the way between the islands.
  shot.stage->lights[0].light.castsShadow = false;
  build::finish(shot.scene);
  return shot;
}

glm::dvec3 away(double distance) { return glm::dvec3(0.36, 0.48, -0.8) * distance; }

/// Points of a metre around `offset`, seen from beside them: where they land in a picture 1080 high, in
/// pixels off the exact place. `relative`: positions and eye are taken from an anchor in double before they
/// become floats.
double worstLanding(double distance, bool relative) {
  const glm::dvec3 offset = away(distance);
  const View view = lookAt(offset + glm::dvec3(0.3, 0.2, 2.0), offset, 60.0, 1920, 1080, 0.01);
  const glm::dvec3 anchor = relative ? offset : glm::dvec3(0.0);
  const glsl::ViewGpu gpu = viewGpu(view, anchor);
  const glm::dmat4 exactMatrix = viewProjection(view, offset);
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 p(0.5 * std::sin(i * 1.7), 0.5 * std::sin(i * 2.3 + 1.0), 0.5 * std::sin(i * 3.1 + 2.0));
    const glm::vec4 at = gpu.viewProjection * glm::vec4(glm::vec3(p + offset - anchor), 1.0f);
    const glm::dvec4 truth = exactMatrix * glm::dvec4(p, 1.0);
    worst = std::max({worst, std::abs(static_cast<double>(at.x / at.w) - truth.x / truth.w) * 960.0,
                      std::abs(static_cast<double>(at.y / at.w) - truth.y / truth.w) * 540.0});
  }
  return worst;
}

}  // namespace

void addFarCases(Cases& cases) {
  for (const double distance : {1e3, 1e4, 1e5, 1e6, 1e7})
    cases.push_back(
        {fmt::format("far/moved-1e{}", static_cast<int>(std::lround(std::log10(distance)))),
         "a scene, its lights and its cameras so far from the origin: the picture is the one at the origin",
         "dB", 50.0, Sense::AtLeast,
         [distance](Bench& bench) { return leastPsnr(bench, shotAt({}), shotAt(away(distance))); }});
  cases.push_back({"far/moved-1e5-world-fails", "the same with positions relative to the origin of the world",
                   "dB", 30.0, Sense::AtMost, [](Bench& bench) {
                     EngineOptions options;
                     options.forms.cameraRelative = false;
                     return leastPsnr(bench, shotAt({}), shotAt(away(1e5)), options);
                   }});
  for (const double distance : {1e4, 1e6})
    cases.push_back(
        {fmt::format("far/island-1e{}", static_cast<int>(std::lround(std::log10(distance)))),
         "part of the scene is at the origin, and what is looked at so far from it: no one anchor is near "
         "both",
         "dB", 50.0, Sense::AtLeast, [distance](Bench& bench) {
           Shot near = shotAt({});
           near.stage->lights[0].light.castsShadow = false;
           return leastPsnr(bench, near, islandAt(away(distance)));
         }});
  for (const double scale : {1e-4, 1e5})
    cases.push_back({scale < 1.0 ? "far/scale-1e-4" : "far/scale-1e5",
                     "a scene and its camera so many times as large: the picture is that of the original",
                     "dB", 50.0, Sense::AtLeast, [scale](Bench& bench) {
                       Shot original = shotAt({});
                       original.stage = lights({}, false);
                       Shot scaled = shotAt({}, scale);
                       scaled.stage = lights({}, false);
                       return leastPsnr(bench, original, scaled);
                     }});
  cases.push_back({"far/relative-landing", "where points 1e7 away land, relative to an anchor in double",
                   "pixels", 0.01, Sense::AtMost,
                   [](Bench&) -> Result<double> { return worstLanding(1e7, true); }});
  cases.push_back({"far/world-floats-fail", "the same at 1e5 with world coordinates as floats", "pixels", 1.0,
                   Sense::AtLeast, [](Bench&) -> Result<double> { return worstLanding(1e5, false); }});
}

}  // namespace tessera::stability
