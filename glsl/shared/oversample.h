// Oversampling: slanted triangles as right-angled blocks of texels. Based on Hladky 2019, sec. 3.3.
// The longest edge is the base, the corner opposite of it the apex. The triangle is cut along its height into
// two halves; a half is a block with the height's foot at texel (0, 0), the base along x and the height along
// y, a texel or less apart on screen. Filtering needs samples beyond the third side: a block holds every
// texel that a bilinear tap with weight can touch from inside of the half, and no more. (A tap whose weight
// rounds to nothing may fall on a texel of the other block in the rectangle: the atlas must not hold what is
// not a number.) Of the samples, 31 % lie outside for bases of 2 to 16 texels, 14 % for 2 to 256 (bases and
// slantedness log-uniform; tests/tessellation prints these). Their surface points are extrapolated: were they
// clamped to the edge, a blend with a value from nearer by would bend what is linear along each edge. See
// surfaceFromEvenOutside for the limit.
//
// A block of c columns and r rows: rows 0 and 1 have c texels, row j has 1 + ceil((c - 1) (r - j) / (r - 1)).
// Rows that lie opposite in the block fill up to one length, which gives closed forms for the number of a
// sample and for the rectangle of two blocks, one turned.
#ifndef TESSERA_GLSL_SHARED_OVERSAMPLE_H
#define TESSERA_GLSL_SHARED_OVERSAMPLE_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN
#ifdef __cplusplus
using glm::ceil;
using glm::clamp;
using glm::findMSB;
using glm::floor;
using glm::max;
using glm::min;
#endif

// Block sizes are rounded up to 8 steps an octave, exact up to 16, so that bins are few enough to share
// rectangles: 3 % more columns on average, 12.5 % at most.
SHARED_CONST uint kOverColumnClasses = 80u;  // 1 to 4096 steps
SHARED_CONST uint kOverRowClasses = 41u;     // one row, then 1 to 128 steps
SHARED_CONST uint kOverBins = kOverColumnClasses * kOverRowClasses;
SHARED_CONST uint kOverMostColumns = 4095u;  // that a record can hold; what a tessellator spawns is below it
SHARED_CONST float kOverFootSteps = 65535.0;
SHARED_CONST float kOverHalf = 0.5;
// Lower than this, in texels, a triangle is one row of samples along the middle of its height.
SHARED_CONST float kOverFlat = 0.5;
// A half narrower than half a texel, or than half its height, is not worth a block of its own: its side of
// the base is given to the other one, whose rows then shift by at most half a texel from one to the next.
// Right-angled slanted triangles are one block so.
SHARED_CONST float kOverNarrow = 0.5;

// How a triangle is sampled. Half 0 lies towards corner apex + 1, half 1 towards corner apex + 2.
struct OverShape {
  uint apex;      // 0 to 2
  uint columns0;  // texels along the base, 0 where there is no such half
  uint columns1;
  uint rows;  // texels along the height; 1: a flat triangle, of columns1 texels along the whole base
  uint foot;  // where the height meets the base, from corner apex + 1 to apex + 2, in kOverFootSteps
};

// A texel of a block. `used` is false for the few numbers that no texel has.
struct OverCell {
  bool used;
  uint side;  // the half, 0 or 1
  uvec2 at;
};

// What a triangle needs to be found again: 16 bytes.
struct OverPlace {
  OverShape shape;
  uvec2 corner0;  // atlas texel of the half's (0, 0), each below 65536
  uvec2 corner1;
  bool turned0;  // counts down from it instead of up
  bool turned1;
};

// The class of a number of steps, 1 to 4096, and the largest number of that class.
SHARED_FN uint overClass(uint steps) {
  if (steps <= 16u) return max(steps, 1u) - 1u;
  uint octave = uint(findMSB(steps - 1u));
  uint unit = octave - 3u;
  return 16u + (octave - 4u) * 8u + ((steps - 1u) >> unit) - 8u;
}
SHARED_FN uint overClassSteps(uint number) {
  if (number < 16u) return number + 1u;
  uint octave = (number - 16u) / 8u;
  return (9u + (number - 16u) % 8u) << (octave + 1u);
}

