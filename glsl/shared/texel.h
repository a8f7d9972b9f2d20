// Texel Shading (Hillesland & Yang 2016; the baseline of Hladky 2019, sec. 5.2): each patch has a chart of
// its own in an object-space texture with mip levels, of which only those tiles are shaded that pixels touch,
// at the pixels' level. The texture is virtual: a table says which slot of the atlas a tile has.
//
// A tile is 8 x 8 texels and 7 x 7 cells between them: neighbours share a row of texels, so that a bilinear
// fetch never leaves a tile. A chart has 7 * 2^n cells along a side at its finest level, so tiles of one
// level lie exactly in those of the next.
#ifndef TESSERA_GLSL_SHARED_TEXEL_H
#define TESSERA_GLSL_SHARED_TEXEL_H
#include "shared/dialect.h"
#include "shared/levels.h"
TESSERA_SHARED_BEGIN

#define TEXEL_GROUP 64

SHARED_CONST uint kTexelTile = 8u;         // texels a side
SHARED_CONST uint kTexelCells = 7u;        // cells a side
SHARED_CONST uint kTexelLargestLog2 = 8u;  // tiles along a chart's side, at most 2^8
// Levels below the one with a single tile: of 4, 2 and 1 cells. Beyond them is the record: one texel, always
// there.
SHARED_CONST uint kTexelSmallLevels = 3u;
SHARED_CONST uint kTexelLevels = kTexelLargestLog2 + kTexelSmallLevels + 1u;
// How often a frame may make all tiles a level coarser: enough for nothing but records to be left.
SHARED_CONST uint kTexelRounds = kTexelLevels;
SHARED_CONST uint kTexelProbes = 256u;           // places of the table that a tile may be in
SHARED_CONST uint kChartRepeated = 0x80000000u;  // of a draw entry: another one has the same patch

// Of a patch instance. 8 bytes.
struct TexelChart {
  uint base;  // number of its first tile; 0 is none
  uint size;  // log2 of tiles at the finest level: along x in bits 0-7, along y in bits 8-15; kChartSingle
};

SHARED_CONST uint kChartSingle = 65536u;  // the patch is one triangle, below the chart's diagonal
SHARED_FN uint chartX(TexelChart chart) { return chart.size & 255u; }
SHARED_FN uint chartY(TexelChart chart) { return (chart.size >> 8u) & 255u; }
// The level of the record: one past the chart's coarsest.
SHARED_FN uint recordLevel(TexelChart chart) {
  return max(chartX(chart), chartY(chart)) + kTexelSmallLevels + 1u;
}
SHARED_FN uint tilesAlong(uint log2Tiles, uint level) {
  return level < log2Tiles ? 1u << (log2Tiles - level) : 1u;
}
SHARED_FN uint cellsAlong(uint log2Tiles, uint level) {
  return level <= log2Tiles ? kTexelCells << (log2Tiles - level) : max(kTexelTile >> (level - log2Tiles), 1u);
}
// Tiles of all levels before `level`: a quarter at each level while both sides halve, then a half, then one
// at each.
SHARED_FN uint tilesBefore(TexelChart chart, uint level) {
  uint shorter = min(chartX(chart), chartY(chart));
  uint longer = max(chartX(chart), chartY(chart));
  uint both = min(level, shorter);
  uint tiles = 0u;
  if (both > 0u) tiles = (((1u << (2u * both)) - 1u) / 3u) << (shorter + longer - 2u * (both - 1u));
  uint last = clamp(level, shorter, longer);
  tiles += (1u << (longer - shorter + 1u)) - (1u << (longer - last + 1u));
  return tiles + max(level, longer) - longer;
}

