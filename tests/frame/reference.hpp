// A ray tracer in double precision that says what a small scene must look like: the oracle of the shading
// tests.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/frame/view.hpp"
#include "engine/image/image.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/stage.hpp"

namespace tessera::test {

/// Light that falls on a reference scene. Cones and ranges as in LightSample.
struct Lighting {
  std::vector<LightSample> lights;
  Ambient ambient{glm::vec3(0.0f), glm::vec3(0.0f)};
  double exposure = 1.0;
};

/// The stage that gives an engine this light.
Stage stageOf(const Lighting& lighting);

/// What a view must look like, traced at the corners, edges and centres of pixels, two points a pixel along
/// each axis.
struct Reference {
  int width = 0;  // of the view
  int height = 0;
  std::vector<glm::vec4>
      points;  // (2 width + 1) x (2 height + 1), rows from the top; 8-bit sRGB, a = 255 or 0

  [[nodiscard]] const glm::vec4& point(int x, int y) const {
    return points[static_cast<std::size_t>(y) * static_cast<std::size_t>(2 * width + 1) +
                  static_cast<std::size_t>(x)];
  }
  [[nodiscard]] const glm::vec4& centre(int x, int y) const { return point(2 * x + 1, 2 * y + 1); }
};

/// Traces `view`. The scene is taken at time 0. Shading as in glTF 2.0, appendix B, in the textbook form of
/// its terms (GGX; Smith with Heitz 2014's lambda; Schlick); the environment's specular share by integrating
/// the same lobe; lights as in KHR_lights_punctual, their shadows by rays; textures by their nearest texel,
/// repeated. No BLEND.
Reference trace(const Scene& scene, const Lighting& lighting, const View& view);

struct Comparison {
  std::size_t outside = 0;        // pixels that leave their bounds by more than the tolerance
  std::size_t outsideWithin = 0;  // of these, pixels with nothing but surfaces around
  std::size_t covered = 0;        // pixels whose bounds are covered all over
  std::size_t tight = 0;          // of these, with bounds no farther apart than 4 levels
  std::string first;              // the first pixels that are outside, in words
};

/// Each pixel must lie, channel by channel, between the least and the most of the reference over the square
/// of `radius` half pixels around its centre, give or take `tolerance` levels of 8 bits. Where shading is
/// smooth the bounds meet; at edges of things, shadows and texels they allow what filtering may make of them.
Comparison compare(const Image& image, const Reference& reference, int radius, double tolerance);

}  // namespace tessera::test
