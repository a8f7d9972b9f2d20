// GPU state of the tessellation gatherer's atlas (Hladky 2019): triangles in slots of shared cells, cells of one size in
// rectangles that are cut from what is free. A cell holds two triangles of one bin, the second turned by half a turn. A bin is a size of cell: a level of
// L-packing, or a class of right-angled halves of Oversampling. Triangles of about a pixel own a texel each in the record
// rows below, and use no memory else.
#ifndef TESSERA_GLSL_SHARED_TESS_ATLAS_H
#define TESSERA_GLSL_SHARED_TESS_ATLAS_H
#include "shared/bindings.h"
#include "shared/dialect.h"
#include "shared/lpack.h"
#include "shared/oversample.h"
#include "shared/pressure.h"
#include "shared/tess_split.h"
TESSERA_SHARED_BEGIN

// Work-group size of the passes over the visible list, see visible_finish.comp.
#define TESS_GROUP 64
#define TESS_VIEWS ID_VIEWS

// Number of a triangle of the visible set: the patch instance's times 4, plus which of its triangles.
SHARED_FN uint triangleNumber(uint patchInstance, uint part) { return 4u * patchInstance + part; }

SHARED_CONST uint kTessNone = 0u;
SHARED_CONST uint kTessSingle = 1u;  // one texel
SHARED_CONST uint kTessL = 2u;       // L-packing; the level in the bits above
SHARED_CONST uint kTessOver = 3u;    // Oversampling
SHARED_CONST uint kTessKind = 3u;    // mask

// What a triangle's size is chosen from: lengths in pixels on a curved image plane, before any bias. 16 bytes, one a
// visible triangle.
struct TessMeasure {
  float edge0;  // opposite of corner 0
  float edge1;
  float edge2;
  float height;  // over the longest
};

// How a triangle is sampled.
struct TessShape {
  uint kind;  // kTess...
  uint size;  // Oversampling: columns of its halves, and the apex, see packOver
  uint form;  // Oversampling: foot and rows
};

// Where a triangle lives. Kept from frame to frame.
struct TessState {
  TessShape shape;
  uint place0;   // see packPlace; of the L, or of half 0
  uint place1;   // of half 1
  uint pending;  // bit 0, 1: the place is the number of a request
  uint epoch;    // that of the atlas when this was written: an older one holds nothing
  uint split;    // see packSplit; 0 when it is not
};

SHARED_FN uint kindOf(uint kind) { return kind & kTessKind; }
SHARED_FN uint kindOfL(uint level) { return kTessL | (level << 2u); }
SHARED_FN uint levelOfKind(uint kind) { return kind >> 2u; }
SHARED_CONST uint kLargestLevel = 254u;

SHARED_FN TessShape shapeOfOver(OverShape over) {
  TessShape shape;
  shape.kind = kTessOver;
  shape.size = over.columns0 | (over.columns1 << 12u) | (over.apex << 26u);
  shape.form = over.foot | (over.rows << 16u);
  return shape;
}
SHARED_FN OverShape overOfShape(TessShape shape) {
  OverShape over;
  over.columns0 = shape.size & 4095u;
  over.columns1 = (shape.size >> 12u) & 4095u;
  over.apex = min((shape.size >> 26u) & 3u, 2u);
  over.foot = shape.form & 0xffffu;
  over.rows = shape.form >> 16u;
  return over;
}

// Texels that a shape's samples take in the atlas.
SHARED_FN uint texelsOfShape(TessShape shape) {
  uint kind = kindOf(shape.kind);
  if (kind == kTessL) return lTexels(levelOfKind(shape.kind));
  return kind == kTessOver ? overCount(overOfShape(shape)) : 1u;
}

// A slot: the first texel of its cell, and whether it is the turned one.
SHARED_FN uint packPlace(uint x, uint y, uint turned) { return x | (turned << 15u) | (y << 16u); }
SHARED_FN uint placeX(uint place) { return place & 0x7fffu; }
SHARED_FN uint placeY(uint place) { return place >> 16u; }
SHARED_FN uint placeTurned(uint place) { return (place >> 15u) & 1u; }
SHARED_CONST uint kNoPlace = 0xffffffffu;

struct TessBin {
  uint cellWidth;   // texels
  uint cellHeight;
  uint stackBase;  // first entry in the stack buffer
  uint stackCapacity;
  int stackCount;  // free slots on the stack; above stackCapacity while threads push what does not fit
  uint spare;       // a free turned slot of a cell whose first slot is taken, or kNoPlace
  uint requested;
  uint runFirst;  // of this frame's new cells
  uint runCount;
  uint given;     // requests served by `spare` and the stack this frame
  uint provided;  // requests served in all this frame
};

// New cells of a bin, row by row.
struct TessRun {
  uint firstCell;  // of the bin's new cells
  uint place;      // of the first one
  uint columns;
};

// A rectangle that holds no cell.
struct FreeRect {
  uint x;
  uint y;
  uint width;
  uint height;
};
// Bins: a level of L-packing each, then a size of Oversampling's blocks each.
SHARED_CONST uint kTessBins = kLargestLevel + kOverBins;
SHARED_FN uint binOfLevel(uint level) { return level - 1u; }
SHARED_FN uint binOfBlock(uint columns, uint rows) { return kLargestLevel + overBin(columns, rows); }
// Size of the cells of a bin.
SHARED_FN uvec2 cellOfBin(uint bin) {
  if (bin < kLargestLevel) return lPairSize(bin + 1u);
  uvec2 block = overBinBlock(bin - kLargestLevel);
  return overPairSize(block.x, block.y);
}
// How often a frame tries to find memory: as it is, after a reset, and with coarser levels.
SHARED_CONST uint kTessRounds = 4u;

