// How large a triangle is in the picture, and how it is therefore sampled. Every function is total: any float, NaN and
// infinity included, gives a valid shape.
#ifndef TESSERA_GLSL_SHARED_TESS_MEASURE_H
#define TESSERA_GLSL_SHARED_TESS_MEASURE_H
#include "shared/dialect.h"
#include "shared/levels.h"
#include "shared/tess_atlas.h"
TESSERA_SHARED_BEGIN
#ifdef __cplusplus
using glm::ceil;
#endif

SHARED_CONST float kSingleLength = 1.0;  // pixels; up to this one texel is enough
SHARED_CONST float kFlattest = 1.0e-6;   // of the longest edge: the height that a flat triangle counts as

// Lengths are angles times pixels per radian, so they do not depend on where the camera looks, and a triangle that
// reaches behind it has one. Corners are relative to the eye.
SHARED_FN TessMeasure measureTriangle(vec3 v0, vec3 v1, vec3 v2, float pixelsPerRadian) {
  TessMeasure measure;
  measure.edge0 = measuredAngle(v1, v2) * pixelsPerRadian;
  measure.edge1 = measuredAngle(v2, v0) * pixelsPerRadian;
  measure.edge2 = measuredAngle(v0, v1) * pixelsPerRadian;
  float longest = max(measure.edge0, max(measure.edge1, measure.edge2));
  float reach = dot(abs(v0) + abs(v1) + abs(v2), vec3(kLevelOne));
  if (!isFiniteNumber(reach) || reach > kFarthestCorner || !isFiniteNumber(longest) || !(longest > kLevelZero)) {
    measure.edge0 = kLevelZero;
    measure.edge1 = kLevelZero;
    measure.edge2 = kLevelZero;
    measure.height = kLevelZero;
    return measure;
  }
  float area = measuredArea(measure.edge0 / longest, measure.edge1 / longest, measure.edge2 / longest);
  measure.height = (area + area) * longest;
  return measure;
}

// Depths of the corners for a camera that looks at the triangle from the eye: even samples are even on its screen, whatever
// the view's own direction is. What would lie behind it, or too near its plane, is moved to where the ratio to the
// farthest is at most this.
SHARED_CONST float kLeastDepth = 1.0e-4;
SHARED_FN vec3 depthWeights(vec3 v0, vec3 v1, vec3 v2) {
  vec3 axis = v0 + v1 + v2;
  vec3 depth = vec3(dot(v0, axis), dot(v1, axis), dot(v2, axis));
  float farthest = max(depth.x, max(depth.y, depth.z));
  if (!isFiniteNumber(farthest) || !(farthest > kSmallestArea)) return vec3(kLevelOne);
  return perspectiveWeights(max(depth / farthest, vec3(kLeastDepth)));
}

SHARED_FN float longestOf(TessMeasure measure) { return max(measure.edge0, max(measure.edge1, measure.edge2)); }

SHARED_FN bool isSlanted(TessMeasure measure, float threshold) {
  float longest = longestOf(measure);
  return longest > threshold * max(measure.height, kFlattest * longest);
}

// A scale of its lengths that keeps a triangle's shape within the limits, but for rounding: `scale` or less.
SHARED_FN float scaleWithin(TessMeasure measure, float scale, TessLimits limits) {
  float base = longestOf(measure) * scale;
  if (!isFiniteNumber(base) || !(base > kSingleLength)) return scale;
  if (!isSlanted(measure, limits.slanted)) return scale * min(kLevelOne, limits.level / base);
  return scale * min(kLevelOne, min(limits.columns / base, kOverHighest / max(measure.height * scale, kLevelOne)));
}

