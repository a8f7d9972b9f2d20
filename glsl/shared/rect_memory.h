// GPU state of the rectangular atlas. Based on Mueller 2021, sec. 3.3 and 3.4: the atlas is cut into
// superblocks, a superblock into columns of one width, a column into blocks of that width. A level l = (w, h)
// is the block size 2^w x 2^h, w >= h, w >= 1. What is one texel (w = 0) never uses the allocator: every
// patch instance owns a texel in the record rows below the superblocks.
#ifndef TESSERA_GLSL_SHARED_RECT_MEMORY_H
#define TESSERA_GLSL_SHARED_RECT_MEMORY_H
#include "shared/dialect.h"
#include "shared/levels.h"
TESSERA_SHARED_BEGIN

// Work-group size of the passes over the visible list: their indirect arguments are (ceil(count / this), 1,
// 1).
#define RECT_GROUP 64
// How many views BIND_VIEWS has room for.
#define RECT_VIEWS 8
SHARED_CONST uint kWidths = kMaxBlockLog2 + 1u;  // indexed by w; 0 is unused
SHARED_CONST uint kLevels = (kMaxBlockLog2 + 1u) * (kMaxBlockLog2 + 2u) / 2u;
SHARED_CONST uint kNoSuperblock = 0xffffffffu;

// Where a patch instance lives. It holds a block when epoch is the atlas's and the level is not one texel.
struct PatchState {
  uint origin;  // x | y << 16, texels; inside a frame the slot number while kLevelPending is set
  uint level;   // see packLevel
  uint epoch;   // that of the atlas when this was written; an older one means that nothing is held
};

// What the CPU sets; the GPU only reads it.
struct AtlasConfig {
  uint width;           // texels, a multiple of the superblock
  uint height;          // texels, a multiple of the superblock, without the record rows
  uint superblockLog2;  // 1 to kMaxBlockLog2
  uint superblocks;     // how many there are
  uint patchInstances;
  uint views;            // of the measuring pass, 1 to RECT_VIEWS
  uint pressure;         // 1: the bias follows from memory pressure
  float constantBias;    // log2 of area, subtracted before rounding; positive makes blocks smaller
  float hysteresis;      // log2; negative for none
  float highWater;       // share of the atlas cut into blocks beyond which memory is reset
  float targetLargest;   // S starts here and never grows past it, texels
  float targetSmallest;  // S is never cut below this, texels
  float targetCut;       // factor on S at a reset
  float targetGrowth;    // factor on S in a frame without pressure
};

// Blocks of one size.
struct LevelState {
  int stackCount;  // free blocks on the stack; below 0 only while threads take back a failed pop
  uint requested;
  uint slotOffset;  // of the provisioned blocks, from the start of the carried-over superblock
  uint slotCount;
  uint existing;       // blocks of this size cut since the last reset, live or on the stack
  uint stackBase;      // first entry in the stack buffer
  uint stackCapacity;  // entries
  uint lastRequested;  // `requested` of the frame just provisioned
};

// Columns of one width.
struct WidthState {
  uint carryOffset;      // square blocks used in the carried-over superblock
  uint carrySuperblock;  // kNoSuperblock before the first one
  uint firstPopped;      // superblocks popped this frame are firstPopped, firstPopped + 1, ...
  uint popped;
  uint sourceSuperblock;  // the superblock carried into this frame: the first one that slots refer to
};

// A part of I - d and d, see pressureBias. Groups add to different parts, a cache line each, so that they do
// not wait for each other.
struct IdealSum {
  uint low;  // texels that the patches above one texel would ideally take, 64 bits in two
  uint high;
  uint ones;  // patches of one texel
  uint unused[13];
};
SHARED_CONST uint kIdealSums = 8u;

struct AtlasState {
  AtlasConfig config;
  // Indirect arguments of the request pass, which runs over the visible and the live list.
  uint requestGroupsX;
  uint requestGroupsY;
  uint requestGroupsZ;
  uint epoch;            // counts resets; starts at 1
  uint superblocksUsed;  // the superblock stack: it only pops between resets, so its entries are in order
  float pressureBias;    // of this frame, see pressureBias
  float target;          // S, texels
  uint cutTexels;        // texels of all blocks cut since the last reset
  uint failures;         // requests of this frame that found no memory
  uint visible;          // patches of this frame
  uint resets;           // since creation
  uint frames;           // since creation
  uint sinceReset;       // frames since the last reset
  uint resetWait;        // frames that must lie between two resets that pressure asks for
  LevelState levels[kLevels];
  WidthState widths[kWidths];
  IdealSum ideal[kIdealSums];
};

SHARED_FN uint levelIndex(uint w, uint h) { return w * (w + 1u) / 2u + h; }
SHARED_FN uint levelIndexOf(uint level) { return levelIndex(levelWidth(level), levelHeight(level)); }

// BpSB(l): how many blocks of a level fill one superblock.
SHARED_FN uint blocksPerSuperblock(uint superblockLog2, uint w, uint h) {
  return 1u << (2u * superblockLog2 - w - h);
}

SHARED_FN uint packOrigin(uint x, uint y) { return x | (y << 16u); }
SHARED_FN uvec2 unpackOrigin(uint origin) { return uvec2(origin & 0xffffu, origin >> 16u); }

// The origin of block `index` of level (w, h) in a superblock: down a column, then the next column.
SHARED_FN uint blockOrigin(AtlasConfig config, uint superblock, uint index, uint w, uint h) {
  uint perColumn = config.superblockLog2 - h;
  uint column = index >> perColumn;
  uint row = index & ((1u << perColumn) - 1u);
  uint across = config.width >> config.superblockLog2;
  uint x = ((superblock % across) << config.superblockLog2) + (column << w);
  uint y = ((superblock / across) << config.superblockLog2) + (row << h);
  return packOrigin(x, y);
}

// The texel that a patch instance owns for when it has no block.
SHARED_FN uint recordOrigin(AtlasConfig config, uint patchInstance) {
  return packOrigin(patchInstance % config.width, config.height + patchInstance / config.width);
}

// Entries that the stack of a level may ever need. Blocks of a level are disjoint, so the area bounds them.
// They are also bounded by patches: blocks are cut only for requests that the stack cannot serve, so all
// blocks of a level were live at once, but for one odd remainder a frame. kRemainders of those are room for;
// see rect_provision.comp.
SHARED_CONST uint kRemainders = 1024u;
SHARED_FN uint stackCapacityOf(AtlasConfig config, uint w, uint h) {
  uint byArea = config.superblocks * blocksPerSuperblock(config.superblockLog2, w, h);
  return min(byArea, config.patchInstances + kRemainders) + 1u;
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::PatchState) == 12);
static_assert(sizeof(tessera::glsl::AtlasConfig) == 56);
static_assert(sizeof(tessera::glsl::LevelState) == 32);
static_assert(sizeof(tessera::glsl::WidthState) == 20);
static_assert(sizeof(tessera::glsl::AtlasState) == 56 + 14 * 4 + 66 * 32 + 11 * 20 + 8 * 64);
#endif
#endif
