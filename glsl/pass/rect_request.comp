// Request phase (Mueller 2021, Alg. 1): a thread a patch that is visible or was in the last frame. Blocks that are no
// longer needed go on the stack of their level; patches that need one draw a slot number. Nothing is taken here.
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
  if (levelWidth(level) == 0u) return;
  pushBlock(level, patchStates[patchId].origin);
  patchStates[patchId].origin = recordOrigin(atlas.config, patchId);
  patchStates[patchId].level = 0u;
}

void request(uint patchId, PatchMeasure measure) {
  uint current = patchStates[patchId].level;
  bool known = patchStates[patchId].epoch == atlas.epoch;
  uint level = selectLevel(measure, atlas.config.constantBias, atlas.pressureBias, atlas.config.superblockLog2,
                           current, known ? atlas.config.hysteresis : -1.0);
  if (known) {
    if ((current & kLevelSize) == (level & kLevelSize)) {
      if (current != level) patchStates[patchId].level = level;  // the same block, seen the other way round
      return;
    }
    if (levelWidth(current) > 0u) pushBlock(current, patchStates[patchId].origin);
  }
  if (levelWidth(level) > 0u) {
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
