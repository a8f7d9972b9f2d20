// Small scenes made in code, for tests of the frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/scene/build.hpp"
#include "engine/scene/stage.hpp"

namespace tessera::test {

using namespace build;

/// A room corner of three grids and a tilted quad, unlit, coloured linearly over each grid.
inline Scene cornerScene(bool colored = true) {
  Scene scene = emptyScene();
  const auto material = addMaterial(scene, unlit());
  place(scene, addGrid(scene, {0, 0, 0}, {4, 0, 0}, {0, 0, -4}, 5, 5, material, colored));
  place(scene, addGrid(scene, {0, 0, -4}, {4, 0, 0}, {0, 3, 0}, 4, 3, material, colored));
  place(scene, addGrid(scene, {0, 0, 0}, {0, 0, -4}, {0, 3, 0}, 3, 4, material, colored));
  place(scene, addGrid(scene, {1, 0.4f, -1}, {1.5f, 0.3f, 0}, {0, 0.8f, -0.6f}, 1, 1, material, colored));
  finish(scene);
  return scene;
}

/// A white wall behind a board that hides other parts of it from either eye. What is not shaded is black.
inline Scene whiteScene() {
  Scene scene = emptyScene();
  const auto white = addMaterial(scene, unlit());
  place(scene, addGrid(scene, {-4, -3, -4}, {8, 0, 0}, {0, 6, 0}, 40, 30, white));
  place(scene, addGrid(scene, {-0.3f, -0.4f, -1}, {0.6f, 0, 0}, {0, 0.8f, 0}, 4, 4, white));
  finish(scene);
  return scene;
}

/// White triangles that are hard to sample, once more mirrored: needles, flat ones, some that reach behind an
/// eye at the origin that looks along -z.
inline Scene hardScene() {
  Scene scene = emptyScene();
  Material white = unlit();
  white.doubleSided = true;
  const auto index = addMaterial(scene, white);
  const std::vector<glm::vec3> corners = {// needles, one of 1e7 to 1
                                          {-2, 1, -3},
                                          {2, 1.002f, -3},
                                          {2, 1, -3},
                                          {-2, 0.9f, -3},
                                          {2, 0.9f + 4e-7f, -3},
                                          {2, 0.9f, -3},
                                          {-1, -1, -3},
                                          {1, 1, -3},
                                          {1.0005f, 1.01f, -3},
                                          // no area: on a line, and a point
                                          {-1, 0.5f, -3},
                                          {0, 0.5f, -3},
                                          {1, 0.5f, -3},
                                          {0.3f, 0.3f, -2},
                                          {0.3f, 0.3f, -2},
                                          {0.3f, 0.3f, -2},
                                          // with a corner behind the eye, and two
                                          {-1, -0.6f, -5},
                                          {1, -0.6f, -5},
                                          {0.2f, -0.3f, 2},
                                          {-6, -1, -8},
                                          {-1.5f, 0.3f, 3},
                                          {-1.5f, -0.8f, 4},
                                          // the eye all but in its plane, and in it
                                          {-2, 1e-4f, -1},
                                          {2, 1e-4f, -4},
                                          {-2, 1e-4f, -6},
                                          {0, -1, -2},
                                          {0, 1, -2},
                                          {0, 0.2f, -6},
                                          // around the eye's own place, behind everything seen through it
                                          {-50, -40, -9},
                                          {50, -40, -9},
                                          {0, 70, -9}};
  const auto triangles = addTriangles(scene, corners, index);
  place(scene, triangles);
  scene.nodes.resize(2);
  scene.nodes[1].scale = {-1.0, 0.7, 1.0};
  scene.nodes[1].translation = {0.1, -0.2, -0.3};
  place(scene, triangles, 1);
  finish(scene);
  return scene;
}

/// Grids of a single-sided, a double-sided and a masked double-sided material around (0, 0, -5), once more
/// mirrored.
inline Scene sidesScene() {
  Scene scene = emptyScene();
  Material single = unlit();
  single.baseColorFactor = {0.9f, 0.2f, 0.2f, 1.0f};
  Material both;
  both.doubleSided = true;
  both.baseColorFactor = {0.2f, 0.9f, 0.2f, 1.0f};
  Material leaf = unlit();
  leaf.alphaMode = AlphaMode::Mask;
  leaf.doubleSided = true;
  leaf.baseColor.image = addCheckers(scene, 64, 8, true);
  scene.nodes.resize(2);
  scene.nodes[1].scale = {1.0, 1.0, -1.0};
  scene.nodes[1].translation = {0.0, 1.3, -10.0};
  int column = 0;
  for (const Material& material : {single, both, leaf}) {
    const auto grid = addGrid(scene, {-2.5f + 1.8f * static_cast<float>(column++), -0.5f, -5.0f},
                              {1.2f, 0, 0}, {0, 1, 0}, 2, 2, addMaterial(scene, material));
    for (std::uint32_t node = 0; node < 2; ++node) place(scene, grid, node);
  }
  finish(scene);
  return scene;
}

inline Stage sunStage() {
  Stage stage;
  StageLight sun;
  sun.light.type = LightType::Directional;
  sun.keys.push_back({0.0, {0, 5, 0}, {0.4, 0, -5}, glm::vec3(1.0f), 3.0f});
  stage.lights.push_back(sun);
  return stage;
}

/// A floor to the camera's feet of two triangles, a wall of middling ones and one of less than a pixel, a
/// slanted board; textured, normal-mapped and lit.
inline Scene everythingScene() {
  Scene scene = emptyScene();
  Material material;
  material.roughnessFactor = 0.4f;
  material.baseColor.image = addCheckers(scene, 64, 8);
  material.normal.image = material.baseColor.image;
  const auto lit = addMaterial(scene, material);
  place(scene, addGrid(scene, {-3, -1, 2}, {6, 0, 0}, {0, 0, -8}, 1, 1, lit));
  place(scene, addGrid(scene, {-3, -1, -6}, {6, 0, 0}, {0, 3, 0}, 7, 5, lit));
  place(scene, addGrid(scene, {-1, 0.5f, -4}, {0.9f, 0, 0}, {0, 0.9f, 0}, 90, 90, lit));
  place(scene, addGrid(scene, {0.4f, -0.9f, -1}, {0.1f, 0, -2}, {0, 1.2f, 0}, 1, 9, lit));
  place(scene, addGrid(scene, {-2, -0.9f, -3}, {1.5f, 0, 0}, {0, 1.3f, 0}, 1, 1, lit));
  scene.vertices.tangent.assign(scene.vertices.position.size(), glm::vec4(1, 0, 0, 1));
  finish(scene);
  return scene;
}

inline Stage lampStage() {
  Stage stage;
  StageLight lamp;
  lamp.light.type = LightType::Point;
  lamp.light.castsShadow = true;
  lamp.keys.push_back({0.0, {0.5, 1.5, -1.0}, {0, 0, -4}, glm::vec3(1.0f), 30.0f});
  stage.lights.push_back(lamp);
  stage.ambient = Ambient{glm::vec3(0.2f), glm::vec3(0.1f)};
  return stage;
}

}  // namespace tessera::test
