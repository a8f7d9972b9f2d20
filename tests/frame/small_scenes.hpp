// Small scenes made in code, for tests of the frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/scene/scene.hpp"
#include "engine/scene/stage.hpp"

namespace tessera::test {

/// An empty scene with one material and one identity node.
inline Scene emptyScene() {
  Scene scene;
  scene.file = "test";
  scene.materials.emplace_back();
  scene.nodes.emplace_back();
  return scene;
}

inline std::uint32_t addMaterial(Scene& scene, const Material& material) {
  scene.materials.push_back(material);
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

/// Recomputes Scene::bounds from the instances at time 0.
inline void finish(Scene& scene) {
  SceneState state;
  evaluate(scene, 0.0, state);
  scene.bounds = {};
  for (const Instance& instance : scene.instances) {
    const Primitive& primitive = scene.primitives[instance.primitive];
    for (std::uint32_t i = 0; i < primitive.vertexCount; ++i)
      scene.bounds.add(glm::dvec3(state.world[instance.node] *
                                  glm::dvec4(scene.vertices.position[primitive.firstVertex + i], 1.0)));
  }
}

/// A grid of nx x ny quads over the parallelogram origin + s u + t v, s and t in [0, 1]; normal along
/// cross(u, v). uv0 = (s, t). Colours, when `colored`, are a linear function of the place: (s, t, 0.5).
inline std::uint32_t addGrid(Scene& scene, glm::vec3 origin, glm::vec3 u, glm::vec3 v, int nx, int ny,
                             std::uint32_t material = 0, bool colored = false) {
  Primitive primitive;
  primitive.firstVertex = static_cast<std::uint32_t>(scene.vertices.position.size());
  primitive.firstIndex = static_cast<std::uint32_t>(scene.indices.size());
  primitive.material = material;
  primitive.hasColor = colored;
  const glm::vec3 normal = glm::normalize(glm::cross(u, v));
  for (int y = 0; y <= ny; ++y)
    for (int x = 0; x <= nx; ++x) {
      const glm::vec2 uv(static_cast<float>(x) / static_cast<float>(nx),
                         static_cast<float>(y) / static_cast<float>(ny));
      const glm::vec3 p = origin + u * uv.x + v * uv.y;
      scene.vertices.position.push_back(p);
      scene.vertices.normal.push_back(normal);
      scene.vertices.uv0.push_back(uv);
      scene.vertices.color.emplace_back(colored ? glm::vec4(uv, 0.5f, 1.0f) : glm::vec4(1.0f));
      primitive.bounds.add(glm::dvec3(p));
    }
  const auto at = [&](int x, int y) {
    return primitive.firstVertex + static_cast<std::uint32_t>(y * (nx + 1) + x);
  };
  for (int y = 0; y < ny; ++y)
    for (int x = 0; x < nx; ++x)
      for (const std::uint32_t i :
           {at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y), at(x + 1, y + 1), at(x, y + 1)})
        scene.indices.push_back(i);
  primitive.vertexCount = static_cast<std::uint32_t>(scene.vertices.position.size()) - primitive.firstVertex;
  primitive.indexCount = static_cast<std::uint32_t>(scene.indices.size()) - primitive.firstIndex;
  scene.primitives.push_back(primitive);
  return static_cast<std::uint32_t>(scene.primitives.size() - 1);
}

inline void place(Scene& scene, std::uint32_t primitive, std::uint32_t node = 0) {
  scene.instances.push_back({node, primitive});
}

/// A checkered RGBA image, `cells` a side.
inline std::uint32_t addCheckers(Scene& scene, int side, int cells, bool alpha = false) {
  SceneImage image;
  image.name = "checkers";
  image.image.width = image.image.height = side;
  image.image.pixels.resize(static_cast<std::size_t>(side) * static_cast<std::size_t>(side) * 4);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const bool on = ((x * cells / side) + (y * cells / side)) % 2 == 0;
      std::uint8_t* p = image.image.at(x, y);
      p[0] = on ? 230 : 40;
      p[1] = on ? 200 : 60;
      p[2] = on ? 90 : 160;
      p[3] = alpha && !on ? 0 : 255;
    }
  scene.images.push_back(std::move(image));
  return static_cast<std::uint32_t>(scene.images.size() - 1);
}

inline Material unlit() {
  Material material;
  material.unlit = true;
  return material;
}

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

/// A triangle list; normals towards +z, uv0 = (x, y), white.
inline std::uint32_t addTriangles(Scene& scene, const std::vector<glm::vec3>& corners,
                                  std::uint32_t material) {
  Primitive primitive;
  primitive.firstVertex = static_cast<std::uint32_t>(scene.vertices.position.size());
  primitive.firstIndex = static_cast<std::uint32_t>(scene.indices.size());
  primitive.material = material;
  for (const glm::vec3& corner : corners) {
    scene.indices.push_back(static_cast<std::uint32_t>(scene.vertices.position.size()));
    scene.vertices.position.push_back(corner);
    scene.vertices.normal.emplace_back(0.0f, 0.0f, 1.0f);
    scene.vertices.uv0.emplace_back(corner.x, corner.y);
    scene.vertices.color.emplace_back(1.0f);
    primitive.bounds.add(glm::dvec3(corner));
  }
  primitive.vertexCount = static_cast<std::uint32_t>(corners.size());
  primitive.indexCount = primitive.vertexCount;
  scene.primitives.push_back(primitive);
  return static_cast<std::uint32_t>(scene.primitives.size() - 1);
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
