// Opens a frame of the tessellation gatherer's memory phases: the target S, the bias, whether all memory is freed. One
// group.
#include "shared/levels.h"
#include "lib/tess_state.glsl"

layout(local_size_x = 128) in;
layout(location = LOCATION_COUNT) uniform uint uAsked;  // bit 0: the caller wants a reset; bit 1: resets are held back

shared bool freeing;

bool openFrame() {
  uint low = 0u;
  uint high = 0u;
  uint singles = 0u;
  for (uint part = 0u; part < kTessIdeals; ++part) {
    low += atlas.ideal[part].low;
    high += atlas.ideal[part].high + (low < atlas.ideal[part].low ? 1u : 0u);
    singles += atlas.ideal[part].singles;
  }
  uint visible = max(visibleCount, liveCount);
  atlas.requestGroupsX = (visible + uint(TESS_GROUP) - 1u) / uint(TESS_GROUP);
  atlas.requestGroupsY = 1u;
  atlas.requestGroupsZ = 1u;
  atlas.pressure = stepPressure(atlas.pressure, atlas.config.pressure, atlas.events.failures + atlas.events.reduced > 0u,
                                float(atlas.cellTexels), 0.0, atlas.bias > atlas.config.lowestBias,
                                (uAsked & 2u) != 0u, (uAsked & 1u) != 0u);
  bool reset = atlas.pressure.reset != 0u;
  if (reset) {
    ++atlas.resets;
    ++atlas.epoch;  // frees every slot at once
    atlas.rectCount = 1u;
    atlas.rects[0] = FreeRect(0u, 0u, atlas.config.width, atlas.config.height);
    atlas.cellTexels = 0u;
    atlas.liveTexels = 0u;
  }
  // Singles have texels of their own, outside of what S counts.
  atlas.bias =
      atlas.config.biased != 0u ? pressureBias(low, high, 0u, atlas.pressure.target, atlas.config.lowestBias) : 0.0;
  atlas.events = TessEvents(0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
  atlas.runCount = 0u;
  ++atlas.frames;
  return reset;
}

// Takes off what the last frame's requests got: its assign pass only read.
void closeBin(uint bin) {
  uint requested = bins[bin].requested;
  if (requested == 0u) return;
  bool hadSpare = bins[bin].spare != kNoPlace;
  bins[bin].stackCount -= int(bins[bin].given - (hadSpare ? 1u : 0u));
  uint fresh = bins[bin].provided - bins[bin].given;
  bins[bin].spare = kNoPlace;
  if ((fresh & 1u) != 0u) {
    // The last cell's second slot.
    TessRun last = runs[bins[bin].runFirst + bins[bin].runCount - 1u];
    uint cell = fresh / 2u - last.firstCell;
    bins[bin].spare = packPlace(placeX(last.place) + cell % last.columns * bins[bin].cellWidth,
                                placeY(last.place) + cell / last.columns * bins[bin].cellHeight, 1u);
  }
}

void main() {
  uint i = gl_LocalInvocationIndex;
  if (i == 0u) freeing = openFrame();
  barrier();
  if (i < kTessIdeals) {  // for the next frame's measuring
    atlas.ideal[i].low = 0u;
    atlas.ideal[i].high = 0u;
    atlas.ideal[i].singles = 0u;
  }
  for (uint bin = i; bin < atlas.config.bins; bin += gl_WorkGroupSize.x) {
    closeBin(bin);
    bins[bin].requested = 0u;
    if (!freeing) continue;
    bins[bin].stackCount = 0;
    bins[bin].spare = kNoPlace;
    bins[bin].live = 0u;
  }
}
