// A thread a visible triangle: a request's number says which slot it gets. What found no memory is one texel, and asks
// again next frame.
#include "lib/tess_state.glsl"

layout(local_size_x = TESS_GROUP) in;

uint slotOf(uint bin, uint number) {
  bool hasSpare = bins[bin].spare != kNoPlace;
  if (hasSpare && number == 0u) return bins[bin].spare;
  if (number < bins[bin].given) {
    uint back = number - (hasSpare ? 1u : 0u);
    return stackEntries[bins[bin].stackBase + uint(bins[bin].stackCount) - 1u - back];
  }
  uint slot = number - bins[bin].given;
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

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= visibleCount) return;
  uint triangle = visibleIds[i];
  TessState state = states[triangle];
  if (state.pending != 0u) {
    uint bin = binOfShape(state.shape);
    uint number = state.place;
    while (bin != kNoBin && number >= bins[bin].provided) {
      number = number - bins[bin].provided + bins[bin].overflowBase;
      bin = bins[bin].overflowBin;
    }
    state.pending = 0u;
    if (bin != kNoBin) {
      state.shape = shapeOfBin(bin);
      state.place = slotOf(bin, number);
      atomicAdd(bins[bin].live, 1u);
      atomicAdd(atlas.liveTexels, texelsOfShape(state.shape));
    } else {
      atomicAdd(atlas.events.failures, 1u);
      state.shape = kTessSingle;
      state.place = tessRecord(atlas.config, triangle);
    }
    states[triangle] = state;
  }
  if (kindOf(state.shape) == kTessSingle) {
    atomicAdd(atlas.events.singles, 1u);
    atomicAdd(atlas.events.samples, 1u);
  } else {
    uint texels = texelsOfShape(state.shape);
    atomicAdd(atlas.events.samples, texels);
    atomicAdd(atlas.events.lTexels, texels);
  }
}
