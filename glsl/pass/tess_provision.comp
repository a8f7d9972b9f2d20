// Makes room for what was requested. One group. Bins come from the highest cells to the lowest, so that a band that the
// highest of its class opened has room for the others.
#include "lib/tess_state.glsl"

layout(local_size_x = 128) in;

shared uint wanting[128];
shared uint wantingCount;

// The band that takes cells of this height, with room for one at least: that of their class, else a higher one that would
// leave less than half of its height empty, else a new one.
uint bandFor(uint height, uint width) {
  uint own = bandClass(height);
  for (uint c = own; c < kTessBands; ++c) {
    TessBand band = atlas.bands[c];
    if (band.height >= height && band.height <= 2u * height && band.x + width <= atlas.config.width) return c;
  }
  if (atlas.bandTop + height <= atlas.config.height) {
    atlas.bands[own] = TessBand(atlas.bandTop, height, 0u);
    atlas.bandTop += height;
    return own;
  }
  // No room for a new band: any height is better than none.
  for (uint c = own; c < kTessBands; ++c)
    if (atlas.bands[c].height >= height && atlas.bands[c].x + width <= atlas.config.width) return c;
  return kTessBands;
}

void provide(uint bin) {
  uint requested = bins[bin].requested;
  uint given = min(requested, uint(bins[bin].stackCount) + (bins[bin].spare != kNoPlace ? 1u : 0u));
  uint cells = (requested - given + 1u) / 2u;
  uint width = bins[bin].cellWidth;
  uint height = bins[bin].cellHeight;
  uint made = 0u;
  bins[bin].runFirst = atlas.runCount;
  while (made < cells && atlas.runCount < atlas.config.runs) {
    uint c = bandFor(height, width);
    if (c == kTessBands) break;
    uint count = min(cells - made, (atlas.config.width - atlas.bands[c].x) / width);
    runs[atlas.runCount] = TessRun(made, packPlace(atlas.bands[c].x, atlas.bands[c].y, 0u));
    ++atlas.runCount;
    atlas.bands[c].x += count * width;
    made += count;
  }
  atlas.bandTexels += made * width * height;
  bins[bin].runCount = atlas.runCount - bins[bin].runFirst;
  bins[bin].given = given;
  bins[bin].provided = min(requested, given + 2u * made);
}

void main() {
  uint i = gl_LocalInvocationIndex;
  for (uint first = 0u; first < atlas.config.bins; first += gl_WorkGroupSize.x) {
    if (i == 0u) wantingCount = 0u;
    barrier();
    uint bin = first + i;
    wanting[i] = 0u;
    if (bin < atlas.config.bins) {
      bins[bin].stackCount = min(bins[bin].stackCount, int(bins[bin].stackCapacity));
      wanting[i] = bins[bin].requested;
      if (wanting[i] > 0u) atomicAdd(wantingCount, 1u);
    }
    barrier();
    if (i == 0u && wantingCount > 0u)
      for (uint k = 0u; k < gl_WorkGroupSize.x; ++k)
        if (wanting[k] > 0u) provide(first + k);
    barrier();
  }
  if (i == 0u) liveCount = visibleCount;
}
