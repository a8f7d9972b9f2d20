// L-packing: the samples of a triangle tessellated with one level for all sides, unfolded into an L of
// texels. Based on Hladky 2019, sec. 3.2, eq. 3 and 4. Each corner ("tip") owns the samples nearest to it, a
// square; tip 0 is the L's corner, tip 1 its arm along x, tip 2 its arm along y. The seams 0|1 and 0|2 stay
// sewn; the cut 1|2 is open, and what filtering needs across it is written twice. l is the level, h = l / 2.
// L coordinates count texels from tip 0's corner, samples at whole numbers.
//
// Both parities are used. With even levels only, the level that reaches a wanted size s (s log-uniform) has
// more samples than s asks for by 41 % for s in [1, 8] and 6 % in [8, 64]; with all levels by 21 % and 3 %.
// Duplicates are 8.8 % and 1.7 % of the samples with even levels, 10.2 % and 1.8 % with all: less than a
// tenth of what is gained. (tests/tessellation prints these.)
#ifndef TESSERA_GLSL_SHARED_LPACK_H
#define TESSERA_GLSL_SHARED_LPACK_H
#include "shared/dialect.h"
#include "shared/perspective_map.h"
#include "shared/tessellation.h"
TESSERA_SHARED_BEGIN
#ifdef __cplusplus
using glm::clamp;
#endif

SHARED_CONST uint kLLevels = 65u;           // 0 (one texel) to 64; each is a bin
SHARED_CONST uint kLMostSlots = 1u << 24u;  // of a bin, two a rectangle

// What a triangle needs to be found again: 4 bytes.
struct LPlace {
  uint level;  // 0 to 64
  uint slot;   // in the level's bin, below kLMostSlots; odd ones are turned
};

SHARED_FN uint packL(LPlace place) { return place.level | (place.slot << 8u); }
SHARED_FN LPlace unpackL(uint word) {
  LPlace place;
  place.level = min(word & 127u, kLLevels - 1u);
  place.slot = word >> 8u;
  return place;
}

// Thickness of the arm along y, and of the arm along x: the latter has a row more in odd levels, where the
// cut runs between two rows.
SHARED_FN uint lArmY(uint level) { return level / 2u + 1u; }
SHARED_FN uint lArmX(uint level) { return level == 0u ? 1u : level / 2u + 1u + (level & 1u); }

// Texels of the L. Its arms are level + 1 long.
SHARED_FN bool lContains(uvec2 at, uint level) {
  return at.x <= level && at.y <= level && (at.x < lArmY(level) || at.y < lArmX(level));
}
SHARED_FN uint lTexels(uint level) {
  return (level + 1u) * (level + 1u) - (level + 1u - lArmY(level)) * (level + 1u - lArmX(level));
}

// The rectangle of two Ls, one turned by half a turn: their arms along y stand side by side. Odd levels fill
// it without a gap, even ones leave two half rows: of the rectangle's texels 70 % are samples at level 2, each
// counted once, and 98 % at 64. Level 0 is two texels.
SHARED_FN uvec2 lPairSize(uint level) {
  return uvec2(2u * lArmY(level), level == 0u ? 1u : level + 1u + lArmX(level));
}

// The texels of a sample, in L coordinates.
struct LTexels {
  uvec2 first;
  uvec2 second;  // the same as `first` where there is no other
};

// Where a sample is written. One-to-one: no two samples share a texel, and each texel of the L has one.
SHARED_FN LTexels lTexelsOf(TessPlace place, uint level) {
  LTexels texels;
  uint steps = level - 2u * place.ring;
  uint back = steps - place.step;
  // The nearer of the side's two corners is the tip; x counts towards the next corner, y towards the previous
  // one.
  bool further = place.step >= back;
  uint tip = (place.side + (further ? 2u : 1u)) % 3u;
  uint x = place.ring + (further ? 0u : place.step);
  uint y = place.ring + (further ? back : 0u);
  texels.first = uvec2(x, y);
  if (tip == 1u) texels.first = uvec2(level - y, x);
  if (tip == 2u) texels.first = uvec2(y, level - x);
  texels.second = texels.first;
  if (tip == 2u && y == level / 2u) texels.second = uvec2(level - x, level - y);
  return texels;
}

// Texels of an L by number: the arm along x row by row, then what the other one has besides.
SHARED_FN uvec2 lTexelOfNumber(uint level, uint number) {
  uint along = level + 1u;
  uint first = along * lArmX(level);
  uint width = number < first ? along : lArmY(level);
  uint rest = number < first ? number : number - first;
  return uvec2(rest % width, rest / width + (number < first ? 0u : lArmX(level)));
}
SHARED_FN uint lNumberOfTexel(uint level, uvec2 at) {
  uint arm = lArmX(level);
  if (at.y < arm) return at.y * (level + 1u) + at.x;
  return arm * (level + 1u) + (at.y - arm) * lArmY(level) + at.x;
}

