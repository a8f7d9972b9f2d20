// The buffers of the memory phases of the tessellation gatherer's atlas.
#include "shared/bindings.h"
#include "shared/tess_atlas.h"
#include "shared/tess_measure.h"

layout(std430, binding = BIND_ATLAS_STATE) coherent buffer AtlasStates { TessAtlasState atlas; };
layout(std430, binding = BIND_ATLAS_STACKS) coherent buffer Stacks { uint stackEntries[]; };
layout(std430, binding = BIND_TESS_BINS) coherent buffer Bins { TessBin bins[]; };
layout(std430, binding = BIND_TESS_RUNS) buffer Runs { TessRun runs[]; };
layout(std430, binding = BIND_PATCH_STATE) buffer States { TessState states[]; };
layout(std430, binding = BIND_PATCH_MEASURE) readonly buffer Measures { TessMeasure measures[]; };
layout(std430, binding = BIND_ATLAS_LIVE) buffer Live { uint liveCount; uint liveIds[]; };
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_SPLIT_PIECES) readonly buffer SplitPieces { TessPieceGpu splitPieces[]; };
layout(std430, binding = BIND_VISIBLE_MARK) readonly buffer Marks { uint marks[]; };

const uint kNoBin = 0xffffffffu;

// The bins of a shape's places.
uvec2 binsOf(TessShape shape) {
  uint kind = kindOf(shape.kind);
  if (kind == kTessL) return uvec2(binOfLevel(levelOfKind(shape.kind)), kNoBin);
  if (kind != kTessOver) return uvec2(kNoBin);
  OverShape over = overOfShape(shape);
  return uvec2(over.columns0 > 0u ? binOfBlock(over.columns0, over.rows) : kNoBin,
               over.columns1 > 0u ? binOfBlock(over.columns1, over.rows) : kNoBin);
}

// The place of new slot `slot` of a bin.
uint placeInRuns(uint bin, uint slot) {
  uint cell = slot / 2u;
  uint low = bins[bin].runFirst;
  uint high = low + bins[bin].runCount;
  while (high - low > 1u) {
    uint middle = (low + high) / 2u;
    if (runs[middle].firstCell <= cell) {
      low = middle;
    } else {
      high = middle;
    }
  }
  TessRun run = runs[low];
  cell -= run.firstCell;
  return packPlace(placeX(run.place) + cell % run.columns * bins[bin].cellWidth,
                   placeY(run.place) + cell / run.columns * bins[bin].cellHeight, slot & 1u);
}
