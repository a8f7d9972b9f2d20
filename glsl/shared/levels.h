// Level selection: how large the block of a patch should be. Based on Mueller 2021, sec. 3.5.
// Lengths are pixels on a curved image plane (angle times pixels per radian), so they do not depend on where
// the camera looks. Everything here is total: any float, NaN and infinity included, gives a valid level.
#ifndef TESSERA_GLSL_SHARED_LEVELS_H
#define TESSERA_GLSL_SHARED_LEVELS_H
#include "shared/dialect.h"
#ifdef __cplusplus
#define SHARED_PRECISE
#else
#define SHARED_PRECISE precise
#endif
TESSERA_SHARED_BEGIN
#ifdef __cplusplus
using glm::abs;
using glm::acos;
using glm::clamp;
using glm::cross;
using glm::dot;
using glm::exp2;
using glm::floor;
using glm::length;
using glm::log2;
using glm::max;
using glm::min;
using glm::sqrt;
inline uint floatBitsToUint(float value) { return std::bit_cast<uint>(value); }
#endif

SHARED_CONST uint kMaxBlockLog2 = 10u;      // the largest superblock is 1024 x 1024 texels
SHARED_CONST uint kLevelTransposed = 256u;  // the block's width runs along the patch's y axis
SHARED_CONST uint kLevelPending =
    512u;                             // the patch drew a slot and waits for its block (inside a frame only)
SHARED_CONST uint kLevelReduced = 1024u;  // smaller than the patch asked for, for want of memory
SHARED_CONST uint kLevelSize = 255u;  // mask of w and h
SHARED_CONST float kLevelHalf = 0.5;
SHARED_CONST float kLevelOne = 1.0;
SHARED_CONST float kLevelZero = 0.0;
SHARED_CONST float kPi = 3.14159265358979;
SHARED_CONST float kHalfPi = 1.57079632679490;
SHARED_CONST float kQuarterPi = 0.785398163397448;
SHARED_CONST float kTangent22 = 0.414213562373095;  // tan(pi / 8)
SHARED_CONST float kArc0 = -0.3333295512;
SHARED_CONST float kArc1 = 0.1997792017;
SHARED_CONST float kArc2 = -0.1387978016;
SHARED_CONST float kArc3 = 0.08060065663;
SHARED_CONST float kSmallestArea = 1.0e-30;  // pixels; what has no area counts as this
SHARED_CONST float kLargestArea = 1.0e30;
SHARED_CONST float kFarthestCorner = 1.0e9;  // distance from the eye up to which cross products stay finite
SHARED_CONST float kLargestBias = 32.0;      // takes every patch to one texel

// What the level of a patch is chosen from. 8 bytes, one a visible patch.
struct PatchMeasure {
  float logArea;    // log2 of the ideal block area in pixels, before any bias; in [-100, 100]
  float logAspect;  // log2 of the patch's extent along x over that along y; in [-20, 20]
};

// Infinity and NaN by their bits: compilers may assume that comparisons never meet a NaN.
SHARED_FN bool isFiniteNumber(float value) { return (floatBitsToUint(value) & 0x7f800000u) != 0x7f800000u; }

// atan2 for y >= 0, to 3e-7 relative: drivers may have far less (Mesa 22.3: 5e-6), and flat triangles
// multiply the error of their edges. Reduced to |x| <= tan(pi / 8), where atan(x) / x - 1 is x^2 times a
// cubic in x^2, fitted to 2e-8.
SHARED_FN float upperArcTangent(float y, float x) {
  float side = abs(x);
  float large = max(side, y);
  if (!(large > kLevelZero)) return kLevelZero;
  float ratio = min(side, y) / large;
  bool reduced = ratio > kTangent22;
  float t = reduced ? (ratio - kLevelOne) / (ratio + kLevelOne) : ratio;
  float z = t * t;
  float cubic = ((kArc3 * z + kArc2) * z + kArc1) * z + kArc0;
  float angle = (t + t * z * cubic) + (reduced ? kQuarterPi : kLevelZero);
  if (y > side) angle = kHalfPi - angle;
  return x < kLevelZero ? kPi - angle : angle;
}

// The angle between two vectors in radians, 0 to pi. The cross product is taken with the difference, which is
// exact for vectors that lie close together, so small angles keep all their digits. 0 where a vector is zero.
SHARED_FN float angleBetween(vec3 a, vec3 b) {
  float sine = length(cross(a, b - a));
  float cosine = dot(a, b);
  return upperArcTangent(sine, cosine);
}

// The same as printed (Mueller 2021, eq. 3.1): loses all digits below some 3.5e-4 rad. For accuracy studies.
SHARED_FN float angleByAcos(vec3 a, vec3 b) { return acos(dot(a, b) / (length(a) * length(b))); }

