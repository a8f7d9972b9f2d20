// Assignment phase (Mueller 2021, Alg. 3): a thread a visible patch. A slot below slotCount is a place in the
// provisioned superblocks, any other request takes a block off the stack. Nothing is freed here. A patch that finds the
// stack empty is shaded in its record texel, and asks again next frame.
#include "lib/rect_state.glsl"

layout(local_size_x = RECT_GROUP) in;

shared uint groupTexels;
shared uint groupRecords;
shared uint groupFailures;

uint takeSlot(uint w, uint h, LevelState level, uint slot) {
  uint place = slot + level.slotOffset;
  uint perSuperblockLog2 = 2u * atlas.config.superblockLog2 - w - h;
  uint number = place >> perSuperblockLog2;
  uint index = place & ((1u << perSuperblockLog2) - 1u);
  uint superblock = number == 0u ? atlas.widths[w].sourceSuperblock : atlas.widths[w].firstPopped + number - 1u;
  return blockOrigin(atlas.config, superblock, index, w, h);
}

// The level that the patch ends up with.
uint assign(uint patchId) {
  PatchState state = patchStates[patchId];
  if ((state.level & kLevelPending) == 0u) return state.level;
  uint w = levelWidth(state.level);
  uint h = levelHeight(state.level);
  uint l = levelIndex(w, h);
  LevelState level = atlas.levels[l];
  state.level &= kLevelSize | kLevelTransposed;
  if (state.origin < level.slotCount) {
    state.origin = takeSlot(w, h, level, state.origin);
  } else {
    int place = atomicAdd(atlas.levels[l].stackCount, -1) - 1;
    if (place < 0) {
      atomicAdd(atlas.levels[l].stackCount, 1);
      atomicAdd(groupFailures, 1u);
      state.level = 0u;
      state.origin = recordOrigin(atlas.config, patchId);
    } else {
      state.origin = stackEntries[level.stackBase + uint(place)];
    }
  }
  patchStates[patchId] = state;
  return state.level;
}

void main() {
  if (gl_LocalInvocationIndex == 0u) {
    groupTexels = 0u;
    groupRecords = 0u;
    groupFailures = 0u;
  }
  barrier();
  uint i = gl_GlobalInvocationID.x;
  if (i < visibleCount) {
    uint patchId = visibleIds[i];
    uint level = assign(patchId);
    liveIds[i] = patchId;
    if (levelWidth(level) > 0u)
      atomicAdd(groupTexels, levelTexels(level));
    else
      atomicAdd(groupRecords, 1u);
  }
  barrier();
  if (gl_LocalInvocationIndex == 0u) {
    if (groupTexels > 0u) atomicAdd(atlas.liveTexels, groupTexels);
    if (groupRecords > 0u) atomicAdd(atlas.records, groupRecords);
    if (groupFailures > 0u) atomicAdd(atlas.failures, groupFailures);
  }
}
