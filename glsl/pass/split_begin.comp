// Opens a frame of splitting: takes back the numbers of pieces whose triangle is gone. One group.
#include "lib/split_state.glsl"
#include "shared/tess_atlas.h"

layout(local_size_x = 128) in;
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_VISIBLE_MARK) readonly buffer Marks { uint marks[]; };
layout(std430, binding = BIND_PATCH_STATE) buffer States { TessState states[]; };
layout(std430, binding = BIND_SPLIT_ELEMENTS) buffer Elements { uint elementCount; uint elementIds[]; };
layout(location = LOCATION_FRAME) uniform uint uFrame;
layout(location = LOCATION_COUNT) uniform uint uBatches;

void main() {
  uint i = gl_LocalInvocationIndex;
  if (i == 0u) {
    split.freeCount = 0;
    elementCount = visibleCount;
  }
  for (uint batch = i; batch < uBatches; batch += gl_WorkGroupSize.x) piecesOfBatch[batch] = 0u;
  memoryBarrierBuffer();
  barrier();
  for (uint block = i; block < kSplitBlocks; block += gl_WorkGroupSize.x) {
    uint owner = split.owners[block];
    if (owner != kNoEntry && marks[owner] != uFrame) {
      states[owner].split = 0u;
      split.owners[block] = kNoEntry;
      owner = kNoEntry;
    }
    if (owner == kNoEntry) split.freeBlocks[atomicAdd(split.freeCount, 1)] = block;
  }
}
