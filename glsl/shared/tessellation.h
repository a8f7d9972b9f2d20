// The vertices that a tessellator spawns for a triangle, counted and numbered. Based on Hladky, Seidel and
// Steinberger, "Tessellated Shading Streaming" (2019), sec. 3.1 and 3.3, and on the OpenGL 4.6 specification,
// sec. 11.2.2: equal_spacing, point_mode, so that each vertex of the pattern is one sample.
// The pattern is a set of rings, ring 0 on the triangle's edges. Side s of a ring is where barycentric s is
// smallest; its samples are counted from corner s + 1 (step 0) towards corner s + 2, which belongs to the
// next side.
#ifndef TESSERA_GLSL_SHARED_TESSELLATION_H
#define TESSERA_GLSL_SHARED_TESSELLATION_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN
#ifdef __cplusplus
using glm::floor;
using glm::max;
using glm::min;
using glm::sqrt;
#endif

SHARED_CONST uint kTessLargest = 64u;        // the largest level of any side that OpenGL promises
SHARED_CONST uint kTessOuterMost = 192u;     // samples of ring 0 with all outer levels at the largest
SHARED_CONST uint kTessMostSamples = 3169u;  // of one triangle: all levels at the largest
SHARED_CONST uint kTessFewestSamples = 3u;   // a triangle that is not discarded has its corners
SHARED_CONST float kTessRound = 0.5;

// gl_TessLevelOuter[0..2] and gl_TessLevelInner[0], whole numbers in [1, kTessLargest].
struct TessLevels {
  uint outer0;  // of the edge where barycentric 0 is 0, and so on
  uint outer1;
  uint outer2;
  uint inner;
};

// One sample. `step` counts along `side` of `ring`; the centre of an even pattern is step 0 of side 0.
struct TessPlace {
  uint ring;
  uint side;
  uint step;
};

// The pattern with all four levels equal, as L-packing uses it.
SHARED_FN TessLevels tessUniform(uint level) {
  TessLevels levels;
  levels.outer0 = level;
  levels.outer1 = level;
  levels.outer2 = level;
  levels.inner = level;
  return levels;
}

SHARED_FN uint tessOuter(TessLevels levels, uint side) {
  return side == 0u ? levels.outer0 : (side == 1u ? levels.outer1 : levels.outer2);
}

SHARED_FN uint tessOuterSum(TessLevels levels) { return levels.outer0 + levels.outer1 + levels.outer2; }

// The inner level that OpenGL uses: 1 counts as 2 where an edge is subdivided.
SHARED_FN uint tessInner(TessLevels levels) {
  return levels.inner == 1u && tessOuterSum(levels) > 3u ? 2u : levels.inner;
}

// Samples in the rings from 1 inwards, for inner level 1 to kTessLargest.
SHARED_FN uint tessInterior(uint inner) {
  uint rings = (inner - 1u) / 2u;
  return 3u * rings * (inner - rings - 1u) + (inner + 1u) % 2u;
}

SHARED_FN uint tessCount(TessLevels levels) { return tessOuterSum(levels) + tessInterior(tessInner(levels)); }

// Samples with all four levels equal; 1 for level 0, which is a triangle of one texel. Hladky 2019, eq. 1.
SHARED_FN uint tessUniformCount(uint level) { return level == 0u ? 1u : 3u * level + tessInterior(level); }

// The levels that spawn exactly `count` samples, kTessFewestSamples to kTessMostSamples (what is outside is
// clamped): the smallest inner level that reaches it, then the rest over the edges, as even as can be.
SHARED_FN TessLevels tessLevelsFor(uint count) {
  uint wanted = min(max(count, kTessFewestSamples), kTessMostSamples);
  uint inside = wanted - min(wanted, kTessOuterMost);
  // tessInterior(l) is 3/4 (l - 1)^2, rounded up. The root of a whole number may come out low.
  uint inner = 1u + uint(sqrt(float(4u * inside) / float(3)));
  if (tessInterior(inner) < inside) inner += 1u;
  if (inner > 2u && tessInterior(inner - 1u) >= inside) inner -= 1u;
  if (inner < 2u && wanted > kTessFewestSamples) inner = 2u;
  uint edges = wanted - tessInterior(inner);
  TessLevels levels;
  levels.outer0 = (edges + 2u) / 3u;
  levels.outer1 = (edges + 1u) / 3u;
  levels.outer2 = edges / 3u;
  levels.inner = inner;
  return levels;
}

SHARED_FN int tessNearest(float value) { return int(floor(value + kTessRound)); }

