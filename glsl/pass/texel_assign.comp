// Gives each wanted tile the slot that it had in the last frame, or a free one, and counts what there is to shade.
#include "shared/scene.h"
#include "lib/texel_state.glsl"
#include "lib/triangle.glsl"

layout(local_size_x = TEXEL_GROUP) in;
layout(std430, binding = BIND_ATLAS_STACKS) buffer Stack { uint freeSlots[]; };
layout(std430, binding = BIND_TEXEL_BATCHES) buffer Batches { TexelBatch batches[]; };

uint samplesOf(uint triangles, uint tile) {
  uint level = tileLevel(tile);
  uint cellsX = cellsAlong(tileChartX(tile), level);
  uint cellsY = cellsAlong(tileChartY(tile), level);
  uvec2 first = kTexelCells * uvec2(tileX(tile), tileY(tile));
  uint samples = 0u;
  for (uint y = 0u; y < kTexelTile; ++y)
    for (uint x = 0u; x < kTexelTile; ++x)
      samples += texelNeeded(triangles, first.x + x, first.y + y, cellsX, cellsY) ? 1u : 0u;
  return samples;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  uint count = texels.source == 0u ? texels.wanted0 : texels.wanted1;
  uint current = texels.current;
  if (i >= count) return;
  uvec2 wanted = wantedTiles[texels.source * texels.config.wanted + i];
  uint number = tileNumber(charts[wanted.x], wanted.y);
  uint held = placeInTable(number, 1u - current);
  uint slot = held == kNoPlaceInTable ? 0u : table[held + 1u];
  if (slot != 0u) {
    atomicAdd(texels.kept, 1u);
    --slot;
  } else {
    slot = freeSlots[atomicAdd(texels.freeSlots, -1) - 1];
  }
  table[placeInTable(number, current) + 1u] = slot + 1u;
  tiles[current * texels.config.slots + i] = TexelTile(wanted.x, wanted.y, slot);
  uint instance = instanceOfPatch[wanted.x];
  atomicAdd(batches[instances[instance].batch].tiles, 1u);
  uint triangles = patches[instances[instance].patchOffset + wanted.x - instances[instance].patchBase].triangles;
  atomicAdd(texels.samples, samplesOf(triangles, wanted.y));
}