// The bin of a block, below kOverBins, and the size of the blocks of a bin.
SHARED_FN uint overBin(uint columns, uint rows) {
  uint row = rows == 1u ? 0u : 1u + overClass(rows - 1u);
  return row * kOverColumnClasses + overClass(columns - 1u);
}
SHARED_FN uvec2 overBinBlock(uint bin) {
  uint row = bin / kOverColumnClasses;
  uint rows = row == 0u ? 1u : 1u + overClassSteps(row - 1u);
  return uvec2(1u + overClassSteps(bin % kOverColumnClasses), rows);
}

// Steps of at most one texel over a length in texels.
SHARED_FN uint overSteps(float texels, float most) {
  return overClassSteps(overClass(uint(max(ceil(min(texels, most)), float(1)))));
}

// The shape for lengths in texels, all finite: edges[s] is opposite of corner s, `height` stands on the
// longest.
SHARED_FN OverShape overShapeOf(vec3 edges, float height) {
  OverShape shape;
  shape.apex = edges[0] >= edges[1] && edges[0] >= edges[2] ? 0u : (edges[1] >= edges[2] ? 1u : 2u);
  float base = edges[int(shape.apex)];
  float before = edges[int((shape.apex + 2u) % 3u)];
  float after = edges[int((shape.apex + 1u) % 3u)];
  // The projection of the shorter edge on the base: differences of squares cancel for needles.
  float foot = base > float(0) ? kOverHalf + kOverHalf * ((before - after) / base) * ((before + after) / base)
                               : float(0);
  foot = clamp(foot, float(0), float(1));
  float mostColumns = float(4096);
  if (!(height > kOverFlat)) {
    shape.rows = 1u;
    shape.columns0 = 0u;
    shape.columns1 = 1u + overSteps(base, mostColumns);
    shape.foot = uint(floor(foot * kOverFootSteps + kOverHalf));
    return shape;
  }
  shape.rows = 1u + overSteps(height, float(128));
  float narrow = max(kOverNarrow, height * kOverHalf);
  float width0 = foot * base;
  float width1 = base - width0;
  bool drop0 = width0 <= narrow && width0 <= width1;
  bool drop1 = width1 <= narrow && !drop0;
  shape.columns0 = drop0 ? 0u : 1u + overSteps(drop1 ? base : width0, mostColumns);
  shape.columns1 = drop1 ? 0u : 1u + overSteps(drop0 ? base : width1, mostColumns);
  shape.foot = uint(clamp(floor(foot * kOverFootSteps + kOverHalf), float(1), kOverFootSteps - float(1)));
  if (drop0) shape.foot = 0u;
  if (drop1) shape.foot = uint(kOverFootSteps);
  return shape;
}

SHARED_FN uint overColumns(OverShape shape, uint side) {
  return side == 0u ? shape.columns0 : shape.columns1;
}

// Texels of the row that is m rows below the apex's end: m = rows - row. 2 rows or more.
SHARED_FN uint overRowAbove(uint columns, uint rows, uint m) {
  return 1u + ((columns - 1u) * m + rows - 2u) / (rows - 1u);
}
SHARED_FN uint overRow(uint columns, uint rows, uint row) {
  return row == 0u || rows == 1u ? columns : overRowAbove(columns, rows, rows - row);
}

// Texels that rows m and rows - 1 - m have together, or one more. 3 rows or more.
SHARED_FN uint overStride(uint columns, uint rows) {
  return columns + ((columns - 1u) % (rows - 1u) == 0u ? 1u : 2u);
}