// The place of the sample at `at`, gl_TessCoord. Forgiving: coordinates inside may be off by a twentieth of a
// step, as fixed-point hardware makes them. For the sample itself take tessBary of the place, which is the
// same on all hardware and in compute shaders.
SHARED_FN TessPlace tessPlaceAt(vec3 at, TessLevels levels) {
  uint inner = tessInner(levels);
  float least = min(at[0], min(at[1], at[2]));
  TessPlace place;
  place.ring = uint(max(tessNearest(least * float(3u * inner) * kTessRound), 0));
  if (place.ring == 0u) {
    place.side = at[0] <= least ? 0u : (at[1] <= least ? 1u : 2u);
    uint steps = tessOuter(levels, place.side);
    place.step = uint(max(tessNearest(at[int((place.side + 2u) % 3u)] * float(steps)), 0));
    if (place.step >= steps) {
      place.side = (place.side + 1u) % 3u;
      place.step = 0u;
    }
    return place;
  }
  place.ring = min(place.ring, inner / 2u);
  int steps = int(inner - 2u * place.ring);
  float start = float(2u * place.ring) / float(3);
  int step0 = tessNearest(at[0] * float(inner) - start);
  int step1 = tessNearest(at[1] * float(inner) - start);
  int step2 = tessNearest(at[2] * float(inner) - start);
  place.side = 2u;
  place.step = uint(max(step1, 0));
  if (step0 <= 0 && step2 < steps) {
    place.side = 0u;
    place.step = uint(max(step2, 0));
  } else if (step1 <= 0 && step0 < steps) {
    place.side = 1u;
    place.step = uint(max(step0, 0));
  }
  if (steps == 0) {
    place.side = 0u;
    place.step = 0u;
  }
  return place;
}

// The barycentric coordinates of a place: gl_TessCoord up to the tessellator's rounding (Mesa 22.3: 2.5e-4).
SHARED_FN vec3 tessBary(TessPlace place, TessLevels levels) {
  uint inner = tessInner(levels);
  uint steps = place.ring == 0u ? tessOuter(levels, place.side) : inner - 2u * place.ring;
  // In thirds of a step, all corners of a ring have whole numbers.
  uint start = 2u * place.ring;
  float unit = float(1) / float(3u * (place.ring == 0u ? steps : inner));
  vec3 at = vec3(float(start) * unit);
  at[int((place.side + 1u) % 3u)] = float(start + 3u * (steps - place.step)) * unit;
  at[int((place.side + 2u) % 3u)] = float(start + 3u * place.step) * unit;
  return at;
}

// The number of a place, 0 to tessCount - 1: ring by ring, side by side. One-to-one for all levels.
SHARED_FN uint tessThread(TessPlace place, TessLevels levels) {
  if (place.ring == 0u) {
    uint before = place.side == 0u ? 0u : (place.side == 1u ? levels.outer0 : levels.outer0 + levels.outer1);
    return before + place.step;
  }
  uint inner = tessInner(levels);
  uint outside = 3u * (place.ring - 1u) * (inner - place.ring);
  return tessOuterSum(levels) + outside + place.side * (inner - 2u * place.ring) + place.step;
}

// The inverse of tessThread: what a compute shader spawns instead of a tessellator.
SHARED_FN TessPlace tessPlaceOf(uint thread, TessLevels levels) {
  TessPlace place;
  place.ring = 0u;
  uint outer = tessOuterSum(levels);
  if (thread < outer) {
    uint second = levels.outer0 + levels.outer1;
    place.side = thread < levels.outer0 ? 0u : (thread < second ? 1u : 2u);
    place.step = thread - (place.side == 0u ? 0u : (place.side == 1u ? levels.outer0 : second));
    return place;
  }
  uint inner = tessInner(levels);
  uint inside = thread - outer;
  // r whole rings lie outside of sample 3 r (inner - 1 - r). The root may come out a ring off.
  float middle = float(inner - 1u);
  float root = sqrt(max(middle * middle - float(4u * inside) / float(3), float(0)));
  uint rings = uint(max(floor((middle - root) * kTessRound), float(0)));
  uint most = inner / 2u - 1u;
  rings = min(rings, most);
  if (rings < most && 3u * (rings + 1u) * (inner - 2u - rings) <= inside) rings += 1u;
  if (rings > 0u && 3u * rings * (inner - 1u - rings) > inside) rings -= 1u;
  place.ring = rings + 1u;
  uint rest = inside - 3u * rings * (inner - 1u - rings);
  uint steps = inner - 2u * place.ring;
  place.side = steps == 0u ? 0u : rest / steps;
  place.step = rest - place.side * steps;
  return place;
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(tessera::glsl::kTessOuterMost == 3 * tessera::glsl::kTessLargest);
#endif
#endif
