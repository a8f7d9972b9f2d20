// Request phase (Mueller 2021, Alg. 1): a thread a patch that is visible or was in the last frame. Blocks that are no
// longer needed go on the stack of their level; patches that need one draw a slot number. Nothing is taken here.
#include "lib/rect_state.glsl"

layout(local_size_x = RECT_GROUP) in;
layout(std430, binding = BIND_VISIBLE_MARK) readonly buffer Marks { uint marks[]; };
layout(std430, binding = BIND_PATCH_MEASURE) readonly buffer Measures { PatchMeasure measures[]; };
layout(location = LOCATION_FRAME) uniform uint uFrame;

void release(uint patchId) {
  if (marks[patchId] == uFrame) return;  // still visible: its own thread decides
  PatchState state = patchStates[patchId];
  if (state.epoch != atlas.epoch || levelWidth(state.level) == 0u) return;
  pushBlock(state.level, state.origin);
  patchStates[patchId].origin = recordOrigin(atlas.config, patchId);
  patchStates[patchId].level = 0u;
}

void request(uint patchId, PatchMeasure measure) {
  PatchState state = patchStates[patchId];
  bool known = state.epoch == atlas.epoch;
  uint level = selectLevel(measure, atlas.config.constantBias, atlas.pressureBias, atlas.config.superblockLog2,
                           state.level, known ? atlas.config.hysteresis : -1.0);
  if (known) {
    if (state.level == level) return;
    if ((state.level & kLevelSize) == (level & kLevelSize)) {  // the same block, seen the other way round
      patchStates[patchId].level = level;
      return;
    }
    if (levelWidth(state.level) > 0u) pushBlock(state.level, state.origin);
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
  if (i < visibleCount) request(visibleIds[i], measures[i]);
}
