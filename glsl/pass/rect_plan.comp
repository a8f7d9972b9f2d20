// Opens a frame of the memory phases: the bias, the target S, whether all memory is freed, and what is merged. One group.
#include "lib/rect_state.glsl"

layout(local_size_x = 128) in;
layout(location = LOCATION_COUNT) uniform uint uAsked;  // bit 0: the caller wants a reset; bit 1: resets are held back

shared bool freeing;

float biasOfVisible() {
  uint low = 0u;
  uint high = 0u;
  uint least = 0u;
  for (uint part = 0u; part < kIdealSums; ++part) {
    low += atlas.ideal[part].low;
    high += atlas.ideal[part].high + (low < atlas.ideal[part].low ? 1u : 0u);
    least += atlas.ideal[part].ones;
  }
  return pressureBias(low, high, least * smallestTexels(atlas.config.range), atlas.pressure.target,
                      atlas.config.lowestBias);
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

// A camera that jumps: a good part of what it asks for is new and does not fit beside what the last frame left. Packing all
// afresh then moves little that would have stayed, and spares the new from want of memory.
bool jumps(PressureState pressure) {
  float fresh = 0.0;
  for (uint part = 0u; part < kIdealSums; ++part)
    fresh += float(atlas.ideal[part].newHigh) * 4294967296.0 + float(atlas.ideal[part].newLow);
  fresh *= exp2(-atlas.pressureBias);
  uint area = atlas.config.width * atlas.config.height;
  return atlas.cutTexels > 0u && fresh > float(area - atlas.cutTexels) && fresh > 0.25 * pressure.target;
}

bool openFrame() {
  AtlasConfig config = atlas.config;
  uint visible = max(visibleCount, liveCount);
  atlas.requestGroupsX = (visible + uint(RECT_GROUP) - 1u) / uint(RECT_GROUP);
  atlas.requestGroupsY = 1u;
  atlas.requestGroupsZ = 1u;

  PressureState pressure = stepPressure(atlas.pressure, config.pressure, atlas.events.failures + atlas.events.reduced > 0u,
                                        float(atlas.cutTexels), takenTexels(), atlas.pressureBias > config.lowestBias,
                                        (uAsked & 2u) != 0u, (uAsked & 1u) != 0u);
  if (pressure.reset == 0u && config.pressure.resets != 0u && (uAsked & 2u) == 0u && jumps(pressure)) {
    pressure.reset = 1u;
    pressure.sinceReset = 0u;
    pressure.target = min(pressure.target, config.pressure.targetStart);
  }
  atlas.pressure = pressure;
  bool reset = pressure.reset != 0u;
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

  atlas.pressureBias = config.biased != 0u ? biasOfVisible() : 0.0;
  atlas.events = AtlasEvents(0u, 0u, 0u, 0u, 0u, 0u);
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