// Threads of one block: one for each texel, and at most one in each pair of rows that has none.
SHARED_FN uint overBlockCount(uint columns, uint rows) {
  if (columns == 0u || rows == 1u) return columns;
  uint rest = rows - 2u;
  uint count = 2u * columns;
  if (rest > 0u) count += (rest / 2u) * overStride(columns, rows) + (rest % 2u) * (1u + columns / 2u);
  return count;
}

// Threads of a triangle.
SHARED_FN uint overCount(OverShape shape) {
  return overBlockCount(shape.columns0, shape.rows) + overBlockCount(shape.columns1, shape.rows);
}

// The texel of a thread, 0 to overCount - 1; half 0 comes first. Each texel of the blocks has one thread.
SHARED_FN OverCell overCellOf(uint thread, OverShape shape) {
  OverCell cell;
  uint first = overBlockCount(shape.columns0, shape.rows);
  cell.side = thread < first ? 0u : 1u;
  uint rest = thread < first ? thread : thread - first;
  uint columns = overColumns(shape, cell.side);
  uint rows = shape.rows;
  cell.used = true;
  if (rows == 1u || rest < 2u * columns) {
    uint row = rest >= columns ? 1u : 0u;
    cell.at = uvec2(rest - row * columns, row);
    cell.used = row < rows;
    return cell;
  }
  rest -= 2u * columns;
  uint stride = overStride(columns, rows);
  uint pair = rest / stride;
  uint column = rest - pair * stride;
  uint m = rows - 2u - pair;
  uint texels = overRowAbove(columns, rows, m);
  if (column >= texels) {
    column -= texels;
    m = rows - 1u - m;
    cell.used = column < overRowAbove(columns, rows, m);
  }
  cell.at = uvec2(column, rows - m);
  return cell;
}

// Whether a texel's sample lies in the triangle. All of a flat triangle's do.
SHARED_FN bool overInside(uvec2 at, uint columns, uint rows) {
  return rows == 1u || at.x * (rows - 1u) + at.y * (columns - 1u) <= (columns - 1u) * (rows - 1u);
}

