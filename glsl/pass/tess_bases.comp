// Where each batch's samples begin in the list of all.
#include "shared/bindings.h"
#include "shared/tess_atlas.h"

layout(local_size_x = 1) in;
layout(std430, binding = BIND_TESS_GROUPS) buffer Groups { TessGroups groups[]; };
layout(location = LOCATION_COUNT) uniform uint uBatches;

void main() {
  uint first = 0u;
  for (uint batch = 0u; batch < uBatches; ++batch) {
    groups[batch].first = first;
    first += groups[batch].samples;
  }
}
