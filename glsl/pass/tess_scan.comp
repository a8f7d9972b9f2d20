// A group a batch: where each of its entries' samples begin among the batch's, and how many groups of GROUP threads shade
// them all.
#include "shared/bindings.h"
#include "shared/blocks.h"
#include "shared/tess_measure.h"

layout(local_size_x = 128) in;
layout(std430, binding = BIND_BATCHES) readonly buffer Batches { BatchGpu batches[]; };
layout(std430, binding = BIND_DRAW_COMMANDS) readonly buffer DrawCommands { TessCommand commands[]; };
layout(std430, binding = BIND_GATHER_VERTICES) readonly buffer Entries { TessEntry entries[]; };
layout(std430, binding = BIND_TESS_STARTS) writeonly buffer Starts { uint starts[]; };  // see tess_gather.comp
layout(std430, binding = BIND_TESS_GROUPS) writeonly buffer Groups { TessGroups groups[]; };
layout(location = LOCATION_COUNT) uniform uint uGroup;

shared uint sums[128];

void main() {
  uint batch = gl_WorkGroupID.x;
  uint i = gl_LocalInvocationIndex;
  uint first = batches[batch].firstEntry;
  uint count = commands[batch].count / 3u;
  uint before = 0u;
  for (uint chunk = 0u; chunk < count; chunk += 128u) {
    uint own = chunk + i < count ? texelsOfShape(entries[first + chunk + i].shape) : 0u;
    sums[i] = own;
    barrier();
    for (uint reach = 1u; reach < 128u; reach += reach) {
      uint more = i >= reach ? sums[i - reach] : 0u;
      barrier();
      sums[i] += more;
      barrier();
    }
    if (chunk + i < count) starts[first + chunk + i] = before + sums[i] - own;
    before += sums[127];
    barrier();
  }
  if (i > 0u) return;
  uint needed = (before + uGroup - 1u) / uGroup;
  // More groups along x than GL promises go along y.
  uint across = min(needed, 65535u);
  groups[batch] = TessGroups(across, across == 0u ? 0u : (needed + across - 1u) / across, 1u, before, 0u);
}
