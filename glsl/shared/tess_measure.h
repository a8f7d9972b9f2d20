// How many samples a triangle gets: what its size in the picture is, and which shape of its slot follows. Every function
// is total: any float, NaN and infinity included, gives a valid shape.
#ifndef TESSERA_GLSL_SHARED_TESS_MEASURE_H
#define TESSERA_GLSL_SHARED_TESS_MEASURE_H
#include "shared/dialect.h"
#include "shared/levels.h"
#include "shared/tess_atlas.h"
TESSERA_SHARED_BEGIN

SHARED_CONST float kLongestEdge = 4096.0;   // pixels; what a triangle around the eye is cut to
SHARED_CONST float kSingleLength = 1.0;     // pixels; up to this one texel is enough
SHARED_CONST float kFlattest = 1.0e-6;      // of the longest edge: the height that a flat triangle counts as

// Lengths are angles times pixels per radian, so they do not depend on where the camera looks, and a triangle that
// reaches behind it has one. Corners are relative to the eye.
SHARED_FN TessMeasure measureTriangle(vec3 v0, vec3 v1, vec3 v2, float pixelsPerRadian) {
  float e0 = angleBetween(v0, v1) * pixelsPerRadian;
  float e1 = angleBetween(v1, v2) * pixelsPerRadian;
  float e2 = angleBetween(v2, v0) * pixelsPerRadian;
  TessMeasure measure;
  measure.edge = e0 >= e1 && e0 >= e2 ? 0u : (e1 >= e2 ? 1u : 2u);
  float longest = max(e0, max(e1, e2));
  float before = measure.edge == 0u ? e2 : (measure.edge == 1u ? e0 : e1);
  float after = measure.edge == 0u ? e1 : (measure.edge == 1u ? e2 : e0);
  float reach = dot(abs(v0) + abs(v1) + abs(v2), vec3(kLevelOne));
  if (!isFiniteNumber(reach) || reach > kFarthestCorner || !isFiniteNumber(longest)) longest = kLevelZero;
  float cut = longest > kLongestEdge ? kLongestEdge / longest : kLevelOne;
  measure.longest = longest * cut;
  measure.height = kLevelZero;
  measure.foot = kLevelHalf;
  if (longest > kLevelZero) {
    float twice = kLevelOne + kLevelOne;
    measure.height = twice * triangleArea(longest, before, after) / longest * cut;
    // By the law of cosines; the two other edges differ by at most the longest.
    float side = (before - after) / longest * ((before + after) / longest);
    measure.foot = clamp(kLevelHalf * (kLevelOne + side), kLevelZero, kLevelOne);
  }
  return measure;
}

SHARED_FN bool isSlanted(TessMeasure measure, float threshold) {
  return measure.longest > threshold * max(measure.height, kFlattest * measure.longest);
}

// The even level whose samples along an edge of `pixels` are at most a pixel apart.
SHARED_FN uint levelOfLength(float pixels) {
  if (!(pixels > kSingleLength)) return 0u;
  return min(uint(2) * uint(ceil(kLevelHalf * min(pixels, kLongestEdge))), kLargestLevel);
}

// The shape that a triangle asks for under a bias, log2 of area. `previous` is kept while the length lies within its
// level plus and minus `hysteresis` (in log2 of length); pass hysteresis < 0 for none.
SHARED_FN uint selectShape(TessMeasure measure, float bias, uint previous, float hysteresis) {
  float scale = exp2(-kLevelHalf * clamp(bias, -kLargestBias, kLargestBias));
  float pixels = measure.longest * scale;
  if (!(pixels > kSingleLength) && !(hysteresis >= kLevelZero && kindOf(previous) == kTessL)) return kTessSingle;
  if (hysteresis >= kLevelZero) {
    float slack = exp2(hysteresis);
    uint held = kindOf(previous) == kTessL ? levelOfShape(previous) : 0u;
    if (held <= levelOfLength(pixels * slack) && held >= levelOfLength(pixels / slack) && previous != kTessNone) return previous;
  }
  uint level = levelOfLength(pixels);
  return level == 0u ? kTessSingle : shapeOfL(level);
}

// Texels that it would ideally take: its share of I, see pressureBias.
SHARED_FN uint idealSamples(TessMeasure measure, float bias, float slanted) {
  uint shape = selectShape(measure, bias, kTessNone, -kLevelOne);
  return kindOf(shape) == kTessL ? lTexels(levelOfShape(shape)) : 1u;
}

TESSERA_SHARED_END
#endif
