// Opens a round of the tessellation gatherer's memory phases. The first of a frame sets the target S and the bias, and
// says whether all memory is freed. Where a round found no room for all, the next one frees all memory and tries again,
// from the second on with coarser levels: a frame does not show what waits for memory. Where levels may not be coarser, one
// more round is all, and not more often than pressure resets memory. Rounds that are not needed cost an empty dispatch.
// One group.
#include "lib/tess_state.glsl"

layout(local_size_x = 128) in;
layout(location = LOCATION_COUNT) uniform uint uAsked;  // bit 0: the caller wants a reset; bit 1: resets are held back
layout(location = LOCATION_FRAME) uniform uint uRound;

shared bool running;
shared bool freeing;

void freeAll() {
  ++atlas.resets;
  ++atlas.epoch;
  atlas.rectCount = 1u;
  atlas.rects[0] = FreeRect(0u, 0u, atlas.config.width, atlas.config.height);
  atlas.cellTexels = 0u;
  atlas.liveTexels = 0u;
  atlas.events.lost = 0u;
  atlas.events.lostTexels = 0u;
}

void openFrame() {
  uint low = 0u;
  uint high = 0u;
  for (uint part = 0u; part < kTessIdeals; ++part) {
    low += atlas.ideal[part].low;
    high += atlas.ideal[part].high + (low < atlas.ideal[part].low ? 1u : 0u);
  }
  PressureInput last;
  last.failed = atlas.events.failures > 0u;
  last.waiting = false;
  last.load = float(atlas.cellTexels);
  last.room = float(atlas.config.width * atlas.config.height) - last.load;
  last.live = 0.0;
  last.fresh = 0.0;  // the rounds find room for what a camera jump brings
  last.limits = atlas.bias > atlas.config.lowestBias;
  last.held = (uAsked & 2u) != 0u;
  last.asked = (uAsked & 1u) != 0u;
  atlas.pressure = stepPressure(atlas.pressure, atlas.config.pressure, last);
  freeing = atlas.pressure.reset != 0u;
  // Singles have texels of their own, outside of what S counts.
  atlas.bias =
      atlas.config.biased != 0u ? pressureBias(low, high, 0u, LevelRange(0u, 0u, 1u), atlas.pressure.target, atlas.config.lowestBias) : 0.0;
  atlas.events = TessEvents(0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
  atlas.round = 0u;
  ++atlas.frames;
}

bool triesAgain() {
  if (atlas.failed == 0u || (uAsked & 2u) != 0u) return false;
  return atlas.config.biased != 0u || (uRound == 1u && atlas.pressure.sinceReset >= atlas.pressure.wait);
}

void openRound() {
  atlas.round = uRound;
  freeing = true;
  if (atlas.config.biased == 0u) {
    atlas.pressure.sinceReset = 0u;
    atlas.pressure.wait = min(2u * atlas.pressure.wait, kLongestResetWait);
  }
  if (uRound < 2u || atlas.config.biased == 0u) return;
  // What was wanted came after a reset, so it is all there is.
  float area = float(atlas.config.width * atlas.config.height);
  float more = max(log2(float(atlas.wantedTexels) / (0.85 * area)), 0.25) + 0.5 * float(uRound - 2u);
  atlas.bias += more;
  atlas.pressure.target = max(atlas.pressure.target * exp2(-more), atlas.config.pressure.targetSmallest);
}

// Takes off what the last frame's requests got: its assign pass only read.
void closeBin(uint bin) {
  uint requested = bins[bin].requested;
  if (requested == 0u) return;
  bool hadSpare = bins[bin].spare != kNoPlace;
  bins[bin].stackCount -= int(bins[bin].given - (hadSpare ? 1u : 0u));
  uint fresh = bins[bin].provided - bins[bin].given;
  // The last cell's second slot.
  bins[bin].spare = (fresh & 1u) != 0u ? placeInRuns(bin, fresh) : kNoPlace;
}

void main() {
  uint i = gl_LocalInvocationIndex;
  if (i == 0u) {
    running = uRound == 0u || triesAgain();
    freeing = false;
    if (running) {
      if (uRound == 0u) openFrame();
      else openRound();
      if (freeing) freeAll();
    }
    if (uRound == 1u) liveCount = visibleCount;  // what is gone was released
    uint count = uRound == 0u ? max(visibleCount, liveCount) : visibleCount;
    atlas.requestGroupsX = running ? (count + uint(TESS_GROUP) - 1u) / uint(TESS_GROUP) : 0u;
    atlas.requestGroupsY = 1u;
    atlas.requestGroupsZ = 1u;
  }
  barrier();
  if (!running) return;
  if (i < kTessIdeals) {  // for the next frame's measuring
    atlas.ideal[i].low = 0u;
    atlas.ideal[i].high = 0u;
    atlas.ideal[i].singles = 0u;
  }
  for (uint bin = i; bin < kTessBins; bin += gl_WorkGroupSize.x) {
    if (uRound == 0u) closeBin(bin);
    bins[bin].requested = 0u;
    if (!freeing) continue;
    bins[bin].stackCount = 0;
    bins[bin].spare = kNoPlace;
  }
  barrier();
  if (i == 0u) {
    atlas.runCount = 0u;
    atlas.failed = 0u;
    atlas.wantedTexels = 0u;
  }
}