// The sample of a texel of the L; the inverse of lTexelsOf, for gatherers that start from texels.
SHARED_FN TessPlace lPlaceOf(uvec2 at, uint level) {
  uint middle = level / 2u;
  uint tip = at.x > middle ? 1u : (at.y > middle ? 2u : 0u);
  uint x = tip == 0u ? at.x : (tip == 1u ? at.y : level - at.y);
  uint y = tip == 0u ? at.y : (tip == 1u ? level - at.x : at.x);
  TessPlace place;
  place.ring = min(x, y);
  uint steps = level - 2u * place.ring;
  place.side = (tip + (x >= y ? 2u : 1u)) % 3u;
  place.step = x >= y ? x - place.ring : steps - (y - place.ring);
  if (steps == 0u) {
    place.side = 0u;
    place.step = 0u;
  } else if (place.step == steps) {
    place.side = (place.side + 1u) % 3u;
    place.step = 0u;
  }
  return place;
}

// From a tip's square into the L; `at` in [0, l / 2]. Beyond column h of tip 2 lies the cut of odd levels,
// whose cells are whole in the arm of tip 1 only.
SHARED_FN vec2 lUnfold(uint tip, vec2 at, uint level) {
  float end = float(level);
  if (tip == 0u) return at;
  if (tip == 1u) return vec2(end - at.y, at.x);
  if (at.y > float(level / 2u)) return vec2(end - at.x, end - at.y);
  return vec2(at.y, end - at.x);
}

SHARED_FN uint largestOf(vec3 p) { return p[0] >= p[1] && p[0] >= p[2] ? 0u : (p[1] >= p[2] ? 1u : 2u); }

// Coordinates of the corners that come after a tip and before it.
SHARED_FN vec2 aroundTip(vec3 p, uint tip) {
  return vec2(tip == 0u ? p[1] : (tip == 1u ? p[2] : p[0]), tip == 0u ? p[2] : (tip == 1u ? p[0] : p[1]));
}

// Row and column of Hladky 2019, eq. 4, as x (towards the next corner) and y in the tip's square. `p` sums
// to 1.
SHARED_FN vec2 lSquareAt(vec3 p, uint tip, uint level) {
  vec2 around = aroundTip(p, tip);
  float next = around.x;
  float previous = around.y;
  float least = min(next, previous);
  float row = least * float(3u * level) * kTessRound;
  float column = (max(next, previous) + least * kTessRound) * float(level);
  // Rounding must not lead out of the square, nor out of the row that the last ring ends in.
  float most = float(level) * kTessRound;
  row = min(row, most);
  column = clamp(column, row, most);
  return next >= previous ? vec2(column, row) : vec2(row, column);
}

// L coordinates of even coordinates `p` (clamped to the triangle), to be filtered bilinearly. All four taps
// are this triangle's. Plain: off by up to 0.15 of a sample step in the cells on the lines from the corners
// to the centre, and more in the innermost triangle of odd levels.
SHARED_FN vec2 lDecodePlain(vec3 p, uint level) {
  vec3 at = clampedBary(p);
  uint tip = largestOf(at);
  return lUnfold(tip, lSquareAt(at, tip, level), level);
}

// The same, with these cells' bilinear patches inverted: what is linear over the triangle comes out of the
// filter as it was. In such a cell, with u and v in steps from its first corner, u = s - s t / 3 and v = t -
// s t / 3.
SHARED_FN vec2 lDecodeExact(vec3 p, uint level) {
  vec3 at = clampedBary(p);
  uint tip = largestOf(at);
  vec2 plain = lSquareAt(at, tip, level);
  uint middle = level / 2u;
  float ring = floor(min(plain.x, plain.y));
  float start = ring * float(2) / float(3);
  if ((level & 1u) == 1u && ring >= float(middle)) {
    // Three samples around the centre; the cell's fourth texel repeats tip 2's.
    start = float(2u * middle) / float(3);
    float u = clamp(at[1] * float(level) - start, float(0), float(1));
    float v = clamp(at[2] * float(level) - start, float(0), float(1));
    float rest = float(1) - v;
    float s = rest > u ? u / rest : (v < float(1) ? float(1) : float(0));
    return vec2(float(middle) + s, float(middle) + v);
  }
  if (max(plain.x, plain.y) >= ring + float(1) || ring >= float(middle)) return lUnfold(tip, plain, level);
  vec2 around = aroundTip(at, tip) * float(level) - vec2(start);
  float u = around.x;
  float v = around.y;
  float difference = u - v;
  float a = float(1) + difference / float(3);
  float s = float(3) * kTessRound * (a - sqrt(max(a * a - u * float(4) / float(3), float(0))));
  float t = clamp(s - difference, float(0), float(1));
  return lUnfold(tip, vec2(ring + clamp(s, float(0), float(1)), ring + t), level);
}

// Atlas texels of L coordinates, of samples or of points between them; `origin` of the rectangle.
SHARED_FN vec2 lAtlasAt(vec2 at, uvec2 origin, uint level, bool turned) {
  uvec2 size = lPairSize(level);
  vec2 inside = at + vec2(kTessRound);
  if (turned) inside = vec2(float(size.x), float(size.y)) - inside;
  return vec2(float(origin.x), float(origin.y)) + inside;
}
SHARED_FN uvec2 lAtlasTexel(uvec2 at, uvec2 origin, uint level, bool turned) {
  uvec2 size = lPairSize(level);
  return origin + (turned ? size - uvec2(1u, 1u) - at : at);
}

TESSERA_SHARED_END
#endif