// A tile of a chart: its place at its level, and the chart's size.
SHARED_FN uint packTile(uint x, uint y, uint level, TexelChart chart) {
  return x | (y << 8u) | (level << 16u) | (chartX(chart) << 20u) | (chartY(chart) << 24u);
}
SHARED_FN uint tileX(uint tile) { return tile & 255u; }
SHARED_FN uint tileY(uint tile) { return (tile >> 8u) & 255u; }
SHARED_FN uint tileLevel(uint tile) { return (tile >> 16u) & 15u; }
SHARED_FN uint tileChartX(uint tile) { return (tile >> 20u) & 15u; }
SHARED_FN uint tileChartY(uint tile) { return tile >> 24u; }
// The number of a tile among those of all charts: what the table is asked for.
SHARED_FN uint tileNumber(TexelChart chart, uint tile) {
  uint level = tileLevel(tile);
  return chart.base + tilesBefore(chart, level) + tileY(tile) * tilesAlong(chartX(chart), level) +
         tileX(tile);
}
// The tile that holds what this one does, a level coarser. Only below the record's level.
SHARED_FN uint coarserTile(TexelChart chart, uint tile) {
  uint level = tileLevel(tile) + 1u;
  return packTile(min(tileX(tile) / 2u, tilesAlong(chartX(chart), level) - 1u),
                  min(tileY(tile) / 2u, tilesAlong(chartY(chart), level) - 1u), level, chart);
}
// The tile at a place of the chart, (0,0) to (1,1), see placeInChart.
SHARED_FN uint tileAt(TexelChart chart, uint level, vec2 at) {
  uint x = uint(at.x * float(cellsAlong(chartX(chart), level))) / kTexelCells;
  uint y = uint(at.y * float(cellsAlong(chartY(chart), level))) / kTexelCells;
  return packTile(min(x, tilesAlong(chartX(chart), level) - 1u),
                  min(y, tilesAlong(chartY(chart), level) - 1u), level, chart);
}

// The place in the patch that is meant by one: interpolation on a triangle that is seen edge-on leads out of
// it.
SHARED_FN vec2 placeInChart(TexelChart chart, vec2 at) {
  vec2 inside = vec2(clamp(at.x, kLevelZero, kLevelOne), clamp(at.y, kLevelZero, kLevelOne));
  if ((chart.size & kChartSingle) != 0u && inside.y > inside.x) {
    inside.x = kLevelHalf * (inside.x + inside.y);
    inside.y = inside.x;
  }
  return inside;
}

// The level whose cells are as large as a pixel along the direction in which they are largest, to the nearest
// level. dx, dy: how the place in the chart, (0,0) to (1,1), changes from a pixel to the next; bias: log2 of
// area, 1 halves the texels. Any float, NaN and infinity included, gives a level of the chart or its record.
SHARED_FN uint texelLevel(TexelChart chart, vec2 dx, vec2 dy, float bias) {
  vec2 cells = vec2(float(cellsAlong(chartX(chart), 0u)), float(cellsAlong(chartY(chart), 0u)));
  vec2 alongX = dx * cells;
  vec2 alongY = dy * cells;
  float longest = max(dot(alongX, alongX), dot(alongY, alongY));
  if (!isFiniteNumber(longest)) return recordLevel(chart);
  float level = kLevelHalf * (log2(max(longest, kSmallestArea)) + clamp(bias, -kLargestBias, kLargestBias)) +
                kLevelHalf;
  return uint(clamp(floor(level), kLevelZero, float(recordLevel(chart))));
}

// Places of a patch's corners in its chart, see PatchGeometry.
SHARED_FN vec2 chartCorner(uint triangles, uint corner) {
  bool triple = triangles == 3u;
  float x = corner == 1u || corner == 2u ? kLevelOne : (corner == 0u && triple ? kLevelHalf : kLevelZero);
  return vec2(x, corner == 2u || corner == 3u ? kLevelOne : kLevelZero);
}
// Which of the patch's triangles is at a place of the chart; a single is taken to go on beyond its edge.
SHARED_FN uint chartPart(uint triangles, vec2 at) {
  if (triangles == 1u) return 0u;
  if (triangles == 2u) return at.y <= at.x ? 0u : 1u;
  if (at.x >= kLevelHalf + kLevelHalf * at.y) return 0u;
  return at.x <= kLevelHalf - kLevelHalf * at.y ? 2u : 1u;
}
// Barycentric coordinates of a place by those of the corners. Outside they go on linearly.
SHARED_FN vec3 chartBarycentrics(vec2 a, vec2 b, vec2 c, vec2 at) {
  vec2 p = b - a;
  vec2 q = c - a;
  vec2 r = at - a;
  float area = p.x * q.y - p.y * q.x;
  float second = (r.x * q.y - r.y * q.x) / area;
  float third = (p.x * r.y - p.y * r.x) / area;
  return vec3(kLevelOne - second - third, second, third);
}
// Whether a fetch inside the patch ever reads texel (x, y) of a level: of a single only one half is.
SHARED_FN bool texelNeeded(uint triangles, uint x, uint y, uint cellsX, uint cellsY) {
  if (x > cellsX || y > cellsY) return false;
  return triangles != 1u || y == 0u || (y - 1u) * cellsX <= (x + 1u) * cellsY;
}