// What a triangle asks for at a scale of its lengths.
SHARED_FN TessShape shapeAt(TessMeasure measure, float scale, TessLimits limits) {
  TessShape shape;
  shape.kind = kTessSingle;
  shape.size = 0u;
  shape.form = 0u;
  float base = longestOf(measure) * scale;
  if (!isFiniteNumber(base) || !(base > kSingleLength)) return shape;
  if (!isSlanted(measure, limits.slanted)) {
    shape.kind = kindOfL(uint(ceil(min(base, limits.level))));
    return shape;
  }
  float fit = scaleWithin(measure, scale, limits);
  vec3 edges = vec3(measure.edge0, measure.edge1, measure.edge2) * fit;
  return shapeOfOver(overShapeOf(edges, measure.height * fit));
}

SHARED_FN bool sizeWithin(uint held, uint low, uint high) { return held >= low && held <= high; }

// Which halves there are, and whether it is one row: what changes at once where a triangle grows.
SHARED_FN uint overForm(OverShape shape) {
  return (shape.columns0 > 0u ? 1u : 0u) | (shape.columns1 > 0u ? 2u : 0u) | (shape.rows == 1u ? 4u : 0u);
}
// Steps along the base: those of its length, rounded up by an eighth and one a half at most.
SHARED_FN uint overStepsOf(OverShape shape) {
  return max(shape.columns0, 1u) - 1u + max(shape.columns1, 1u) - 1u;
}
SHARED_FN bool overWithin(OverShape held, OverShape least, OverShape most) {
  if (held.apex != least.apex || held.apex != most.apex || !sizeWithin(held.rows, least.rows, most.rows)) return false;
  if (overForm(least) == overForm(most))
    return sizeWithin(held.columns0, least.columns0, most.columns0) &&
           sizeWithin(held.columns1, least.columns1, most.columns1);
  uint steps = overStepsOf(held);
  return (overForm(held) == overForm(least) || overForm(held) == overForm(most)) &&
         9u * steps + 18u >= 8u * overStepsOf(least) && 8u * steps <= 9u * overStepsOf(most) + 16u;
}

// The shape under two biases, log2 of area. `pressure` is taken off what the limits leave of the triangle: else those past
// them would not shrink at all. `previous` is kept while it is one for lengths within `hysteresis` (in log2)
// of the triangle's; pass hysteresis < 0 for none. Likewise a triangle stays slanted, or not, near the threshold.
SHARED_FN TessShape selectShape(TessMeasure measure, float bias, float pressure, TessLimits limits, TessShape previous,
                                float hysteresis) {
  float slack = hysteresis >= kLevelZero ? exp2(hysteresis) : kLevelOne;
  uint kind = kindOf(previous.kind);
  if (kind == kTessL) limits.slanted *= slack;
  if (kind == kTessOver) limits.slanted /= slack;
  float scale = scaleWithin(measure, exp2(-kLevelHalf * clamp(bias, -kLargestBias, kLargestBias)), limits) *
                exp2(-kLevelHalf * clamp(pressure, -kLargestBias, kLargestBias));
  if (!(hysteresis >= kLevelZero)) return shapeAt(measure, scale, limits);
  TessShape low = shapeAt(measure, scale / slack, limits);
  TessShape high = shapeAt(measure, scale * slack, limits);
  bool keeps = false;
  if (kind == kTessSingle) {
    keeps = kindOf(low.kind) == kTessSingle;
  } else if (kind == kTessL) {
    uint least = kindOf(low.kind) == kTessL ? levelOfKind(low.kind) : 1u;
    keeps = kindOf(high.kind) == kTessL && sizeWithin(levelOfKind(previous.kind), least, levelOfKind(high.kind));
  } else if (kind == kTessOver && kindOf(high.kind) == kTessOver) {
    OverShape held = overOfShape(previous);
    OverShape most = overOfShape(high);
    if (kindOf(low.kind) == kTessOver) {
      keeps = overWithin(held, overOfShape(low), most);
    } else {
      keeps = held.apex == most.apex && overForm(held) == overForm(most) && held.rows <= most.rows &&
              held.columns0 <= most.columns0 && held.columns1 <= most.columns1;
    }
  }
  if (keeps) return previous;
  return shapeAt(measure, scale, limits);
}

TESSERA_SHARED_END
#endif
