// Gathering by compute: a thread a sample of the batch, which finds its triangle by bisection; or, with LISTED, in the list
// that a tessellator wrote (tess_enumerate.tese).
#include "lib/tess_shade.glsl"
#include "lib/tess_samples.glsl"
#include "lib/tess_store.glsl"
#include "lib/tess_image.glsl"
#include "shared/blocks.h"

layout(local_size_x = GROUP) in;
layout(std430, binding = BIND_BATCHES) readonly buffer Batches { BatchGpu batches[]; };
layout(std430, binding = BIND_DRAW_COMMANDS) readonly buffer DrawCommands { TessCommand commands[]; };
layout(std430, binding = BIND_TESS_STARTS) readonly buffer Starts { uint starts[]; };  // of each entry: its first sample
layout(std430, binding = BIND_TESS_GROUPS) readonly buffer Groups { TessGroups groups[]; };
#ifdef LISTED
layout(std430, binding = BIND_TESS_SAMPLES) readonly buffer Samples { uint entryOfSample[]; };
#endif
layout(location = LOCATION_COUNT) uniform uint uBatch;

void main() {
  uint thread = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * uint(GROUP) + gl_LocalInvocationIndex;
  if (thread >= groups[uBatch].samples) return;
#ifdef LISTED
  uint low = entryOfSample[groups[uBatch].first + thread];
#else
  uint low = batches[uBatch].firstEntry;
  uint high = low + commands[uBatch].count / 3u;
  while (high - low > 1u) {
    uint middle = (low + high) / 2u;
    if (starts[middle] <= thread) {
      low = middle;
    } else {
      high = middle;
    }
  }
#endif
  storeSample(low, sampleOf(entries[low], thread - starts[low]));
}
