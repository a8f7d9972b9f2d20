// Lights and shadow maps on the GPU.
#pragma once

#include <vector>

#include "engine/frame/view.hpp"
#include "engine/gl/objects.hpp"
#include "engine/scene/stage.hpp"
#include "glsl/shared/material.h"

namespace tessera {

/// One layer of the shadow map: the world it sees, and whether it must be drawn again.
struct ShadowLayer {
  glm::dmat4 viewProjection{1.0};  // relative to the anchor, depth 0 at the near plane
  float texelSize = 0.0f;          // metres a texel: anywhere (orthographic), or at one metre (perspective)
  bool perspective = false;
  Frustum frustum;  // relative to the anchor
};

struct LightSet {
  std::vector<glsl::LightGpu> lights;
  std::vector<ShadowLayer> layers;
  std::vector<glsl::ShadowGpu> shadows;
};

/// Within 0 and what the products of shading can hold as floats; 0 for what is not a number.
glm::vec3 boundedRadiance(const glm::vec3& radiance);

/// GPU records of the lights and the shadow layers they need. `bounds` is what a directional light must cover
/// and how far an unlimited light reaches, world space; a light whose place is not finite is dark;
/// `shadowSize` the side of a layer in texels.
LightSet buildLights(const std::vector<LightSample>& lights, const Box& bounds, const glm::dvec3& anchor,
                     int shadowSize);

}  // namespace tessera
