// Where each batch's tiles begin in the queue, and what shades them.
#include "shared/blocks.h"
#include "lib/texel_state.glsl"

layout(local_size_x = 1) in;
layout(std430, binding = BIND_TEXEL_BATCHES) buffer Batches { TexelBatch batches[]; };
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_DRAW_COMMANDS) readonly buffer DrawCommands { DrawCommand commands[]; };

void main() {
  texels.visible = visibleCount;
  uint before = 0u;
  for (uint b = 0u; b < texels.config.batches; ++b) {
    uint count = batches[b].tiles;
    batches[b].firstTile = before;
    batches[b].queued = 0u;
    before += count;
    batches[b].entries = commands[b].count / 6u;
    // More groups along x than GL promises go along y.
    uint across = min(count, 65535u);
    batches[b].tileGroupsX = across;
    batches[b].tileGroupsY = across == 0u ? 0u : (count + across - 1u) / across;
    batches[b].tileGroupsZ = 1u;
    batches[b].recordGroupsX = texelGroups(batches[b].entries);
    batches[b].recordGroupsY = 1u;
    batches[b].recordGroupsZ = 1u;
  }
}
