// Makes room for what was requested. One group. Bins come from the largest cells to the smallest: the large find room
// before the small have cut it up.
#include "lib/tess_state.glsl"

layout(local_size_x = 128) in;

const uint kLeastSide = 4u;  // no cell is smaller

void dropRect(uint r) {
  --atlas.rectCount;
  atlas.rects[r] = atlas.rects[atlas.rectCount];
}

void keepRect(FreeRect rect) {
  if (rect.width < kLeastSide || rect.height < kLeastSide) return;
  if (atlas.rectCount < kFreeRects) {
    atlas.rects[atlas.rectCount] = rect;
    ++atlas.rectCount;
    return;
  }
  uint least = 0u;
  for (uint r = 1u; r < kFreeRects; ++r)
    if (atlas.rects[r].width * atlas.rects[r].height < atlas.rects[least].width * atlas.rects[least].height) least = r;
  if (atlas.rects[least].width * atlas.rects[least].height < rect.width * rect.height) atlas.rects[least] = rect;
}

// The free rectangle that a row of cells leaves the least height of, and of these the narrowest.
uint rectFor(uint width, uint height) {
  uint best = kFreeRects;
  uint bestScore = 0xffffffffu;
  for (uint r = 0u; r < atlas.rectCount; ++r) {
    FreeRect rect = atlas.rects[r];
    if (rect.width < width || rect.height < height) continue;
    uint score = ((rect.height - height) << 15u) + rect.width;
    if (score < bestScore) {
      best = r;
      bestScore = score;
    }
  }
  return best;
}

// Cuts up to `cells` cells from a free rectangle: a row of them, or full rows. What is left of it is free.
uint cutCells(uint r, uint cells, uint width, uint height, out TessRun run) {
  FreeRect rect = atlas.rects[r];
  uint columns = min(cells, rect.width / width);
  uint rows = min(cells / columns, rect.height / height);
  run.place = packPlace(rect.x, rect.y, 0u);
  run.columns = columns;
  dropRect(r);
  uint right = rect.width - columns * width;
  uint below = rect.height - rows * height;
  // The cut that leaves the larger rectangle whole.
  bool across = right * rows * height <= below * columns * width;
  keepRect(FreeRect(rect.x + columns * width, rect.y, right, across ? rows * height : rect.height));
  keepRect(FreeRect(rect.x, rect.y + rows * height, across ? rect.width : columns * width, below));
  return columns * rows;
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
    uint r = rectFor(width, height);
    if (r == kFreeRects) break;
    TessRun run;
    uint cut = cutCells(r, cells - made, width, height, run);
    run.firstCell = made;
    runs[atlas.runCount] = run;
    ++atlas.runCount;
    made += cut;
  }
  atlas.cellTexels += made * width * height;
  bins[bin].runCount = atlas.runCount - bins[bin].runFirst;
  bins[bin].given = given;
  bins[bin].provided = min(requested, given + 2u * made);
  uint rest = requested - bins[bin].provided;
  if (rest == 0u) return;
  // Levels go down rather than that a triangle is lost. Smaller bins have their turn later.
  uint smaller = smallerBin(bin);
  bins[bin].overflowBin = smaller;
  if (smaller == kNoBin) return;
  bins[bin].overflowBase = bins[smaller].requested;
  bins[smaller].requested += rest;
  atlas.events.reduced += rest;
}

void main() {
  uint i = gl_LocalInvocationIndex;
  for (uint bin = i; bin < atlas.config.bins; bin += gl_WorkGroupSize.x)
    bins[bin].stackCount = min(bins[bin].stackCount, int(bins[bin].stackCapacity));
  memoryBarrierBuffer();
  barrier();
  if (i > 0u) return;
  for (uint bin = atlas.config.bins; bin > 0u; --bin)
    if (bins[bin - 1u].requested > 0u) provide(bin - 1u);
  liveCount = visibleCount;
}