// A tile that has a slot.
struct TexelTile {
  uint patchId;  // patch instance
  uint tile;     // see packTile
  uint slot;
};

// Of a batch, in a frame.
struct TexelBatch {
  uint tileGroupsX;  // indirect arguments: a group a tile
  uint tileGroupsY;
  uint tileGroupsZ;
  uint recordGroupsX;  // indirect arguments: groups over its draw entries
  uint recordGroupsY;
  uint recordGroupsZ;
  uint tiles;
  uint firstTile;  // in the queue
  uint queued;
  uint firstEntry;  // of its draw entries
  uint entries;
};

// The bias that follows from want of slots.
struct TexelPressure {
  float bias;    // log2 of area
  uint quiet;    // frames since slots were last wanting
  uint wait;     // quiet frames after which the bias falls
  uint falling;  // 1: it fell since
};

struct TexelConfig {
  uint slots;
  uint columns;    // slots in a row
  uint recordRow;  // first row of records
  uint wanted;     // room for tiles before they are made to fit
  uint table;      // places of a table, a power of two
  uint batches;
  uint biased;         // 1: the bias follows from memory pressure
  float constantBias;  // log2 of area
  float lowestBias;
};

struct TexelState {
  TexelConfig config;
  uint current;  // which half of tables and tiles this frame writes
  uint shown;    // which half the last frame that was placed wrote
  TexelPressure pressure;
  uint coarser;     // levels by which this frame's tiles were made coarser
  float shownBias;  // of the last frame that was placed, all of it
  uint shownCoarser;
  uint marked;   // tiles that pixels asked for, before they were made to fit
  uint lost;     // of them those that could not be written down
  uint source;   // which half of the wanted tiles counts
  uint fitting;  // 1: they were too many
  uint wanted0;  // tiles in each half
  uint wanted1;
  uint tiles0;  // tiles with slots in each half
  uint tiles1;
  int freeSlots;
  uint frames;
  uint visible;       // patches
  uint samples;       // texels to shade in this frame's tiles
  uint kept;          // tiles that had their slot in the last frame
  uint clearGroupsX;  // indirect arguments
  uint clearGroupsY;
  uint clearGroupsZ;
  uint wantedGroupsX;
  uint wantedGroupsY;
  uint wantedGroupsZ;
  uint oldGroupsX;
  uint oldGroupsY;
  uint oldGroupsZ;
  uint tileGroupsX;
  uint tileGroupsY;
  uint tileGroupsZ;
};

SHARED_FN uint texelGroups(uint threads) { return (threads + uint(TEXEL_GROUP) - 1u) / uint(TEXEL_GROUP); }

// Frames without want of slots after which the pressure bias falls. Each time that it then asks for too much
// again, twice as many, up to the most: where tiles do not get fewer by and by, a still picture shall rest.
SHARED_CONST uint kTexelQuiet = 40u;
SHARED_CONST uint kTexelLongestQuiet = 1280u;
SHARED_CONST float kTexelRelief = 0.05;  // log2 of area in a frame

// What follows in a frame from the last one's load: `marked` tiles for `slots`. The bias rises to where some
// 95 % of the slots are asked for, if tiles fall to half with each step of it, as those of large patches do.
SHARED_FN TexelPressure nextTexelPressure(TexelPressure pressure, uint marked, uint slots, float lowest) {
  float load = float(max(marked, 1u)) / float(slots);
  if (marked > slots) {
    if (pressure.falling != 0u) pressure.wait = min(pressure.wait + pressure.wait, kTexelLongestQuiet);
    pressure.bias = min(pressure.bias + max(log2(load / float(0.95)), float(0.1)), kLargestBias);
    pressure.quiet = 0u;
    pressure.falling = 0u;
    return pressure;
  }
  pressure.quiet = min(pressure.quiet + 1u, kTexelLongestQuiet);
  if (load < float(0.9) && pressure.bias > lowest && pressure.quiet >= pressure.wait) {
    pressure.bias = max(pressure.bias - kTexelRelief, lowest);
    pressure.falling = 1u;
  }
  return pressure;
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::TexelChart) == 8);
static_assert(sizeof(tessera::glsl::TexelTile) == 12);
static_assert(sizeof(tessera::glsl::TexelBatch) == 44);
static_assert(sizeof(tessera::glsl::TexelConfig) == 36);
static_assert(sizeof(tessera::glsl::TexelState) == 36 + 34 * 4);
#endif
#endif