// Area of a triangle from its edge lengths, Kahan's ordered form: full relative accuracy for needles. Lengths
// that break the triangle inequality by rounding give 0.
SHARED_FN float triangleArea(float x, float y, float z) {
  float a = max(x, max(y, z));
  float c = min(x, min(y, z));
  float b = max(min(x, y), min(max(x, y), z));
  SHARED_PRECISE float left = (a + (b + c)) * (a + (b - c));
  SHARED_PRECISE float right = (c - (a - b)) * (c + (a - b));
  return sqrt(left) * sqrt(max(right, kLevelZero)) / float(4);
}

// The same by Heron's formula as printed: cancels for needles. For accuracy studies.
SHARED_FN float triangleAreaByHeron(float a, float b, float c) {
  SHARED_PRECISE float s = (a + b + c) / float(2);
  SHARED_PRECISE float square = s * (s - a) * (s - b) * (s - c);
  return sqrt(max(square, kLevelZero));
}

SHARED_FN float safeLog2(float value) {
  if (!isFiniteNumber(value)) return log2(kSmallestArea);
  return log2(clamp(value, kSmallestArea, kLargestArea));
}

// What measuring takes: the stable forms, unless a study asks for the others (see NumericForms).
SHARED_FN float measuredAngle(vec3 a, vec3 b) {
#ifdef ANGLES_BY_ACOS
  return angleByAcos(a, b);
#else
  return angleBetween(a, b);
#endif
}
SHARED_FN float measuredArea(float a, float b, float c) {
#ifdef AREAS_BY_HERON
  return triangleAreaByHeron(a, b, c);
#else
  return triangleArea(a, b, c);
#endif
}

// Measures a patch from its corners relative to the eye, laid out as PatchGeometry says; `triangles` is 1
// to 3. The area is that of the whole block: a single fills half of its block, so its block has twice its
// area. The aspect compares the longest of the edges that run along x in the block with the longest along y.
// A patch with a corner that is not finite or farther than kFarthestCorner has no area.
SHARED_FN PatchMeasure measurePatch(vec3 v0, vec3 v1, vec3 v2, vec3 v3, vec3 v4, uint triangles,
                                    float pixelsPerRadian) {
  float e01 = measuredAngle(v0, v1);
  float e12 = measuredAngle(v1, v2);
  float e02 = measuredAngle(v0, v2);
  float first = measuredArea(e01, e12, e02);
  float area = first + first;
  float x = e01;
  float y = e12;
  if (triangles > 1u) {
    float e23 = measuredAngle(v2, v3);
    float e03 = measuredAngle(v0, v3);
    area = first + measuredArea(e02, e23, e03);
    if (triangles > 2u) {
      float e34 = measuredAngle(v3, v4);
      float e04 = measuredAngle(v0, v4);
      area += measuredArea(e03, e34, e04);
      x = max(e01 + e04, e23);
      y = max(e12, e34);
    } else {
      x = max(e01, e23);
      y = max(e12, e03);
    }
  }
  PatchMeasure measure;
  float reach = dot(abs(v0) + abs(v1) + abs(v2) + abs(v3) + abs(v4), vec3(kLevelOne));
  if (!isFiniteNumber(reach) || reach > kFarthestCorner) area = kLevelZero;
  measure.logArea = safeLog2(area * pixelsPerRadian * pixelsPerRadian);
  float aspect = safeLog2(x) - safeLog2(y);
  // A side without length says nothing about the shape of a block; that of a patch without area does not
  // matter.
  measure.logAspect = clamp(aspect, -float(2u * kMaxBlockLog2), float(2u * kMaxBlockLog2));
  return measure;
}

// A level: the block is 2^w x 2^h texels, w >= h. Bits 0-3 w, bits 4-7 h, then flags.
SHARED_FN uint packLevel(uint w, uint h, bool transposed) {
  return w | (h << 4u) | (transposed && w != h ? kLevelTransposed : 0u);
}
SHARED_FN uint levelWidth(uint level) { return level & 15u; }
SHARED_FN uint levelHeight(uint level) { return (level >> 4u) & 15u; }
SHARED_FN bool levelTransposed(uint level) { return (level & kLevelTransposed) != 0u; }
SHARED_FN uint levelTexels(uint level) { return 1u << (levelWidth(level) + levelHeight(level)); }

// The block sizes that may be chosen, log2 of texels.
struct LevelRange {
  uint smallest;  // no side is shorter; 0 allows blocks of one texel
  uint largest;   // no side is longer; at most kMaxBlockLog2
  uint aspect;    // w - h is at most this; at least 1, or areas that are odd powers of two would have no block
};

// The largest w - h that blocks of log2 area `area` can have; of the parity of `area`.
SHARED_FN int widestAspect(int area, LevelRange range) {
  int fits = min(area - 2 * int(range.smallest), 2 * int(range.largest) - area);
  int most = int(range.aspect);
  return min(fits, most - ((most ^ area) & 1));
}

