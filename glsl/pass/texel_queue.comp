// Sorts the tiles by batch: the shade queue.
#include "shared/scene.h"
#include "lib/texel_state.glsl"
#include "lib/triangle.glsl"

layout(local_size_x = TEXEL_GROUP) in;
layout(std430, binding = BIND_TEXEL_BATCHES) buffer Batches { TexelBatch batches[]; };
layout(std430, binding = BIND_TEXEL_QUEUE) writeonly buffer Queue { TexelTile queue[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= (texels.shown == 0u ? texels.tiles0 : texels.tiles1)) return;
  TexelTile tile = tiles[texels.shown * texels.config.slots + i];
  uint batch = instances[instanceOfPatch[tile.patchId]].batch;
  queue[batches[batch].firstTile + atomicAdd(batches[batch].queued, 1u)] = tile;
}
