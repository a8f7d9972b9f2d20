#include "engine/scene/finite.hpp"

#include <algorithm>
#include <cmath>

namespace tessera {

namespace {

// Far past what a picture shows; products of a few of them stay within float32.
constexpr float kLargestFactor = 1e12f;

template <int N>
bool finite(const glm::vec<N, float>& v) {
  for (int i = 0; i < N; ++i)
    if (!std::isfinite(v[i])) return false;
  return true;
}

float finiteOr(float value, float otherwise) {
  return std::isfinite(value) ? std::clamp(value, -kLargestFactor, kLargestFactor) : otherwise;
}

template <int N>
glm::vec<N, float> finiteOr(glm::vec<N, float> v, const glm::vec<N, float>& otherwise) {
  for (int i = 0; i < N; ++i) v[i] = finiteOr(v[i], otherwise[i]);
  return v;
}

void mend(Material& material) {
  const Material plain;
  material.baseColorFactor = finiteOr(material.baseColorFactor, plain.baseColorFactor);
  material.emissiveFactor = finiteOr(material.emissiveFactor, plain.emissiveFactor);
  for (float Material::*field :
       {&Material::metallicFactor, &Material::roughnessFactor, &Material::normalScale,
        &Material::occlusionStrength, &Material::alphaCutoff})
    material.*field = finiteOr(material.*field, plain.*field);
  for (TextureSlot Material::*slot : {&Material::baseColor, &Material::metallicRoughness, &Material::normal,
                                      &Material::occlusion, &Material::emissive})
    for (std::size_t row = 0; row < 2; ++row)
      (material.*slot).uvTransform[row] =
          finiteOr((material.*slot).uvTransform[row], TextureSlot().uvTransform[row]);
}

template <int N>
void mendAll(std::vector<glm::vec<N, float>>& values, const glm::vec<N, float>& otherwise) {
  for (auto& v : values)
    if (!finite(v)) v = otherwise;
}

bool drawable(const glm::dmat4& world) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row)
      if (!(std::abs(world[column][row]) <= static_cast<double>(std::numeric_limits<float>::max())))
        return false;
  return true;
}

Box transformed(const Box& box, const glm::dmat4& world) {
  Box all;
  for (int corner = 0; corner < 8 && !box.empty(); ++corner)
    all.add(glm::dvec3(world * glm::dvec4((corner & 1) != 0 ? box.max.x : box.min.x,
                                          (corner & 2) != 0 ? box.max.y : box.min.y,
                                          (corner & 4) != 0 ? box.max.z : box.min.z, 1.0)));
  return all;
}

/// False where every position was finite.
bool mendPositions(Scene& scene) {
  std::vector<bool> bad(scene.vertices.position.size(), false);
  bool any = false;
  for (std::size_t i = 0; i < bad.size(); ++i) {
    if (finite(scene.vertices.position[i])) continue;
    bad[i] = any = true;
    scene.vertices.position[i] = glm::vec3(0.0f);
  }
  if (!any) return false;
  for (Primitive& primitive : scene.primitives) {
    primitive.bounds = {};
    for (std::uint32_t i = primitive.firstIndex; i + 2 < primitive.firstIndex + primitive.indexCount;
         i += 3) {
      std::uint32_t* corners = &scene.indices[i];
      if (bad[corners[0]] || bad[corners[1]] || bad[corners[2]]) corners[1] = corners[2] = corners[0];
      for (int k = 0; k < 3; ++k)
        if (!bad[corners[k]]) primitive.bounds.add(glm::dvec3(scene.vertices.position[corners[k]]));
    }
    // Where no corner was good, all of them are at the origin now.
    if (primitive.bounds.empty()) primitive.bounds.add(glm::dvec3(0.0));
  }
  return true;
}

}  // namespace

void makeFinite(Scene& scene) {
  for (Material& material : scene.materials) mend(material);
  mendAll(scene.vertices.normal, glm::vec3(0.0f));
  mendAll(scene.vertices.tangent, glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
  mendAll(scene.vertices.uv0, glm::vec2(0.0f));
  mendAll(scene.vertices.uv1, glm::vec2(0.0f));
  mendAll(scene.vertices.color, glm::vec4(1.0f));
  const bool moved = mendPositions(scene);
  SceneState state;
  evaluate(scene, 0.0, state);
  const std::size_t erased = std::erase_if(
      scene.instances, [&](const Instance& instance) { return !drawable(state.world[instance.node]); });
  if (!moved && erased == 0) return;
  scene.bounds = {};
  for (const Instance& instance : scene.instances)
    scene.bounds.add(transformed(scene.primitives[instance.primitive].bounds, state.world[instance.node]));
  if (scene.bounds.empty()) scene.bounds.add(glm::dvec3(0.0));
}

}  // namespace tessera
