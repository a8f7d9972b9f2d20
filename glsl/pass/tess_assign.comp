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
  return placeInRuns(bin, number - bins[bin].given);
}

// Of a triangle that failed: a half that was served belongs to nobody until memory is reset, as the failure asks for.
void loseServed(uint bin, uint number) {
  if (bin == kNoBin || number >= bins[bin].provided) return;
  atomicAdd(atlas.events.lost, 1u);
  atomicAdd(atlas.events.lostTexels, bins[bin].cellWidth * bins[bin].cellHeight / 2u);
}

bool served(uint bin, uint number) { return bin == kNoBin || number < bins[bin].provided; }

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= visibleCount) return;
  uint triangle = visibleIds[i];
  TessState state = states[triangle];
  if (state.pending != 0u) {
    uvec2 wanted = binsOf(state.shape);
    if (served(wanted.x, state.place0) && served(wanted.y, state.place1)) {
      if (wanted.x != kNoBin) state.place0 = slotOf(wanted.x, state.place0);
      if (wanted.y != kNoBin) state.place1 = slotOf(wanted.y, state.place1);
      atomicAdd(atlas.liveTexels, texelsOfShape(state.shape));
    } else {
      atomicAdd(atlas.events.failures, 1u);
      loseServed(wanted.x, state.place0);
      loseServed(wanted.y, state.place1);
      state.shape.kind = kTessSingle;
      state.place0 = tessRecord(atlas.config, triangle);
    }
    state.pending = 0u;
    states[triangle] = state;
  }
  uint texels = texelsOfShape(state.shape);
  atomicAdd(atlas.events.samples, texels);
  uint kind = kindOf(state.shape.kind);
  if (kind == kTessSingle) atomicAdd(atlas.events.singles, 1u);
  if (kind == kTessL) atomicAdd(atlas.events.lSamples, texels);
  if (kind != kTessOver) return;
  OverShape over = overOfShape(state.shape);
  atomicAdd(atlas.events.slanted, 1u);
  atomicAdd(atlas.events.inside, overBlockInside(over.columns0, over.rows) + overBlockInside(over.columns1, over.rows));
  atomicAdd(atlas.events.outside, overBlockOutside(over.columns0, over.rows) + overBlockOutside(over.columns1, over.rows));
}
