// Where each batch's entries begin, behind the pieces of the batches before it.
#include "lib/split_state.glsl"
#include "shared/blocks.h"
#include "shared/tess_atlas.h"

layout(local_size_x = 1) in;
layout(std430, binding = BIND_BATCHES) buffer Batches { BatchGpu batches[]; };
layout(std430, binding = BIND_DRAW_COMMANDS) buffer DrawCommands { TessCommand commands[]; };
layout(location = LOCATION_COUNT) uniform uint uBatches;

void main() {
  uint before = 0u;
  for (uint batch = 0u; batch < uBatches; ++batch) {
    commands[batch].first += 3u * before;  // vertices of display
    commands[uBatches + batch].first += 12u * before;  // of gathering by rasterization
    commands[2u * uBatches + batch].first += before;
    for (uint list = 0u; list < kDisplayLists; ++list) commands[(3u + list) * uBatches + batch].first += 3u * before;
    batches[batch].firstEntry = commands[batch].first / 3u;
    before += piecesOfBatch[batch];
  }
}