SHARED_FN uint overCommonDivisor(uint a, uint b) {
  while (b != 0u) {
    uint rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

// A block's texels whose samples lie in the triangle, edges included, and those whose samples do not. The whole numbers
// under a diagonal are half of their rectangle's and half of those on it.
SHARED_FN uint overBlockInside(uint columns, uint rows) {
  if (columns == 0u || rows == 1u) return columns;
  return (columns * rows + overCommonDivisor(columns - 1u, rows - 1u) + 1u) / 2u;
}
SHARED_FN uint overBlockOutside(uint columns, uint rows) {
  if (columns == 0u || rows == 1u) return 0u;
  return columns + rows - 2u - overCommonDivisor(columns - 1u, rows - 1u);
}

// The rectangle of two blocks of one size, the second turned by half a turn, in texels.
SHARED_FN uvec2 overPairSize(uint columns, uint rows) {
  if (rows == 1u) return uvec2(columns, 2u);
  return uvec2(rows == 2u ? columns : overStride(columns, rows), rows + 2u);
}

// The atlas texel of (0, 0) of a block in a rectangle at `origin`.
SHARED_FN uvec2 overCorner(uvec2 origin, uint columns, uint rows, bool turned) {
  return turned ? origin + overPairSize(columns, rows) - uvec2(1u, 1u) : origin;
}

SHARED_FN float overFoot(OverShape shape) { return float(shape.foot) / kOverFootSteps; }

// Even barycentric coordinates of a texel's sample; outside of the triangle one of them is negative. They sum
// to 1.
SHARED_FN vec3 overEven(OverCell cell, OverShape shape) {
  uint columns = overColumns(shape, cell.side);
  float foot = overFoot(shape);
  float x = float(cell.at.x) / float(columns - 1u);
  float top;   // coordinate of the apex
  float last;  // coordinate of corner apex + 2
  if (shape.rows == 1u) {
    float reach = x < foot ? x / foot : (foot < float(1) ? (float(1) - x) / (float(1) - foot) : float(1));
    top = kOverHalf * reach;
    last = x - foot * top;
  } else {
    top = float(cell.at.y) / float(shape.rows - 1u);
    last = foot * (float(1) - x - top) + (cell.side == 1u ? x : float(0));
  }
  vec3 p = vec3(top);
  p[int((shape.apex + 1u) % 3u)] = float(1) - top - last;
  p[int((shape.apex + 2u) % 3u)] = last;
  return p;
}

// Where even coordinates (clamped to the triangle) lie in the blocks: block coordinates, texels at whole
// numbers.
struct OverPoint {
  uint side;
  vec2 at;
};
SHARED_FN OverPoint overDecode(vec3 p, OverShape shape) {
  float foot = overFoot(shape);
  float top = clamp(p[int(shape.apex)], float(0), float(1));
  float along = p[int((shape.apex + 2u) % 3u)] + foot * p[int(shape.apex)];
  OverPoint point;
  point.side = shape.columns0 == 0u || (along >= foot && shape.columns1 != 0u) ? 1u : 0u;
  float x;
  if (shape.rows == 1u)
    x = along;
  else if (point.side == 1u)
    x = (along - foot) / (float(1) - foot);
  else
    x = (foot - along) / foot;
  float reach = shape.rows == 1u ? float(1) : float(1) - top;
  x = clamp(x, float(0), reach) * float(overColumns(shape, point.side) - 1u);
  point.at = vec2(x, top * float(shape.rows - 1u));
  return point;
}

// Block coordinates are linear in even coordinates on each side of the height. Those of a corner of the triangle in half
// `side`, beyond the block where the corner is the other half's: x of half 1 is negative where a point is half 0's.
SHARED_FN vec2 overCornerAt(uint corner, uint side, OverShape shape) {
  float foot = overFoot(shape);
  float along = corner == shape.apex ? foot : (corner == (shape.apex + 2u) % 3u ? float(1) : float(0));
  float x = along;
  if (shape.rows > 1u) x = side == 1u ? (along - foot) / (float(1) - foot) : (foot - along) / foot;
  float y = corner == shape.apex ? float(shape.rows - 1u) : float(0);
  return vec2(x * float(overColumns(shape, side) - 1u), y);
}

// Atlas texels of a point of a block, and of one of its texels; `corner` of overCorner.
SHARED_FN vec2 overAtlasAt(vec2 at, uvec2 corner, bool turned) {
  return vec2(float(corner.x), float(corner.y)) + (turned ? -at : at) + vec2(kOverHalf);
}
SHARED_FN uvec2 overAtlasTexel(uvec2 at, uvec2 corner, bool turned) { return turned ? corner - at : corner + at; }

SHARED_FN uvec4 packOver(OverPlace place) {
  OverShape shape = place.shape;
  return uvec4(place.corner0.x | (place.corner0.y << 16u), place.corner1.x | (place.corner1.y << 16u),
               shape.columns0 | (shape.columns1 << 12u) | (place.turned0 ? 1u << 24u : 0u) |
                   (place.turned1 ? 1u << 25u : 0u) | (shape.apex << 26u),
               shape.foot | (shape.rows << 16u));
}
SHARED_FN OverPlace unpackOver(uvec4 words) {
  OverPlace place;
  place.corner0 = uvec2(words.x & 0xffffu, words.x >> 16u);
  place.corner1 = uvec2(words.y & 0xffffu, words.y >> 16u);
  place.shape.columns0 = words.z & 4095u;
  place.shape.columns1 = (words.z >> 12u) & 4095u;
  place.turned0 = ((words.z >> 24u) & 1u) != 0u;
  place.turned1 = ((words.z >> 25u) & 1u) != 0u;
  place.shape.apex = min((words.z >> 26u) & 3u, 2u);
  place.shape.foot = words.w & 0xffffu;
  place.shape.rows = words.w >> 16u;
  return place;
}

TESSERA_SHARED_END
#endif
