// How large a triangle is for the camera that its samples are gathered for, and what samples it therefore
// gets. Everything here is total: any float, NaN and infinity included, gives a valid measure.
#ifndef TESSERA_GLSL_SHARED_FOOTPRINT_H
#define TESSERA_GLSL_SHARED_FOOTPRINT_H
#include "shared/dialect.h"
#include "shared/levels.h"
#include "shared/lpack.h"
#include "shared/oversample.h"
#include "shared/perspective_map.h"
#include "shared/tessellation.h"
TESSERA_SHARED_BEGIN
#ifdef __cplusplus
using glm::ceil;
#endif

// The gathering camera.
struct FootprintView {
  vec2 pixels;    // a unit at depth 1, along x and y: |P00| width / 2, |P11| height / 2
  vec2 limits;    // of |x| and |y| at depth 1; somewhat beyond the view
  float nearest;  // depth; that of the near plane
};

// Lengths in pixels; edges[s] is opposite of corner s.
struct Footprint {
  vec3 edges;
  bool curved;  // measured as angles
};

// Corners in view space: x right, y up, the camera looks along -z.
// A triangle within the limits is measured on the screen. One that reaches out of `limits`, comes near to the
// eye's plane or lies behind it is measured by angles, times the pixels per radian of the middle: its edges
// are then at most half a turn long, however small a w becomes, nothing needs to be clipped, and triangles
// that another view of the potentially visible set sees have a size too. A clipped outline would say nothing
// of those, and one of a triangle that crosses the near plane would still have to be turned into a size of
// the whole triangle, which is what is sampled.
SHARED_FN Footprint footprintOf(vec3 v0, vec3 v1, vec3 v2, FootprintView view) {
  vec3 depth = vec3(-v0.z, -v1.z, -v2.z);
  bool onScreen = true;
  for (int i = 0; i < 3; ++i) {
    vec3 v = i == 0 ? v0 : (i == 1 ? v1 : v2);
    onScreen = onScreen && depth[i] >= view.nearest && abs(v.x) <= view.limits.x * depth[i] &&
               abs(v.y) <= view.limits.y * depth[i];
  }
  Footprint footprint;
  footprint.curved = !onScreen;
  if (onScreen) {
    vec2 p0 = vec2(v0.x, v0.y) / depth[0] * view.pixels;
    vec2 p1 = vec2(v1.x, v1.y) / depth[1] * view.pixels;
    vec2 p2 = vec2(v2.x, v2.y) / depth[2] * view.pixels;
    footprint.edges = vec3(length(p2 - p1), length(p0 - p2), length(p1 - p0));
  } else {
    float pixels = max(view.pixels.x, view.pixels.y);
    footprint.edges = vec3(angleBetween(v1, v2), angleBetween(v2, v0), angleBetween(v0, v1)) * pixels;
  }
  return footprint;
}

// What to give to the perspective map, already usable: depths, or for a curved footprint distances from the
// eye, which are never negative: the samples are then even on the plane through the three directions.
SHARED_FN vec3 footprintWeights(vec3 v0, vec3 v1, vec3 v2, bool curved) {
  if (curved) return perspectiveWeights(vec3(length(v0), length(v1), length(v2)));
  return perspectiveWeights(vec3(-v0.z, -v1.z, -v2.z));
}

SHARED_CONST uint kSampledOnce = 0u;   // one texel
SHARED_CONST uint kSampledL = 1u;      // `level` of the L
SHARED_CONST uint kSampledOver = 2u;   // `shape` of the blocks
SHARED_CONST uint kSampledSplit = 3u;  // too large: split first, each edge into `split`

struct SampleOptions {
  float texelsPerPixel;  // along an edge; more than 0. Biases are factors of it.
  float levelPerTexel;   // level of an L for a texel of its longest edge, more than 0; see measureSamples
  float onceBelow;       // longest edge, in texels, up to which a triangle is one texel
  float slantedAbove;    // longest edge by height beyond which it is oversampled; 0: all, 2e30: none
  bool mustFit;          // what is too large is sampled coarser instead of split
};

struct SampleMeasure {
  uint kind;
  uint level;
  OverShape shape;  // of kSampledOver only
  uint split;       // of kSampledSplit only, 2 to 64
  float slanted;    // longest edge by height; 1e30 where it has none
};

SHARED_CONST float kMostSlanted = 1.0e30;

// The largest factor in (0, 1] for which blocks of the scaled lengths surely are within what a tessellator
// spawns. overCount is at most (9/8 w + 33/4) (9/8 h + 33/8) / 2 for base w and height h: sizes are rounded
// up by a step and an eighth, and a block of c columns and r rows has at most (c + 2) (r + 2) / 2 threads.
SHARED_FN float overFit(float base, float height) {
  float a = float(81) / float(64) * base * height;
  float b = float(9) / float(8) * (float(33) / float(8) * base + float(33) / float(4) * height);
  float c = float(2u * kTessMostSamples) - float(1089) / float(32);
  return min(float(2) * c / (b + sqrt(b * b + float(4) * a * c)), float(1));
}

// Chooses the samples of a triangle. Needles, mirrored and flat triangles need no rule of their own: only
// lengths count, and what has no height is infinitely slanted. Lengths that are not finite give one texel.
// Blocks have a sample for each texel of area, and those around. An L with levelPerTexel 1 has samples at
// most a texel apart along the longest edge; its rows lie closer, so that an equilateral triangle has 1.73
// samples for a texel of area, and one with levelPerTexel 0.76 has 1.
SHARED_FN SampleMeasure measureSamples(Footprint footprint, SampleOptions options) {
  SampleMeasure measure;
  measure.kind = kSampledOnce;
  measure.level = 0u;
  measure.split = 1u;
  measure.slanted = kLevelOne;
  measure.shape.apex = 0u;
  measure.shape.columns0 = 0u;
  measure.shape.columns1 = 0u;
  measure.shape.rows = 0u;
  measure.shape.foot = 0u;
  vec3 edges = footprint.edges * options.texelsPerPixel;
  // Far beyond any screen, and products stay finite.
  float large = float(1000000);
  if (!isFiniteNumber(edges[0] + edges[1] + edges[2])) return measure;
  edges = min(edges, vec3(large));
  float base = max(edges[0], max(edges[1], edges[2]));
  if (!(base > kLevelZero)) return measure;
  float height = float(2) * (triangleArea(edges[0] / base, edges[1] / base, edges[2] / base) * base);
  measure.slanted = height * kMostSlanted > base ? base / height : kMostSlanted;
  if (!(base > options.onceBelow)) return measure;
  bool slanted = measure.slanted > options.slantedAbove;
  float most = float(kTessLargest);
  if (!slanted) {
    measure.kind = kSampledL;
    float level = base * options.levelPerTexel;
    measure.level = uint(ceil(clamp(level, kLevelOne, most)));
    if (level <= most || options.mustFit) return measure;
    measure.kind = kSampledSplit;
    measure.split = uint(clamp(ceil(level / most), float(2), most));
    return measure;
  }
  measure.kind = kSampledOver;
  measure.shape = overShapeOf(edges, height);
  if (overCount(measure.shape) <= kTessMostSamples) return measure;
  float fit = overFit(base, height);
  if (options.mustFit) {
    measure.shape = overShapeOf(edges * fit, height * fit);
    return measure;
  }
  measure.kind = kSampledSplit;
  measure.split = uint(clamp(ceil(kLevelOne / fit), float(2), most));
  return measure;
}

TESSERA_SHARED_END
#endif
