// Request phase (Mueller 2021, Alg. 1): a thread a patch that is visible or was in the last frame. Blocks that are no
// longer needed are given back; patches that need one draw a slot number. Nothing is taken here.
#include "lib/rect_state.glsl"

layout(local_size_x = RECT_GROUP) in;
layout(std430, binding = BIND_VISIBLE_MARK) readonly buffer Marks { uint marks[]; };
layout(std430, binding = BIND_PATCH_MEASURE) readonly buffer Measures { PatchMeasure measures[]; };
layout(location = LOCATION_FRAME) uniform uint uFrame;

// Fields of a patch state are read one by one, when they are needed: most patches neither come nor go.
void release(uint patchId) {
  if (marks[patchId] == uFrame) return;  // still visible: its own thread decides
  if (patchStates[patchId].epoch != atlas.epoch) return;
  uint level = patchStates[patchId].level;
  if (levelWidth(level) > 0u) {
    giveBack(level, patchStates[patchId].origin);
    atomicAdd(atlas.events.freed, 1u);
  }
  patchStates[patchId] = PatchState(recordOrigin(atlas.config, patchId), 0u, 0u);
}

// Whether memory that could be cut into a block of this size is free, beyond what was requested so far. It is no promise,
// as others may ask after this: who then gets a smaller block again was moved for nothing, which is why nobody tries
// without a good chance.
bool roomFor(uint w, uint h) {
  float texels = float(1u << (w + h));
  float spare = float(atlas.superblocksFree << (2u * atlas.config.superblockLog2));
  for (;;) {
    uint l = levelIndex(w, h);
    spare += (float(atlas.levels[l].stackCount) - float(atlas.levels[l].requested)) * float(1u << (w + h));
    if (h == atlas.config.superblockLog2) break;
    ++h;
    w = max(w, h);
  }
  return spare >= texels;
}

void request(uint patchId, PatchMeasure measure) {
  uint current = patchStates[patchId].level;
  uint epoch = patchStates[patchId].epoch;
  bool known = epoch == atlas.epoch;
  uint level = selectLevel(measure, atlas.config.constantBias, atlas.pressureBias, atlas.config.range, current,
                           known ? atlas.config.hysteresis : -1.0);
  if (known && (current & kLevelSize) == (level & kLevelSize)) {
    if (current != level) patchStates[patchId].level = level;  // the same block, seen the other way round
    return;
  }
  // The reset that follows makes room; where it is held back, what others give back may.
  if (known && waitsForMemory(current, level) &&
      !(atlas.pressure.pending != 0u && roomFor(levelWidth(level), levelHeight(level)))) {
    atomicAdd(atlas.events.waiting, 1u);
    return;
  }
  // It had a block in the last frame, which a reset may have taken: blocks of what goes out of sight are given back
  // at once, and a block of the last epoch can only have been held up to this frame's reset.
  bool held = levelWidth(current) > 0u && (known || (epoch + 1u == atlas.epoch && atlas.pressure.reset != 0u));
  if (known && held) giveBack(current, patchStates[patchId].origin);
  bool asks = levelWidth(level) > 0u;
  if (held && asks) {
    atomicAdd(atlas.events.moved, 1u);
    atomicAdd(atlas.events.movedTexels, levelTexels(level));
  } else if (held) {
    atomicAdd(atlas.events.freed, 1u);
  }
  if (asks) {
    uint slot = atomicAdd(atlas.levels[levelIndexOf(level)].requested, 1u);
    patchStates[patchId] = PatchState(slot, level | kLevelPending, atlas.epoch);
  } else {
    patchStates[patchId] = PatchState(recordOrigin(atlas.config, patchId), 0u, atlas.epoch);
  }
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < liveCount) release(liveIds[i]);
  if (i < visibleCount) {
    uint patchId = visibleIds[i];
    request(patchId, measures[i]);
    liveIds[i] = patchId;  // for the next frame; nobody else reads place i. provision sets the count
  }
}
