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
SHARED_CONST float kSmallestRadius = 1.0e-6;  // of a lens: nearer to the centre nothing is distorted

// What level selection knows of a view beside its eye. World directions are those of positions: no rotation lies
// between world and anchor.
struct DensityGpu {
  vec4 gaze;    // unit direction looked at; w unused
  vec4 axis;    // unit direction of the picture's centre; w unused
  vec4 acuity;  // slope (degrees a degree), smallest angle (degrees), the display's degrees per cycle; w unused
  vec4 lens;    // k1, k2, undistorted radius per tangent of the angle from the axis, see lensShare: fill
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

// The least of 1 + a x + b x^2 over x in [low, high].
SHARED_FN float leastOver(float low, float high, float a, float b) {
  float turn = b > kLevelZero ? clamp(-a / (b + b), low, high) : low;
  float least = kLevelOne + turn * (a + turn * b);
  return min(least, min(kLevelOne + low * (a + low * b), kLevelOne + high * (a + high * b)));
}

// How much of a patch's area a lens leaves to be seen, 0 to 1, for a patch that lies within the undistorted radii
// nearest..farthest (on eq. 4.4's scale, cut at the corner's). Display draws the picture first and the lens then:
// along the radius lensSlope / fill pixels of the picture meet in one of the output, across it
// lensUndistort(d) / d / fill. Where these are above 1, texels that are as many times longer are still a pixel of
// the output each; where they are below, the output enlarges, and more texels than the picture has pixels would be
// lost to it. The largest share over the patch counts, so none of it gets less than it shows.
// Eq. 4.5's d / n for both directions leaves fill out: of the default lens at d = 0.7 it keeps 0.74 of the area,
// where display shows 0.92.
SHARED_FN float lensShare(float nearest, float farthest, float k1, float k2, float fill) {
  float inner = lensDistort(nearest, k1, k2);
  float outer = lensDistort(farthest, k1, k2);
  float along = leastOver(inner * inner, outer * outer, float(3) * k1, float(5) * k2) / fill;
  float across = leastOver(inner * inner, outer * outer, k1, k2) / fill;
  float pressed = max(along, kLevelOne) * max(across, kLevelOne);
  return isFiniteNumber(pressed) ? kLevelOne / pressed : kLevelOne;
}

// Eq. 4.5 as printed: what a lens of k1 = 0.22, k2 = 0.24 leaves of lengths, d / n. A least-squares quintic through
// the inverse of eq. 4.4, sampled evenly over distorted radii 0..1, has these coefficients before rounding; so n is
// the undistorted radius, and its range is 0..1.46, not 0..1. Rounded it is off by at most 0.005 up to n = 0.9 (once
// cut to 0..1) and by 0.015 at 1.46; past 2.2 it falls to nonsense. For accuracy studies.
SHARED_FN float lensScaleAsPrinted(float n) {
  float scale = 5.4e-4 / n + 0.98 + n * (0.13 + n * (-0.56 + n * (0.32 - n * 0.06)));
  return clamp(scale, kLevelZero, kLevelOne);
}

// What a view's foveation and lens leave of the area that a patch asks for, as log2, at most 0. Together they
// multiply. Acuity scales lengths, so areas take its square.
SHARED_FN float logAcuity(DensityGpu density, Cone cone) {
  float degrees = eccentricity(cone, vec3(density.gaze.x, density.gaze.y, density.gaze.z)) * kDegreesPerRadian;
  return -float(2) * log2(acuityScale(degrees, density.acuity.x, density.acuity.y, density.acuity.z));
}
// The undistorted radius at an angle from the axis, radians, cut at the corner's.
SHARED_FN float tangentRadius(float angle, float perTangent, float corner) {
  return angle < kHalfPi ? min(tan(angle) * perTangent, corner) : corner;
}
SHARED_FN float logLens(DensityGpu density, Cone cone) {
  float middle = angleBetween(vec3(density.axis.x, density.axis.y, density.axis.z), cone.axis);
  float corner = lensUndistort(kLevelOne, density.lens.x, density.lens.y);
  float nearest = tangentRadius(max(middle - cone.angle, kLevelZero), density.lens.z, corner);
  // The channel that the lens draws out least lies farthest out in its picture: fill / corner times as far.
  float farthest = tangentRadius(middle + cone.angle, density.lens.z, corner) * density.lens.w / corner;
  return log2(lensShare(nearest, farthest, density.lens.x, density.lens.y, density.lens.w));
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::DensityGpu) == 64);
#endif
#endif
