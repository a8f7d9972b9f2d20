// Samples that are even on screen, put on the surface, and back. Based on Munkberg, Hasselgren and
// Akenine-Moeller, "Non-Uniform Fractional Tessellation" (2008), and Hladky 2019, eq. 5. p: even barycentric
// coordinates (those of the sample pattern); b: those of the surface. `weights` are the three vertices'
// depths in the camera that the samples are gathered for (see depthWeights in tess_measure.h). The same weights
// must be used both ways, whatever camera displays the samples.
#ifndef TESSERA_GLSL_SHARED_PERSPECTIVE_MAP_H
#define TESSERA_GLSL_SHARED_PERSPECTIVE_MAP_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN
#ifdef __cplusplus
using glm::max;
using glm::min;
#endif

// Between the smallest and the largest weight: floats cannot tell more ratios apart and stay finite in
// products.
SHARED_CONST float kLargestWeightRatio = 1.0e12;
SHARED_CONST float kSmallestWeight = 1.0e-18;
SHARED_CONST float kLargestWeight = 1.0e18;
// An outside sample may be up to four times as far away as the point of the triangle that is next to it.
SHARED_CONST float kHorizonShare = 0.25;

// Weights that can be used, the largest of them 1. Three equal ones, which is no correction, where any is
// zero, negative, not a number, or beyond what floats hold: all of a triangle or nothing, or b would not be
// continuous.
SHARED_FN vec3 perspectiveWeights(vec3 weights) {
  float least = min(weights[0], min(weights[1], weights[2]));
  float most = max(weights[0], max(weights[1], weights[2]));
  // Written so that a NaN fails, each on its own: min and max may drop one.
  bool usable = weights[0] >= kSmallestWeight && weights[1] >= kSmallestWeight &&
                weights[2] >= kSmallestWeight && weights[0] <= kLargestWeight &&
                weights[1] <= kLargestWeight && weights[2] <= kLargestWeight;
  if (!usable || most > least * kLargestWeightRatio) return vec3(float(1));
  return weights / most;
}

// From even to surface coordinates, for p inside of the triangle. They sum to 1; `weights` of
// perspectiveWeights.
SHARED_FN vec3 surfaceFromEven(vec3 p, vec3 weights) {
  vec3 share = p / weights;
  return share / (share[0] + share[1] + share[2]);
}

// From surface to even coordinates, for b inside of the triangle. The inverse of surfaceFromEven.
SHARED_FN vec3 evenFromSurface(vec3 b, vec3 weights) {
  vec3 share = b * weights;
  return share / (share[0] + share[1] + share[2]);
}

// The nearest coordinates with nothing negative, by taking from the others in proportion.
SHARED_FN vec3 clampedBary(vec3 at) {
  vec3 inside = max(at, vec3(float(0)));
  float sum = inside[0] + inside[1] + inside[2];
  return sum > float(0) ? inside / sum : vec3(float(1), float(0), float(0));
}

// surfaceFromEven for samples that may lie outside of the triangle. Extrapolated, so that filtering across
// the edge reproduces what is linear on screen; but a surface seen edge-on ends at its horizon within a
// texel, and beyond that it is behind the eye. There the sample is clamped to the edge.
SHARED_FN vec3 surfaceFromEvenOutside(vec3 p, vec3 weights) {
  vec3 inside = clampedBary(p);
  vec3 share = inside / weights;
  vec3 beyond = p / weights;
  float whole = share[0] + share[1] + share[2];
  float left = beyond[0] + beyond[1] + beyond[2];
  if (left >= whole * kHorizonShare) return beyond / left;
  return share / whole;
}

TESSERA_SHARED_END
#endif
