// Opens a frame of the memory phases: the bias, the target S, and whether all memory is freed. One group.
// A reset is asked for by the caller, or by pressure: the last frame failed a request, or cut more of the atlas into
// blocks than the high-water mark. Resets by pressure that follow each other without a calm frame between wait twice
// as long each time: where memory is too small for the demand, a reset every frame would buy nothing but flicker.
#include "lib/rect_state.glsl"

layout(local_size_x = 128) in;
layout(location = LOCATION_COUNT) uniform uint uResetAsked;

const uint kLongestWait = 64u;

shared bool freeing;

float biasOfVisible() {
  uint low = 0u;
  uint high = 0u;
  uint ones = 0u;
  for (uint part = 0u; part < kIdealSums; ++part) {
    low += atlas.ideal[part].low;
    high += atlas.ideal[part].high + (low < atlas.ideal[part].low ? 1u : 0u);
    ones += atlas.ideal[part].ones;
  }
  return pressureBias(low, high, ones, atlas.target);
}

bool openFrame() {
  AtlasConfig config = atlas.config;
  uint visible = max(visibleCount, liveCount);
  atlas.requestGroupsX = (visible + uint(RECT_GROUP) - 1u) / uint(RECT_GROUP);
  atlas.requestGroupsY = 1u;
  atlas.requestGroupsZ = 1u;

  float texels = float(config.width) * float(config.height);
  bool pressure = atlas.failures > 0u || float(atlas.cutTexels) > config.highWater * texels;
  uint since = atlas.sinceReset + 1u;
  bool byPressure = pressure && since >= atlas.resetWait;
  if (!pressure) {
    atlas.resetWait = 1u;
    atlas.target = min(atlas.target * config.targetGrowth, config.targetLargest);
  } else if (byPressure) {
    atlas.resetWait = min(2u * atlas.resetWait, kLongestWait);
    if (config.pressure != 0u) atlas.target = max(atlas.target * config.targetCut, config.targetSmallest);
  }
  bool reset = uResetAsked != 0u || byPressure;
  atlas.sinceReset = reset ? 0u : since;
  if (reset) {
    ++atlas.resets;
    ++atlas.epoch;  // frees every block at once: what a patch state says of an older epoch no longer holds
    atlas.superblocksUsed = 0u;
    atlas.cutTexels = 0u;
  }
  atlas.pressureBias = config.pressure != 0u ? biasOfVisible() : 0.0;
  atlas.failures = 0u;
  ++atlas.frames;
  return reset;
}

void main() {
  if (gl_LocalInvocationIndex == 0u) freeing = openFrame();
  barrier();
  uint i = gl_LocalInvocationIndex;
  if (i < kIdealSums) {  // for the next frame's measuring
    atlas.ideal[i].low = 0u;
    atlas.ideal[i].high = 0u;
    atlas.ideal[i].ones = 0u;
  }
  if (!freeing) return;
  if (i < kLevels) {
    atlas.levels[i].stackCount = 0;
    atlas.levels[i].existing = 0u;
  }
  if (i <= atlas.config.superblockLog2) {
    atlas.widths[i].carryOffset = blocksPerSuperblock(atlas.config.superblockLog2, i, i);
    atlas.widths[i].carrySuperblock = kNoSuperblock;
  }
}