// The level nearest to a measure under two biases: log2 area minus them rounded, then log2 aspect rounded to
// the same parity, both within the range (Mueller 2021, eq. 3.2). `pressure` is taken off what the largest
// block leaves of the area, as pressureBias counts it: else patches larger than that would not shrink at all.
// `previous` is kept while the ideal lies within half a step plus `hysteresis` (in log2 of area, and of aspect)
// of it; pass hysteresis < 0 for none. What is not a number becomes the smallest block.
SHARED_FN uint selectLevel(PatchMeasure measure, float bias, float pressure, LevelRange range, uint previous,
                           float hysteresis) {
  float smallest = float(2u * range.smallest);
  float largest = float(2u * range.largest);
  uint least = packLevel(range.smallest, range.smallest, false);
  float ideal = measure.logArea - bias;
  if (!isFiniteNumber(ideal)) return least;
  float wanted = min(ideal, largest) - pressure;
  float aspect = measure.logAspect;
  if (!isFiniteNumber(wanted) || !isFiniteNumber(aspect)) return least;
  float idealArea = clamp(wanted, smallest, largest);
  if (hysteresis >= kLevelZero) {
    int w = int(levelWidth(previous));
    int h = int(levelHeight(previous));
    int spread = levelTransposed(previous) ? h - w : w - h;
    int widest = widestAspect(w + h, range);
    float limit = float(widest);
    // Aspects of one parity lie two apart, so half a step is 1. The record of a failed request may lie outside
    // of the range.
    if (h >= int(range.smallest) && h <= w && w <= int(range.largest) && w - h <= widest &&
        abs(idealArea - float(w + h)) <= kLevelHalf + hysteresis &&
        abs(clamp(aspect, -limit, limit) - float(spread)) <= kLevelOne + hysteresis)
      return previous & (kLevelSize | kLevelTransposed);
  }
  int area = int(floor(idealArea + kLevelHalf));
  int widest = widestAspect(area, range);
  float idealAspect = clamp(aspect, -float(widest), float(widest));
  // widest has the parity of area, so rounding to that parity cannot leave the range.
  int spread = area + 2 * int(floor((idealAspect - float(area)) / float(2) + kLevelHalf));
  int wide = abs(spread);
  return packLevel(uint(area + wide) / 2u, uint(area - wide) / 2u, spread < 0);
}

// Texels of the smallest block: what no bias makes smaller.
SHARED_FN uint smallestTexels(LevelRange range) { return 1u << (2u * range.smallest); }

// The ideal block area of a patch in whole texels, clamped to the smallest and the largest block: its share
// of I.
SHARED_FN uint idealTexels(PatchMeasure measure, float bias, LevelRange range) {
  float wanted = measure.logArea - bias;
  if (!isFiniteNumber(wanted)) return smallestTexels(range);
  // Rounded in log2 like the level, a patch below this becomes the smallest block.
  if (wanted < float(2u * range.smallest) + kLevelHalf) return smallestTexels(range);
  return uint(exp2(min(wanted, float(2u * range.largest))) + kLevelHalf);
}

// A sum of texels in 64 bits, of which a pressure bias of `bias` is taken off.
SHARED_FN float biasedTexels(uint low, uint high, float bias) {
  return (float(high) * float(65536) * float(65536) + float(low)) * exp2(-bias);
}

// b = log2((I - d) / (S - d)) (Mueller 2021, eq. 3.3), at least `lowest`: 0 where room to spare shall not make
// blocks larger than ideal, -2 for up to four times the texels. I - d = high * 2^32 + low texels of the patches
// above the smallest block, `least` patches are at the smallest block, which is d texels, S = `target` texels.
SHARED_FN float pressureBias(uint low, uint high, uint least, LevelRange range, float target, float lowest) {
  float scalable = biasedTexels(low, high, kLevelZero);
  if (scalable < kLevelOne) return kLevelZero;
  // Not in whole numbers: many patches whose smallest block is large take more than 2^32 texels.
  float room = target - float(least) * float(smallestTexels(range));
  if (!isFiniteNumber(room) || room < kLevelOne) return kLargestBias;
  return clamp(log2(scalable / room), lowest, kLargestBias);
}

// Want of memory. Where a level has no block left, one of half the width and height is a better picture than a texel:
// the next smaller level, `level` itself where there is none in the range. Blocks are two texels wide at least.
SHARED_FN uint smallerLevel(uint level, LevelRange range) {
  uint w = levelWidth(level);
  uint h = levelHeight(level);
  uint least = max(range.smallest, 1u);
  if (w <= least && h <= range.smallest) return level;
  w = max(w, least + 1u) - 1u;
  h = max(h, range.smallest + 1u) - 1u;
  return packLevel(w, h, levelTransposed(level));
}

// Whether a patch that wants `wanted` holds a smaller block `current` for want of memory. To ask again each frame would
// only move it about.
SHARED_FN bool waitsForMemory(uint current, uint wanted) {
  return (current & kLevelReduced) != 0u && levelWidth(wanted) >= levelWidth(current) &&
         levelHeight(wanted) >= levelHeight(current);
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::PatchMeasure) == 8);
static_assert(sizeof(tessera::glsl::LevelRange) == 12);
#endif
#endif
