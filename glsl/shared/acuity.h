// How densely directions need shading: what the eye resolves there, and what a lens makes of the display.
// Based on Mueller 2021, ch. 4; the acuity model is Guenter et al. 2012's. Everything here is total: any float,
// NaN and infinity included, gives a factor from 0 to 1.
#ifndef TESSERA_GLSL_SHARED_ACUITY_H
#define TESSERA_GLSL_SHARED_ACUITY_H
#include "shared/dialect.h"
#include "shared/levels.h"
TESSERA_SHARED_BEGIN
#ifdef __cplusplus
using glm::tan;
#endif

SHARED_CONST float kDegreesPerRadian = 57.2957795130823;
SHARED_CONST float kPixelsPerCycle = 2.0;
SHARED_CONST float kSteepest = 1.55;  // radians from the axis: past every picture, and its tangent is finite
SHARED_CONST float kSmallestRadius = 1.0e-6;  // of a lens: nearer to the centre nothing is distorted

// What level selection knows of a view beside its eye. World directions are those of positions: no rotation lies
// between world and anchor.
struct DensityGpu {
  vec4 gaze;    // unit direction looked at; w unused
  vec4 axis;    // unit direction of the picture's centre; w unused
  vec4 acuity;  // slope (degrees a degree), smallest angle (degrees), the display's degrees per cycle; w unused
  vec4 lens;    // k1, k2, undistorted radius over the tangent of the angle from the axis; w unused
};

// Eq. 4.2's w*: a display shows a cycle on two pixels.
SHARED_FN float degreesPerCycle(float pixelsPerRadian) {
  return kPixelsPerCycle * kDegreesPerRadian / pixelsPerRadian;
}

// How many times larger than a display's cycle the smallest cycle is that the eye resolves at `degrees` from the
// gaze (eq. 4.1 and 4.2), at least 1: where the eye is better than the display, the display is the limit, and
// finer texels would never be seen.
SHARED_FN float acuityScale(float degrees, float slope, float smallest, float cycle) {
  float scale = (slope * degrees + smallest) / cycle;
  return isFiniteNumber(scale) ? max(scale, kLevelOne) : kLevelOne;
}

// All directions within `angle` radians of `axis`. From a quarter turn on it says nothing, see coneOfPatch.
struct Cone {
  vec3 axis;  // unit
  float angle;
};

// Unit vector; a zero where there is no direction. Scaled first, so that no square over- or underflows.
SHARED_FN vec3 directionOf(vec3 v) {
  float largest = max(abs(v.x), max(abs(v.y), abs(v.z)));
  if (!isFiniteNumber(largest) || !(largest > kLevelZero)) return vec3(kLevelZero);
  vec3 scaled = v / largest;
  return scaled / length(scaled);
}

// The cone around a patch as the eye sees it: its axis is the mean of the corners' unit vectors, its angle the
// largest to a corner (sec. 4.3). Corners are relative to the eye, laid out as PatchGeometry says. Up to a quarter
// turn a cone that holds all corners holds all that lies between them; wider ones need not (an eye just above the
// middle of a triangle sees corners all round the horizon), so they count as half a turn and more: everywhere.
// An eye on a corner, and corners that are not finite, give that as well.
SHARED_FN Cone coneOfPatch(vec3 v0, vec3 v1, vec3 v2, vec3 v3, vec3 v4, uint triangles) {
  vec3 d0 = directionOf(v0);
  vec3 d1 = directionOf(v1);
  vec3 d2 = directionOf(v2);
  vec3 d3 = triangles > 1u ? directionOf(v3) : d0;
  vec3 d4 = triangles > 2u ? directionOf(v4) : d0;
  vec3 sum = d0 + d1 + d2;
  if (triangles > 1u) sum += d3;
  if (triangles > 2u) sum += d4;
  Cone cone;
  cone.axis = directionOf(sum);
  cone.angle = max(max(angleBetween(cone.axis, d0), angleBetween(cone.axis, d1)),
                   max(angleBetween(cone.axis, d2), max(angleBetween(cone.axis, d3), angleBetween(cone.axis, d4))));
  float shortest = min(min(dot(d0, d0), dot(d1, d1)), min(dot(d2, d2), min(dot(d3, d3), dot(d4, d4))));
  bool known = min(shortest, dot(cone.axis, cone.axis)) > kLevelHalf;
  if (!known || !(cone.angle < kHalfPi)) cone.angle = kPi;
  return cone;
}

