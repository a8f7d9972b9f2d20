// The buffers of the memory phases, and how blocks and superblocks are given back.
#include "shared/bindings.h"
#include "shared/levels.h"
#include "shared/rect_memory.h"

// Coherent: threads of one pass read what others of it wrote, after a barrier (see rect_provision.comp, rect_merge.comp).
layout(std430, binding = BIND_ATLAS_STATE) coherent buffer AtlasStates { AtlasState atlas; };
layout(std430, binding = BIND_ATLAS_STACKS) coherent buffer AtlasStacks { uint stackEntries[]; };
layout(std430, binding = BIND_ATLAS_SUPERBLOCKS) buffer Superblocks { uint superblockWords[]; };
layout(std430, binding = BIND_PATCH_STATE) buffer PatchStates { PatchState patchStates[]; };
layout(std430, binding = BIND_ATLAS_LIVE) buffer Live { uint liveCount; uint liveIds[]; };
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };

void pushSuperblock(uint superblock) {
  superblockWords[atomicAdd(atlas.superblocksFree, 1u)] = superblock;
  atomicAdd(atlas.cutTexels, -(1u << (2u * atlas.config.superblockLog2)));
}

void pushBlock(uint l, uint origin) {
  uint place = uint(atomicAdd(atlas.levels[l].stackCount, 1));
  stackEntries[atlas.levels[l].stackBase + place] = origin;
}

// Texels of live blocks in a superblock; kept where there are no block stacks.
uint liveWord(uint superblock) { return atlas.config.superblocks + superblock; }

// Without stacks a block is lost until its superblock has no live one; the one that is being filled is not given back.
void loseBlock(uint level, uint origin) {
  uint w = levelWidth(level);
  uint h = levelHeight(level);
  uint l = levelIndex(w, h);
  uint texels = 1u << (w + h);
  uint superblock = superblockAt(atlas.config, origin);
  atomicAdd(atlas.levels[l].lost, 1u);
  uint left = atomicAdd(superblockWords[liveWord(superblock)], -texels) - texels;
  if (left != 0u || atlas.bins[binOf(atlas.config, w, h)].carrySuperblock == superblock) return;
  uint blocks = blocksPerSuperblock(atlas.config.superblockLog2, w, h);
  atomicAdd(atlas.levels[l].lost, -blocks);
  atomicAdd(atlas.levels[l].existing, -blocks);
  pushSuperblock(superblock);
}

void giveBack(uint level, uint origin) {
  if (atlas.config.stacks != 0u) pushBlock(levelIndexOf(level), origin);
  else loseBlock(level, origin);
}
