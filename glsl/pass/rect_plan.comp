// Opens a frame of the memory phases: the bias, the target S, whether all memory is freed, and what is merged. One group.
#include "lib/rect_state.glsl"

layout(local_size_x = 128) in;
layout(location = LOCATION_COUNT) uniform uint uAsked;  // bit 0: the caller wants a reset; bit 1: resets are held back

shared bool freeing;

// What the visible set would ideally take, all parts together.
IdealSum idealOfVisible() {
  IdealSum sum = atlas.ideal[0];
  for (uint part = 1u; part < kIdealSums; ++part) {
    IdealSum more = atlas.ideal[part];
    sum.low += more.low;
    sum.high += more.high + (sum.low < more.low ? 1u : 0u);
    sum.ones += more.ones;
    sum.newLow += more.newLow;
    sum.newHigh += more.newHigh + (sum.newLow < more.newLow ? 1u : 0u);
  }
  return sum;
}

// Texels of live blocks, for the soft mark. Where free blocks are merged and cut
// they serve other sizes; where not, S follows resets alone, as published.
float takenTexels() {
  if (atlas.config.merges == 0u) return 0.0;
  uint taken = atlas.cutTexels;
  for (uint w = 1u; w <= atlas.config.superblockLog2; ++w)
    for (uint h = 0u; h <= w; ++h) taken -= uint(atlas.levels[levelIndex(w, h)].stackCount) << (w + h);
  return float(taken);
}

bool openFrame() {
  AtlasConfig config = atlas.config;
  uint visible = max(visibleCount, liveCount);
  atlas.requestGroupsX = (visible + uint(RECT_GROUP) - 1u) / uint(RECT_GROUP);
  atlas.requestGroupsY = 1u;
  atlas.requestGroupsZ = 1u;

  IdealSum ideal = idealOfVisible();
  PressureInput last;
  last.failed = atlas.events.failures + atlas.events.reduced > 0u;
  last.waiting = atlas.events.waiting > 0u;
  last.load = float(atlas.cutTexels);
  last.room = float(config.width * config.height - atlas.cutTexels);
  last.live = takenTexels();
  last.fresh = biasedTexels(ideal.newLow, ideal.newHigh, atlas.pressureBias);
  last.limits = atlas.pressureBias > config.lowestBias;
  last.held = (uAsked & 2u) != 0u;
  last.asked = (uAsked & 1u) != 0u;
  atlas.pressure = stepPressure(atlas.pressure, config.pressure, last);
  bool reset = atlas.pressure.reset != 0u;
  if (reset) {
    ++atlas.resets;
    ++atlas.epoch;  // frees every block at once: what a patch state says of an older epoch no longer holds
    atlas.superblocksFree = config.superblocks;
    atlas.cutTexels = 0u;
  }
  // A height a frame: siblings merge into a block of the next height, which has its turn in the next frame.
  uint height = atlas.mergeHeight >= config.superblockLog2 ? 0u : atlas.mergeHeight + 1u;
  bool merging = config.merges != 0u && atlas.cutTexels > config.mergeLoad;
  atlas.mergeHeight = height;
  atlas.mergeGroupsX = merging ? config.superblockLog2 + 1u - max(height, 1u) : 0u;
  atlas.mergeGroupsY = 1u;
  atlas.mergeGroupsZ = 1u;

  atlas.pressureBias = config.biased == 0u ? 0.0
                                           : pressureBias(ideal.low, ideal.high, ideal.ones, config.range,
                                                          atlas.pressure.target, config.lowestBias);
  atlas.events = AtlasEvents(0u, 0u, 0u, 0u, 0u, 0u, 0u);
  ++atlas.frames;
  return reset;
}

void freeBin(uint bin, uint largest) {
  atlas.bins[bin].carryOffset = largest;  // a full superblock that does not exist
  atlas.bins[bin].carrySuperblock = kNoSuperblock;
}

void main() {
  if (gl_LocalInvocationIndex == 0u) freeing = openFrame();
  barrier();
  uint i = gl_LocalInvocationIndex;
  if (i < kIdealSums) {  // for the next frame's measuring
    atlas.ideal[i].low = 0u;
    atlas.ideal[i].high = 0u;
    atlas.ideal[i].ones = 0u;
    atlas.ideal[i].newLow = 0u;
    atlas.ideal[i].newHigh = 0u;
  }
  if (!freeing) return;
  uint log2Size = atlas.config.superblockLog2;
  for (uint w = 1u; w <= log2Size; ++w) {
    if (i > w) continue;
    uint l = levelIndex(w, i);
    atlas.levels[l].stackCount = 0;
    atlas.levels[l].existing = 0u;
    atlas.levels[l].lost = 0u;
    if (atlas.config.columns == 0u) freeBin(l, blocksPerSuperblock(log2Size, w, i));
    else if (i == w) freeBin(w, blocksPerSuperblock(log2Size, w, w));
  }
  // The lowest on top: what is used stays together.
  for (uint s = i; s < atlas.config.superblocks; s += gl_WorkGroupSize.x) {
    superblockWords[s] = atlas.config.superblocks - 1u - s;
    superblockWords[liveWord(s)] = 0u;
  }
}
