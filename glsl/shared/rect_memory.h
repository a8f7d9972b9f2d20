// GPU state of the rectangular atlas. Based on Mueller 2021, sec. 3.3 to 3.6: the atlas is cut into superblocks, a
// superblock into columns of one width, a column into blocks of that width. A level l = (w, h) is the block size
// 2^w x 2^h, w >= h, w >= 1. What is one texel (w = 0) never uses the allocator: every patch instance owns a texel
// in the record rows below the superblocks.
// A bin is what fills superblocks one after the other: a block width, or a level where the strategy has no columns.
#ifndef TESSERA_GLSL_SHARED_RECT_MEMORY_H
#define TESSERA_GLSL_SHARED_RECT_MEMORY_H
#include "shared/bindings.h"
#include "shared/dialect.h"
#include "shared/levels.h"
#include "shared/pressure.h"
TESSERA_SHARED_BEGIN

// Work-group size of the passes over the visible list: their indirect arguments are (ceil(count / this), 1,
// 1).
#define RECT_GROUP 64
// How many views BIND_VIEWS has room for.
#define RECT_VIEWS ID_VIEWS
SHARED_CONST uint kLevels = (kMaxBlockLog2 + 1u) * (kMaxBlockLog2 + 2u) / 2u;
SHARED_CONST uint kNoSuperblock = 0xffffffffu;

// Where a patch instance lives. It holds a block when epoch is the atlas's and the level is not one texel.
struct PatchState {
  uint origin;  // x | y << 16, texels; inside a frame the slot number while kLevelPending is set
  uint level;   // see packLevel
  uint epoch;   // that of the atlas when this was written; an older one means that nothing is held, and 0 that it
                // went out of sight
};

// What the CPU sets; the GPU only reads it.
struct AtlasConfig {
  uint width;           // texels, a multiple of the superblock
  uint height;          // texels, a multiple of the superblock, without the record rows
  uint superblockLog2;  // 1 to kMaxBlockLog2
  uint superblocks;     // how many there are
  uint patchInstances;
  uint views;          // of the measuring pass, 1 to RECT_VIEWS
  uint biased;         // 1: the bias follows from memory pressure
  uint columns;        // 1: a bin is a width; 0: a level
  uint stacks;         // 1: freed blocks go on stacks; 0: they are lost until their superblock is empty
  uint merges;         // 1: free siblings are merged, and free blocks are cut for requests; needs columns and stacks
  uint mergeLoad;      // texels cut beyond which siblings are merged
  float constantBias;  // log2 of area, subtracted before rounding; positive makes blocks smaller
  float lowestBias;    // of pressureBias
  float hysteresis;    // log2; negative for none
  LevelRange range;
  PressureConfig pressure;
};

// Blocks of one size.
struct LevelState {
  int stackCount;  // free blocks on the stack; below 0 only while threads take back a failed pop
  uint requested;
  uint slotOffset;  // of the provisioned blocks, from the start of the carried-over superblock
  uint slotCount;
  uint existing;       // blocks of this size that were cut and not merged or returned: live, on the stack or lost
  uint lost;           // blocks that were freed without a stack to go on
  uint stackBase;      // first entry in the stack buffer
  uint stackCapacity;  // entries
  uint lastRequested;  // `requested` of the frame just provisioned
};

struct BinState {
  uint carryOffset;      // largest blocks of the bin used in the carried-over superblock
  uint carrySuperblock;  // kNoSuperblock before the first one
  uint firstPopped;      // place on the superblock stack of the first one popped this frame; the next lie below it
  uint popped;
  uint sourceSuperblock;  // the superblock carried into this frame: the first one that slots refer to
};

// A part of I - d and d, see pressureBias. Groups add to different parts, a cache line each, so that they do
// not wait for each other.
struct IdealSum {
  uint low;  // texels that the patches above the smallest block would ideally take, 64 bits in two
  uint high;
  uint ones;  // patches at the smallest block
  uint newLow;  // of low and high, texels of patches that were not visible in the last frame
  uint newHigh;
  uint unused[11];
};
SHARED_CONST uint kIdealSums = 8u;

// What happened to blocks in a frame.
struct AtlasEvents {
  uint failures;     // requests that found no memory
  uint moved;        // patches that had a block and got or asked for another
  uint movedTexels;  // of the blocks that those asked for
  uint freed;        // blocks given back without another one being asked for
  uint merged;       // blocks that merging made
  uint reduced;      // requests that got a smaller block than asked for
  uint waiting;      // patches that keep such a block of an earlier frame, and made no request
};

