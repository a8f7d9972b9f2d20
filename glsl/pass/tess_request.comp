// A thread a triangle that is visible or was in the last frame. Slots that are no longer needed are given back; triangles
// that need one draw a number. Nothing is taken here.
#include "shared/levels.h"
#include "lib/tess_state.glsl"
#include "shared/tess_measure.h"

layout(local_size_x = TESS_GROUP) in;
layout(location = LOCATION_FRAME) uniform uint uFrame;

void giveBack(uint shape, uint place) {
  if (kindOf(shape) == kTessSingle) return;
  uint bin = binOfShape(shape);
  uint texels = texelsOfShape(shape);
  atomicAdd(bins[bin].live, -1u);
  atomicAdd(atlas.liveTexels, -texels);
  uint at = uint(atomicAdd(bins[bin].stackCount, 1));
  if (at < bins[bin].stackCapacity) {
    stackEntries[bins[bin].stackBase + at] = place;
  } else {
    // No room to remember it: lost until memory is reset. provision cuts the count.
    atomicAdd(atlas.events.lost, 1u);
    atomicAdd(atlas.events.lostTexels, texels);
  }
}

void release(uint triangle) {
  if (marks[triangle] == uFrame) return;  // still visible: its own thread decides
  if (states[triangle].epoch != atlas.epoch) return;
  if (kindOf(states[triangle].shape) != kTessSingle) {
    giveBack(states[triangle].shape, states[triangle].place);
    atomicAdd(atlas.events.freed, 1u);
  }
  states[triangle].epoch = 0u;
}

void request(uint triangle, TessMeasure measure) {
  TessState state = states[triangle];
  bool known = state.epoch == atlas.epoch;
  uint shape = selectShape(measure, atlas.config.constantBias + atlas.bias, known ? state.shape : kTessNone,
                           known ? atlas.config.hysteresis : -1.0);
  if (known && shape == state.shape && state.place != kNoPlace) return;
  bool held = known && kindOf(state.shape) != kTessSingle && state.place != kNoPlace;
  if (held) giveBack(state.shape, state.place);
  if (kindOf(shape) == kTessSingle) {
    states[triangle] = TessState(shape, tessRecord(atlas.config, triangle), 0u, atlas.epoch);
    return;
  }
  if (held) {
    atomicAdd(atlas.events.moved, 1u);
    atomicAdd(atlas.events.movedTexels, texelsOfShape(shape));
  }
  uint number = atomicAdd(bins[binOfShape(shape)].requested, 1u);
  states[triangle] = TessState(shape, number, 1u, atlas.epoch);
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < liveCount) release(liveIds[i]);
  if (i < visibleCount) {
    uint triangle = visibleIds[i];
    request(triangle, measures[i]);
    liveIds[i] = triangle;  // for the next frame; nobody else reads place i. provision sets the count
  }
}
