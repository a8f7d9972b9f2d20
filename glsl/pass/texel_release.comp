// Gives back the slots of tiles that are no longer wanted.
#include "lib/texel_state.glsl"

layout(local_size_x = TEXEL_GROUP) in;
layout(std430, binding = BIND_ATLAS_STACKS) buffer Stack { uint freeSlots[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  uint old = 1u - texels.current;
  if (i >= (old == 0u ? texels.tiles0 : texels.tiles1)) return;
  TexelTile held = tiles[old * texels.config.slots + i];
  if (placeInTable(tileNumber(charts[held.patchId], held.tile), texels.current) != kNoPlaceInTable) return;
  freeSlots[atomicAdd(texels.freeSlots, 1)] = held.slot;
}
