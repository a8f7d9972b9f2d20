// The buffers of the memory phases.
#include "shared/bindings.h"
#include "shared/levels.h"
#include "shared/rect_memory.h"

layout(std430, binding = BIND_ATLAS_STATE) buffer AtlasStates { AtlasState atlas; };
layout(std430, binding = BIND_ATLAS_STACKS) buffer AtlasStacks { uint stackEntries[]; };
layout(std430, binding = BIND_PATCH_STATE) buffer PatchStates { PatchState patchStates[]; };
layout(std430, binding = BIND_ATLAS_LIVE) buffer Live { uint liveCount; uint liveIds[]; };
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };

void pushBlock(uint level, uint origin) {
  uint l = levelIndexOf(level);
  uint place = uint(atomicAdd(atlas.levels[l].stackCount, 1));
  stackEntries[atlas.levels[l].stackBase + place] = origin;
}