struct AtlasState {
  AtlasConfig config;
  // Indirect arguments of the request pass, which runs over the visible and the live list, and of the merge pass.
  uint requestGroupsX;
  uint requestGroupsY;
  uint requestGroupsZ;
  uint mergeGroupsX;
  uint mergeGroupsY;
  uint mergeGroupsZ;
  uint mergeHeight;      // log2 of the height of the blocks that the next merge pass looks at
  uint epoch;            // counts resets; starts at 1
  uint superblocksFree;  // entries on the superblock stack
  float pressureBias;    // of this frame, see pressureBias
  uint cutTexels;        // texels of all blocks that exist
  uint visible;          // patches of this frame
  uint resets;           // since creation
  uint frames;           // since creation
  PressureState pressure;
  AtlasEvents events;  // of this frame
  LevelState levels[kLevels];
  BinState bins[kLevels];
  IdealSum ideal[kIdealSums];
};

SHARED_FN uint levelIndex(uint w, uint h) { return w * (w + 1u) / 2u + h; }
SHARED_FN uint levelIndexOf(uint level) { return levelIndex(levelWidth(level), levelHeight(level)); }

// BpSB(l): how many blocks of a level fill one superblock.
SHARED_FN uint blocksPerSuperblock(uint superblockLog2, uint w, uint h) {
  return 1u << (2u * superblockLog2 - w - h);
}

// The bin that blocks of a level are cut from.
SHARED_FN uint binOf(AtlasConfig config, uint w, uint h) { return config.columns != 0u ? w : levelIndex(w, h); }

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

SHARED_FN uint superblockAt(AtlasConfig config, uint origin) {
  uvec2 at = unpackOrigin(origin);
  return (at.y >> config.superblockLog2) * (config.width >> config.superblockLog2) + (at.x >> config.superblockLog2);
}

// Merging. Free blocks form a tree: a square of 2^w is cut into four squares of 2^(w - 1), or into two halves of
// 2^w x 2^(w - 1), and a half again into two by its height. The siblings of a block are those that it was cut with.
// Level index of the block that siblings of level (w, h) make together.
SHARED_FN uint parentIndex(uint w, uint h) { return w == h ? levelIndex(w + 1u, h + 1u) : levelIndex(w, h + 1u); }
SHARED_FN uint siblingCount(uint w, uint h) { return w == h ? 4u : 2u; }
// The origin of sibling i, 0 to siblingCount - 1, in the parent at `origin`.
SHARED_FN uint siblingOrigin(uint origin, uint i, uint w, uint h) {
  uvec2 at = unpackOrigin(origin);
  if (w == h) return packOrigin(at.x + ((i & 1u) << w), at.y + ((i >> 1u) << h));
  return packOrigin(at.x, at.y + (i << h));
}
// The origin of the parent of the block at `origin`.
SHARED_FN uint parentOrigin(uint origin, uint w, uint h) {
  uvec2 at = unpackOrigin(origin);
  if (w == h) return packOrigin(at.x & ~(1u << w), at.y & ~(1u << h));
  return packOrigin(at.x, at.y & ~(1u << h));
}
// The bit of a block in the merge map: the smallest blocks are two texels wide.
SHARED_FN uint mergeCell(AtlasConfig config, uint origin) {
  uvec2 at = unpackOrigin(origin);
  return (at.y * config.width + at.x) >> 1u;
}

// The texel that a patch instance owns for when it has no block.
SHARED_FN uint recordOrigin(AtlasConfig config, uint patchInstance) {
  return packOrigin(patchInstance % config.width, config.height + patchInstance / config.width);
}

// Entries that the stack of a level may ever need. Blocks of a level are disjoint, so the area bounds them.
// They are also bounded by patches: blocks are cut only for requests that the stack cannot serve, so all
// blocks of a level were live at once, but for one odd remainder a frame. kRemainders of those are room for;
// see rect_provision.comp. Splitting and merging stop where the room ends.
SHARED_CONST uint kRemainders = 1024u;
SHARED_FN uint stackCapacityOf(AtlasConfig config, uint w, uint h) {
  uint byArea = config.superblocks * blocksPerSuperblock(config.superblockLog2, w, h);
  return (config.stacks != 0u ? min(byArea, config.patchInstances + kRemainders) : byArea) + 1u;
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::PatchState) == 12);
static_assert(sizeof(tessera::glsl::AtlasConfig) == 108);
static_assert(sizeof(tessera::glsl::LevelState) == 36);
static_assert(sizeof(tessera::glsl::BinState) == 20);
static_assert(sizeof(tessera::glsl::AtlasEvents) == 28);
static_assert(sizeof(tessera::glsl::AtlasState) == 108 + 14 * 4 + 28 + 28 + 66 * 36 + 66 * 20 + 8 * 64);
#endif
#endif
