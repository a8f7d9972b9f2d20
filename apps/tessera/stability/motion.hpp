// A scene and a slow way around in it, for cases of many frames.
#pragma once

#include <cmath>
#include <numbers>

#include "apps/tessera/stability/bench.hpp"
#include "engine/scene/build.hpp"

namespace tessera::stability {

/// How far two pictures of equal atlases may be apart, of 255: where atomics put a block changes its
/// coordinates, and with them the last bit of what a texel interpolates and stores (1), and of the filter's
/// weights (1).
constexpr double kLastBits = 2.0;

/// A textured, lit room whose triangles are of all sizes.
inline Scene hall() {
  Scene scene = build::emptyScene();
  Material material;
  material.roughnessFactor = 0.4f;
  material.doubleSided = true;
  material.baseColor.image = build::addCheckers(scene, 64, 8);
  const auto lit = build::addMaterial(scene, material);
  build::place(scene, build::addGrid(scene, {-3, -1, 2}, {6, 0, 0}, {0, 0, -8}, 1, 1, lit));
  build::place(scene, build::addGrid(scene, {-3, -1, -6}, {6, 0, 0}, {0, 3, 0}, 7, 5, lit));
  build::place(scene, build::addGrid(scene, {-1, 0.5f, -4}, {0.9f, 0, 0}, {0, 0.9f, 0}, 30, 30, lit));
  build::place(scene, build::addGrid(scene, {0.4f, -0.9f, -1}, {0.1f, 0, -2}, {0, 1.2f, 0}, 1, 9, lit));
  build::finish(scene);
  return scene;
}

inline Stage hallLights() {
  Stage stage;
  StageLight lamp;
  lamp.light.castsShadow = true;
  lamp.keys.push_back({0.0, {0.5, 1.5, -1.0}, {0, 0, -4}, glm::vec3(1.0f), 20.0f});
  stage.lights.push_back(lamp);
  stage.ambient = Ambient{glm::vec3(0.2f), glm::vec3(0.1f)};
  return stage;
}

/// `turn` of a closed way, 0 and 1 the same view to the bit.
inline View onTheWay(double turn) {
  const double angle = 2.0 * std::numbers::pi * (turn - std::floor(turn));
  return look({0.8 * std::sin(angle), 0.3 * std::sin(2.0 * angle), 1.0 - 0.5 * (1.0 - std::cos(angle))},
              {0.3 * std::sin(angle), 0, -4});
}

}  // namespace tessera::stability