// More than these are not remembered: the smallest are lost until memory is reset.
SHARED_CONST uint kFreeRects = 256u;

// What sizes a triangle's samples may have: what is larger is sampled more coarsely. A cell must fit into the atlas.
struct TessLimits {
  float slanted;  // longest edge to height beyond which a triangle is slanted
  float level;    // of an L; whole, at most kLargestLevel
  float columns;  // texels along the base of a block, at most kOverWidest
};
SHARED_CONST float kOverWidest = 1023.0;
SHARED_CONST float kOverHighest = 127.0;  // texels of the height of a block
// Of a split triangle, besides its pieces': what shows where a view sees a piece that no gathering view saw.
SHARED_CONST float kSplitCoarse = 64.0;
SHARED_FN TessLimits limitsOfSplit(TessLimits limits, uint split) {
  if (split == 0u) return limits;
  limits.level = min(limits.level, kSplitCoarse);
  limits.columns = min(limits.columns, kSplitCoarse);
  return limits;
}

struct TessConfig {
  uint width;          // texels
  uint height;         // texels, without the record rows
  uint triangles;      // triangle numbers; those of pieces follow
  uint runs;           // room for runs
  uint views;          // of the measuring pass
  uint biased;         // 1: the bias follows from memory pressure
  float constantBias;  // log2 of area
  float lowestBias;
  float hysteresis;    // log2 of length; negative for none
  TessLimits limits;
  PressureConfig pressure;
};

// A part of what the visible set would ideally take, see IdealSum in rect_memory.h.
struct TessIdeal {
  uint low;
  uint high;
  uint singles;
  uint unused[13];
};
SHARED_CONST uint kTessIdeals = 8u;

struct TessEvents {
  uint failures;  // triangles that found no memory, and are one texel
  uint moved;
  uint movedTexels;
  uint freed;
  uint lost;  // slots freed while their stack was full
  uint lostTexels;
  uint singles;   // visible triangles of one texel, failures included
  uint slanted;   // visible triangles past the threshold
  uint samples;   // texels to shade
  uint lSamples;  // of them in Ls
  uint inside;    // of them Oversampling's, in their triangle
  uint outside;   // and outside of it
};

struct TessAtlasState {
  TessConfig config;
  uint requestGroupsX;  // indirect arguments of the request pass
  uint requestGroupsY;
  uint requestGroupsZ;
  uint epoch;  // counts resets; starts at 1
  uint rectCount;   // free rectangles
  uint cellTexels;  // of all cells
  uint runCount;
  uint liveTexels;  // of slots that hold a triangle
  uint resets;
  uint frames;
  uint round;   // of this frame's tries to find memory
  uint failed;  // requests of this round that found none
  uint wantedTexels;  // of the cells that this round's new requests need
  float bias;  // by pressure, of this frame
  PressureState pressure;
  TessEvents events;
  FreeRect rects[kFreeRects];
  TessIdeal ideal[kTessIdeals];
};

// What shading and display read of a visible triangle.
struct TessEntry {
  TessShape shape;
  uint place0;
  uint place1;
  uint vertex0;  // indices into the scene's vertices, counter-clockwise in the world
  uint vertex1;
  uint vertex2;
  uint instance;
  uint piece;       // of a triangle, see packPiece; 0 for a whole one
  uint split;       // pieces along an edge; 0 for a triangle that is not split
  uint firstPiece;  // number of its first piece
};

// A corner of one. `w` is its weight for perspective, see perspective_map.h.
struct TessVertex {
  float x;  // world, relative to the anchor
  float y;
  float z;
  float w;
};

// What display draws: a list for each way to find a point's place, since a branch that only some pixels take costs all of
// them where invocations run in step.
SHARED_CONST uint kDisplayAffine = 0u;  // Oversampling, and one texel
SHARED_CONST uint kDisplayL = 1u;
SHARED_CONST uint kDisplaySplit = 2u;
SHARED_CONST uint kDisplayLists = 3u;

// A corner in such a list. a, b and c, times w, are interpolated with perspective and divided by w's sum.
struct TessCorner {
  float x;  // world, relative to the anchor
  float y;
  float z;
  float w;  // weight for perspective
  float a;  // affine: x in half 0 and in half 1, y in either (see overCornerAt); else which corner this is, in even
  float b;  // coordinates; all times w
  float c;
  uint place0;  // affine: texel (0, 0) of half 0, see packPlace; L: its place; split: entry
  uint place1;  // affine: that of half 1; L: level
  uint vertex;  // index into the scene's vertices
};

// Indirect arguments of gathering by compute, and how many samples they are for.
struct TessGroups {
  uint x;
  uint y;
  uint z;
  uint samples;
  uint first;  // number of the first among all batches' samples, see tess_bases.comp
};

struct TessCommand {
  uint count;
  uint instanceCount;
  uint first;
  uint baseInstance;
};

SHARED_FN uint tessRecord(TessConfig config, uint triangle) {
  return packPlace(triangle % config.width, config.height + triangle / config.width, 0u);
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::TessMeasure) == 16);
static_assert(sizeof(tessera::glsl::TessState) == 32);
static_assert(sizeof(tessera::glsl::TessBin) == 44);
static_assert(sizeof(tessera::glsl::TessEntry) == 48);
static_assert(sizeof(tessera::glsl::TessVertex) == 16);
static_assert(sizeof(tessera::glsl::TessCorner) == 40);
#endif
#endif
