// A thread a triangle that is visible or was in the last frame. Slots that are no longer needed are given back; triangles
// that need some draw a number for each. Nothing is taken here.
#include "lib/tess_state.glsl"

layout(local_size_x = TESS_GROUP) in;
layout(location = LOCATION_FRAME) uniform uint uFrame;

void giveBack(uint bin, uint place) {
  if (bin == kNoBin) return;
  uint at = uint(atomicAdd(bins[bin].stackCount, 1));
  if (at < bins[bin].stackCapacity) {
    stackEntries[bins[bin].stackBase + at] = place;
  } else {
    // No room to remember it: lost until memory is reset. provision cuts the count.
    atomicAdd(atlas.events.lost, 1u);
    atomicAdd(atlas.events.lostTexels, bins[bin].cellWidth * bins[bin].cellHeight / 2u);
  }
}

void giveBackAll(TessState state) {
  uvec2 held = binsOf(state.shape);
  giveBack(held.x, state.place0);
  giveBack(held.y, state.place1);
  atomicAdd(atlas.liveTexels, -texelsOfShape(state.shape));
}

void release(uint triangle) {
  uint seen = triangle < atlas.config.triangles ? marks[triangle] : splitPieces[triangle - atlas.config.triangles].frame;
  if (seen == uFrame) return;  // still visible: its own thread decides
  if (states[triangle].epoch != atlas.epoch) return;
  if (kindOf(states[triangle].shape.kind) != kTessSingle) {
    giveBackAll(states[triangle]);
    atomicAdd(atlas.events.freed, 1u);
  }
  states[triangle].epoch = 0u;
}

bool sameSize(TessShape a, TessShape b) { return a.kind == b.kind && a.size == b.size && a.form >> 16u == b.form >> 16u; }

void request(uint triangle, TessMeasure measure) {
  TessState state = states[triangle];
  bool known = state.epoch == atlas.epoch;
  TessShape shape = selectShape(measure, atlas.config.constantBias, atlas.bias,
                                limitsOfSplit(atlas.config.limits, state.split), state.shape,
                                known ? atlas.config.hysteresis : -1.0);
  if (known && sameSize(shape, state.shape)) {
    if (shape.form != state.shape.form) states[triangle].shape.form = shape.form;  // the same blocks, another foot
    return;
  }
  bool held = known && kindOf(state.shape.kind) != kTessSingle;
  if (held) {
    giveBackAll(state);
    atomicAdd(atlas.events.moved, 1u);
    atomicAdd(atlas.events.movedTexels, texelsOfShape(shape));
  }
  state.shape = shape;
  state.epoch = atlas.epoch;
  state.pending = 0u;
  uvec2 wanted = binsOf(shape);
  if (kindOf(shape.kind) == kTessSingle) state.place0 = tessRecord(atlas.config, triangle);
  if (wanted.x != kNoBin) {
    state.place0 = atomicAdd(bins[wanted.x].requested, 1u);
    state.pending |= 1u;
  }
  if (wanted.y != kNoBin) {
    state.place1 = atomicAdd(bins[wanted.y].requested, 1u);
    state.pending |= 2u;
  }
  states[triangle] = state;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (atlas.round == 0u && i < liveCount) release(liveIds[i]);
  if (i < visibleCount) {
    uint triangle = visibleIds[i];
    request(triangle, measures[i]);
    liveIds[i] = triangle;  // for the next frame; nobody else reads place i. plan sets the count
  }
}
