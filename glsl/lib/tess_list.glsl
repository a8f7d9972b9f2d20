// The samples of all batches, as the entry of each: what enumerating writes and shading from the list reads.
#include "shared/bindings.h"
#include "shared/tess_atlas.h"
layout(std430, binding = BIND_GATHER_VERTICES) readonly buffer Entries { TessEntry entries[]; };
layout(std430, binding = BIND_TESS_STARTS) readonly buffer Starts { uint starts[]; };  // of each entry, in its batch
layout(std430, binding = BIND_TESS_GROUPS) readonly buffer Groups { TessGroups groups[]; };
layout(std430, binding = BIND_TESS_SAMPLES) writeonly buffer Samples { uint entryOfSample[]; };
layout(location = LOCATION_COUNT) uniform uint uBatch;

void listSample(uint entry, uint number) { entryOfSample[groups[uBatch].first + starts[entry] + number] = entry; }
