// Scenes made in code, piece by piece.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/scene.hpp"

namespace tessera::build {

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

}  // namespace tessera::build
