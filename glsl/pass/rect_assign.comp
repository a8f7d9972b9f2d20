// Assignment phase (Mueller 2021, Alg. 3): a thread a visible patch. A slot below slotCount is a place in the
// provisioned superblocks, any other request takes a block off the stack. Nothing is freed here. A patch that finds the
// stack empty is shaded in its record texel, and asks again next frame.
#include "lib/rect_state.glsl"

layout(local_size_x = RECT_GROUP) in;

uint takeSlot(uint w, uint h, LevelState level, uint slot) {
  uint place = slot + level.slotOffset;
  uint perSuperblockLog2 = 2u * atlas.config.superblockLog2 - w - h;
  uint number = place >> perSuperblockLog2;
  uint index = place & ((1u << perSuperblockLog2) - 1u);
  uint bin = binOf(atlas.config, w, h);
  uint superblock = number == 0u ? atlas.bins[bin].sourceSuperblock
                                 : superblockWords[atlas.bins[bin].firstPopped - (number - 1u)];
  return blockOrigin(atlas.config, superblock, index, w, h);
}

bool popBlock(uint l, out uint origin) {
  int place = atomicAdd(atlas.levels[l].stackCount, -1) - 1;
  if (place >= 0) {
    origin = stackEntries[atlas.levels[l].stackBase + uint(place)];
    return true;
  }
  atomicAdd(atlas.levels[l].stackCount, 1);
  return false;
}

// A smaller block in place of `level`. Whoever that block was meant for goes down in turn.
bool popSmaller(inout uint level, out uint origin) {
  for (uint next = smallerLevel(level, atlas.config.range); next != level;
       next = smallerLevel(level, atlas.config.range)) {
    level = next;
    if (popBlock(levelIndexOf(level), origin)) return true;
  }
  return false;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= visibleCount) return;
  uint patchId = visibleIds[i];
  uint size = patchStates[patchId].level;
  if ((size & kLevelPending) == 0u) return;
  size &= kLevelSize | kLevelTransposed;
  uint w = levelWidth(size);
  uint h = levelHeight(size);
  uint l = levelIndex(w, h);
  uint slot = patchStates[patchId].origin;
  LevelState level = atlas.levels[l];
  uint origin;
  if (slot < level.slotCount) {
    origin = takeSlot(w, h, level, slot);
    if (atlas.config.stacks == 0u)
      atomicAdd(superblockWords[liveWord(superblockAt(atlas.config, origin))], 1u << (w + h));
  } else if (popBlock(l, origin)) {
  } else if (atlas.config.merges != 0u && popSmaller(size, origin)) {
    size |= kLevelReduced;
    atomicAdd(atlas.events.reduced, 1u);
  } else {
    atomicAdd(atlas.events.failures, 1u);
    size = 0u;
    origin = recordOrigin(atlas.config, patchId);
  }
  patchStates[patchId].origin = origin;
  patchStates[patchId].level = size;
}
