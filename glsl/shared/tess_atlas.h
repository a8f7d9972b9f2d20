// GPU state of the tessellation gatherer's atlas (Hladky 2019): triangles in slots of shared cells, cells of one size in
// rectangles that are cut from what is free. A cell holds two triangles of one bin, the second turned by half a turn. A bin is a size of cell: a level of
// L-packing, or a class of right-angled halves of Oversampling. Triangles of about a pixel own a texel each in the record
// rows below, and use no memory else.
#ifndef TESSERA_GLSL_SHARED_TESS_ATLAS_H
#define TESSERA_GLSL_SHARED_TESS_ATLAS_H
#include "shared/dialect.h"
#include "shared/lpack.h"
#include "shared/pressure.h"
TESSERA_SHARED_BEGIN

// Work-group size of the passes over the visible list, see visible_finish.comp.
#define TESS_GROUP 64
#define TESS_VIEWS 8

// Number of a triangle of the visible set: the patch instance's times 4, plus which of its triangles.
SHARED_FN uint triangleNumber(uint patchInstance, uint part) { return 4u * patchInstance + part; }

SHARED_CONST uint kTessNone = 0u;
SHARED_CONST uint kTessSingle = 1u;  // one texel
SHARED_CONST uint kTessL = 2u;       // L-packing
SHARED_CONST uint kTessKind = 3u;    // mask

// What a triangle's size is chosen from: lengths in pixels on a curved image plane, before any bias. 16 bytes, one a
// visible triangle.
struct TessMeasure {
  float longest;  // the longest edge; 0 where the triangle has no place in the picture
  float height;   // over that edge
  float foot;     // where the height meets that edge, 0 at its start to 1 at its end
  uint edge;      // which one: 0 from vertex 0 to 1, 1 from 1 to 2, 2 from 2 to 0
};

// Where a triangle lives. Kept from frame to frame.
struct TessState {
  uint shape;  // kTess..., then what sizeOf... says
  uint place;  // see packPlace; inside a frame the number of the request while pending is set
  uint pending;
  uint epoch;  // that of the atlas when this was written: an older one holds nothing
};

SHARED_FN uint kindOf(uint shape) { return shape & kTessKind; }
SHARED_FN uint shapeOfL(uint level) { return kTessL | (level << 2u); }
SHARED_FN uint levelOfShape(uint shape) { return (shape >> 2u) & 1023u; }

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
  uint live;      // slots that hold a triangle
  uint overflowBin;   // where the others went: a bin of smaller cells
  uint overflowBase;  // and the number of the first one there
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
// More than these are not remembered: the smallest are lost until memory is reset.
SHARED_CONST uint kFreeRects = 256u;

struct TessConfig {
  uint width;          // texels
  uint height;         // texels, without the record rows
  uint triangles;      // triangle numbers
  uint bins;
  uint runs;           // room for runs
  uint views;          // of the measuring pass
  uint biased;         // 1: the bias follows from memory pressure
  float constantBias;  // log2 of area
  float lowestBias;
  float hysteresis;    // log2 of length; negative for none
  float slanted;       // longest edge to height beyond which a triangle is slanted
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
  uint reduced;   // requests that got a smaller slot than asked for
  uint moved;
  uint movedTexels;
  uint freed;
  uint lost;  // slots freed while their stack was full
  uint lostTexels;
  uint singles;   // visible triangles of one texel, failures included
  uint slanted;   // visible triangles past the threshold
  uint samples;   // texels to shade
  uint lTexels;   // of them in Ls
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
  float bias;  // by pressure, of this frame
  PressureState pressure;
  TessEvents events;
  FreeRect rects[kFreeRects];
  TessIdeal ideal[kTessIdeals];
};

// What shading and display read of a visible triangle.
struct TessEntry {
  uint shape;
  uint place;
  uint vertex0;  // indices into the scene's vertices, counter-clockwise in the world
  uint vertex1;
  uint vertex2;
  uint instance;
  uint unused0;
  uint unused1;
};

// A corner of one: all that display needs of it. `w` is its weight for perspective, see perspective_map.h.
struct TessVertex {
  float x;  // world, relative to the anchor
  float y;
  float z;
  float w;
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
static_assert(sizeof(tessera::glsl::TessState) == 16);
static_assert(sizeof(tessera::glsl::TessBin) == 56);
static_assert(sizeof(tessera::glsl::TessEntry) == 32);
static_assert(sizeof(tessera::glsl::TessVertex) == 16);
#endif
#endif
