#include "engine/frame/lights.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

namespace tessera {

namespace {

constexpr double kSpotNear = 0.02;  // metres; closer casters are inside the lamp

glm::dvec3 anyUp(const glm::dvec3& direction) {
  return std::abs(direction.y) > 0.99 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(0.0, 1.0, 0.0);
}

ShadowLayer layerOf(const glm::dmat4& projection, const glm::dmat4& view, double texelSize,
                    bool perspective) {
  ShadowLayer layer;
  layer.viewProjection = projection * view;
  layer.texelSize = static_cast<float>(texelSize);
  layer.perspective = perspective;
  layer.frustum = frustumOf(layer.viewProjection);
  return layer;
}

double farthest(const Box& bounds, const glm::dvec3& from) {
  const glm::dvec3 d = glm::max(glm::abs(bounds.max - from), glm::abs(bounds.min - from));
  return glm::length(d);
}

void addDirectional(const LightSample& light, const Box& bounds, const glm::dvec3& anchor, int size,
                    LightSet& set) {
  const double radius = std::max(bounds.diagonal() * 0.5, 1e-9);
  const glm::dvec3 centre = bounds.centre() - anchor;
  const glm::dmat4 view = glm::lookAtRH(centre - light.direction * radius, centre, anyUp(light.direction));
  const glm::dmat4 projection = glm::orthoRH_ZO(-radius, radius, -radius, radius, 0.0, 2.0 * radius);
  set.layers.push_back(layerOf(projection, view, 2.0 * radius / size, false));
}

void addSpot(const LightSample& light, const Box& bounds, const glm::dvec3& anchor, int size, LightSet& set) {
  const double reach =
      light.range > 0.0f ? static_cast<double>(light.range) : farthest(bounds, light.position);
  const double fov = std::clamp(2.0 * static_cast<double>(light.outerCone), 0.01, 3.1);
  const glm::dvec3 eye = light.position - anchor;
  const glm::dmat4 view = glm::lookAtRH(eye, eye + light.direction, anyUp(light.direction));
  const double zFar = std::max(reach, 2.0 * kSpotNear);
  const glm::dmat4 projection = glm::perspectiveRH_ZO(fov, 1.0, kSpotNear, zFar);
  set.layers.push_back(layerOf(projection, view, 2.0 * std::tan(fov * 0.5) / size, true));
}

void addPoint(const LightSample& light, const Box& bounds, const glm::dvec3& anchor, int size,
              LightSet& set) {
  // In the order of cubeFace() in lib/shadow.glsl: +x -x +y -y +z -z.
  static constexpr std::array<std::array<double, 3>, 6> kFaces = {
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  const double reach =
      light.range > 0.0f ? static_cast<double>(light.range) : farthest(bounds, light.position);
  const glm::dvec3 eye = light.position - anchor;
  const glm::dmat4 projection =
      glm::perspectiveRH_ZO(glm::radians(90.0), 1.0, kSpotNear, std::max(reach, 2.0 * kSpotNear));
  for (const auto& face : kFaces) {
    const glm::dvec3 direction(face[0], face[1], face[2]);
    set.layers.push_back(
        layerOf(projection, glm::lookAtRH(eye, eye + direction, anyUp(direction)), 2.0 / size, true));
  }
}

}  // namespace

glm::vec3 boundedRadiance(const glm::vec3& radiance) {
  constexpr float kLargest = 1e12f;
  glm::vec3 bounded(0.0f);
  for (int i = 0; i < 3; ++i)
    if (radiance[i] > 0.0f) bounded[i] = std::min(radiance[i], kLargest);
  return bounded;
}

LightSet buildLights(const std::vector<LightSample>& lights, const Box& bounds, const glm::dvec3& anchor,
                     int shadowSize) {
  LightSet set;
  for (LightSample light : lights) {
    light.radiance = boundedRadiance(light.radiance);
    const glm::dvec3& at = light.position;
    if (!std::isfinite(at.x) || !std::isfinite(at.y) || !std::isfinite(at.z)) {
      light.position = anchor;
      light.radiance = glm::vec3(0.0f);
    }
    glsl::LightGpu gpu{};
    const float inverse = light.range > 0.0f ? 1.0f / (light.range * light.range) : 0.0f;
    gpu.position = glm::vec4(glm::vec3(light.position - anchor), inverse);
    gpu.direction = glm::vec4(glm::vec3(light.direction), 0.0f);
    gpu.radiance = glm::vec4(light.radiance, 0.0f);
    // KHR_lights_punctual: the smoothing between the cones as scale and offset of the cosine.
    const float cosOuter = std::cos(light.outerCone);
    const float scale = 1.0f / std::max(0.001f, std::cos(light.innerCone) - cosOuter);
    gpu.coneScale = scale;
    gpu.coneOffset = -cosOuter * scale;
    gpu.type = light.type == LightType::Directional ? glsl::kLightDirectional
               : light.type == LightType::Point     ? glsl::kLightPoint
                                                    : glsl::kLightSpot;
    gpu.shadowLayer = light.castsShadow ? static_cast<glsl::uint>(set.layers.size()) : glsl::kNoShadow;
    if (light.castsShadow) {
      switch (light.type) {
        case LightType::Directional:
          addDirectional(light, bounds, anchor, shadowSize, set);
          break;
        case LightType::Spot:
          addSpot(light, bounds, anchor, shadowSize, set);
          break;
        case LightType::Point:
          addPoint(light, bounds, anchor, shadowSize, set);
          break;
      }
    }
    set.lights.push_back(gpu);
  }
  for (const ShadowLayer& layer : set.layers)
    set.shadows.push_back({glm::mat4(layer.viewProjection),
                           glm::vec4(layer.texelSize, layer.perspective ? 1.0f : 0.0f, 0.0f, 0.0f)});
  return set;
}

}  // namespace tessera
