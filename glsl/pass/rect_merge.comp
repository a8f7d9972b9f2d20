// Merges free siblings of one height into the block that they were cut from, and gives whole superblocks back. A group a
// width: what lies on the stack of its level is marked in a bit map, siblings that all are marked leave the stack, and
// the first of them pushes their parent. The levels pushed to are none of those looked at in the same pass.
#include "lib/rect_state.glsl"

layout(local_size_x = 256) in;
layout(std430, binding = BIND_ATLAS_MERGE) coherent buffer MergeMap { uint mergeBits[]; };

shared uint kept;

// Blocks on a stack that the other level's group may be working on.
uint stacked(uint w, uint h) { return uint(atomicAdd(atlas.levels[levelIndex(w, h)].stackCount, 0)); }

// The stack of the parents' level has room for all that could be made of the two levels that merge into it. The children
// are counted before the parents: a group adds its parents before it takes the children off, so what it does meanwhile
// is counted twice or once, never left out.
bool parentsFit(uint w, uint h) {
  uint made = 0u;
  if (w == h) made = stacked(w, w) / 4u + stacked(w + 1u, w) / 2u;
  else made = stacked(w, h) / 2u + (w == h + 1u && h > 0u ? stacked(h, h) / 4u : 0u);
  memoryBarrierBuffer();
  uint parent = parentIndex(w, h);
  return atomicAdd(atlas.levels[parent].existing, 0u) + made < atlas.levels[parent].stackCapacity;
}

void mark(uint origin) {
  uint cell = mergeCell(atlas.config, origin);
  atomicOr(mergeBits[cell >> 5u], 1u << (cell & 31u));
}

bool marked(uint origin) {
  uint cell = mergeCell(atlas.config, origin);
  return (mergeBits[cell >> 5u] & (1u << (cell & 31u))) != 0u;
}

// Whether the block goes up in its parent.
bool merge(uint origin, uint w, uint h) {
  uint parent = parentOrigin(origin, w, h);
  for (uint i = 0u; i < siblingCount(w, h); ++i)
    if (!marked(siblingOrigin(parent, i, w, h))) return false;
  if (origin == parent) {
    pushBlock(parentIndex(w, h), parent);
    atomicAdd(atlas.levels[parentIndex(w, h)].existing, 1u);
    atomicAdd(atlas.events.merged, 1u);
  }
  return true;
}

void main() {
  uint h = atlas.mergeHeight;
  uint w = max(h, 1u) + gl_WorkGroupID.x;
  uint l = levelIndex(w, h);
  uint count = uint(atlas.levels[l].stackCount);
  uint base = atlas.levels[l].stackBase;
  uint me = gl_LocalInvocationIndex;
  if (count == 0u) return;
  if (h == atlas.config.superblockLog2) {
    for (uint i = me; i < count; i += gl_WorkGroupSize.x)
      pushSuperblock(superblockAt(atlas.config, stackEntries[base + i]));
    barrier();
    if (me == 0u) {
      atlas.levels[l].stackCount = 0;
      atlas.levels[l].existing -= count;
    }
    return;
  }
  if (me == 0u) kept = parentsFit(w, h) ? 0u : count;
  barrier();
  if (kept == count) return;
  barrier();
  for (uint i = me; i < count; i += gl_WorkGroupSize.x) mark(stackEntries[base + i]);
  memoryBarrierBuffer();
  barrier();
  // What is kept moves down the stack; it never passes what is still to be read.
  for (uint first = 0u; first < count; first += gl_WorkGroupSize.x) {
    uint i = first + me;
    uint origin = i < count ? stackEntries[base + i] : 0u;
    bool keep = i < count && !merge(origin, w, h);
    barrier();
    if (keep) stackEntries[base + atomicAdd(kept, 1u)] = origin;
    memoryBarrierBuffer();
    barrier();
  }
  if (me == 0u) {
    atlas.levels[l].stackCount = int(kept);
    atomicAdd(atlas.levels[l].existing, kept - count);
  }
}
