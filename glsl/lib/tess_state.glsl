// The buffers of the memory phases of the tessellation gatherer's atlas.
#include "shared/bindings.h"
#include "shared/tess_atlas.h"

layout(std430, binding = BIND_ATLAS_STATE) coherent buffer AtlasStates { TessAtlasState atlas; };
layout(std430, binding = BIND_ATLAS_STACKS) coherent buffer Stacks { uint stackEntries[]; };
layout(std430, binding = BIND_TESS_BINS) coherent buffer Bins { TessBin bins[]; };
layout(std430, binding = BIND_TESS_RUNS) buffer Runs { TessRun runs[]; };
layout(std430, binding = BIND_PATCH_STATE) buffer States { TessState states[]; };
layout(std430, binding = BIND_PATCH_MEASURE) readonly buffer Measures { TessMeasure measures[]; };
layout(std430, binding = BIND_ATLAS_LIVE) buffer Live { uint liveCount; uint liveIds[]; };
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_VISIBLE_MARK) readonly buffer Marks { uint marks[]; };

const uint kNoBin = 0xffffffffu;

// The bin of about half the area.
uint smallerBin(uint bin) { return bin == 0u ? kNoBin : bin * 7u / 10u; }
uint shapeOfBin(uint bin) { return shapeOfL(2u * (bin + 1u)); }

uint binOfShape(uint shape) { return levelOfShape(shape) / 2u - 1u; }
uint texelsOfShape(uint shape) { return lTexels(levelOfShape(shape)); }