// The angle from a unit direction to the nearest point of a cone, in radians (eq. 4.3).
SHARED_FN float eccentricity(Cone cone, vec3 direction) {
  return max(angleBetween(direction, cone.axis) - cone.angle, kLevelZero);
}

// The radial lens of eq. 4.4: the undistorted radius of a distorted one, both 1 and below at the picture's corners
// before the scale 1 + k1 + k2.
SHARED_FN float lensUndistort(float distorted, float k1, float k2) {
  float square = distorted * distorted;
  return distorted * (kLevelOne + square * (k1 + square * k2));
}

// Its derivative.
SHARED_FN float lensSlope(float distorted, float k1, float k2) {
  float square = distorted * distorted;
  return kLevelOne + square * (float(3) * k1 + float(5) * k2 * square);
}

// The inverse of lensUndistort for a lens that rises over 0..1: Newton's steps, halving the bracket instead where
// one would leave it. Radii past the corner give 1.
SHARED_FN float lensDistort(float undistorted, float k1, float k2) {
  float low = kLevelZero;
  float high = kLevelOne;
  float corner = lensUndistort(kLevelOne, k1, k2);
  if (!(undistorted > kLevelZero)) return kLevelZero;
  if (!(undistorted < corner)) return kLevelOne;
  float at = undistorted / corner;
  for (int i = 0; i < 32; ++i) {
    float excess = lensUndistort(at, k1, k2) - undistorted;
    if (excess > kLevelZero) {
      high = at;
    } else {
      low = at;
    }
    float next = at - excess / lensSlope(at, k1, k2);
    if (!(next >= low && next <= high)) next = (low + high) * kLevelHalf;
    if (next == at) break;
    at = next;
  }
  return at;
}

// Length on the distorted display over length in the undistorted picture, at undistorted radius n, over what it is in the
// middle; cut to 0..1 (sec. 4.4). Display fills its output with the picture (Lens::fill), so the middle of a barrel lens is
// magnified, by 1 + k1 + k2 at equal sizes: a texel a pixel of the undistorted picture is that much less than one a pixel
// of the display there. Levels that follow this scale keep the middle's density on the display everywhere across the
// radius, and more along it, where a barrel lens presses more; none is coarser on the display than in the middle. For a
// texel a pixel of the display, take the bias -2 log2(1 + k1 + k2) and draw the picture as much larger.
// Taken from the inverse of eq. 4.4 itself: any k1 and k2 have it.
SHARED_FN float lensScale(float n, float k1, float k2) {
  float within = min(n, lensUndistort(kLevelOne, k1, k2));
  if (!isFiniteNumber(within) || !(within > kSmallestRadius)) return kLevelOne;
  return clamp(lensDistort(within, k1, k2) / within, kLevelZero, kLevelOne);
}

// The same for k1 = 0.22, k2 = 0.24 as printed (eq. 4.5). A least-squares quintic through the inverse of eq. 4.4,
// sampled evenly over distorted radii 0..1, has these coefficients before rounding; so n is the undistorted
// radius, and its range is 0..1.46, not 0..1. Rounded it is off by at most 0.005 up to n = 0.9 (once cut to 0..1)
// and by 0.015 at 1.46; past 2.2 it falls to nonsense. For accuracy studies.
SHARED_FN float lensScaleAsPrinted(float n) {
  float scale = 5.4e-4 / n + 0.98 + n * (0.13 + n * (-0.56 + n * (0.32 - n * 0.06)));
  return clamp(scale, kLevelZero, kLevelOne);
}

// What a view's foveation and lens leave of the area that a patch asks for, as log2, at most 0. Both scales are
// lengths, so areas take their squares; together they multiply.
SHARED_FN float logAcuity(DensityGpu density, Cone cone) {
  float degrees = eccentricity(cone, vec3(density.gaze.x, density.gaze.y, density.gaze.z)) * kDegreesPerRadian;
  return -float(2) * log2(acuityScale(degrees, density.acuity.x, density.acuity.y, density.acuity.z));
}
SHARED_FN float logLens(DensityGpu density, Cone cone) {
  // Radii of a flat picture are tangents. (The thesis takes the angle's share of the field of view, which is up to 6 % less
  // length at 60 degrees of height, 11 % at 90.)
  float angle = min(eccentricity(cone, vec3(density.axis.x, density.axis.y, density.axis.z)), kSteepest);
  return float(2) * log2(lensScale(tan(angle) * density.lens.z, density.lens.x, density.lens.y));
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::DensityGpu) == 64);
#endif
#endif
