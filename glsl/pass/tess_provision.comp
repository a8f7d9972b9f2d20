// Makes room for what was requested. One group. Bins come from the largest cells to the smallest: the large find room
// before the small have cut it up.
#include "lib/tess_state.glsl"

layout(local_size_x = 128) in;

const uint kLeastSide = 2u;  // no cell is smaller

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

shared uint wanting[128];      // bins of this chunk that have requests, from high to low
shared uint wantingCount;
shared uint bestScore;
shared uint bestRect;
shared uint cellsLeft;

// How badly a rectangle suits a row of cells: the height that it leaves, and of equals the wider. All of the group looks,
// since there are many: the best one's number is left in shared memory. False where none has room.
const uint kUnsuited = 0xffffffffu;
uint scoreOf(FreeRect rect, uint width, uint height) {
  if (rect.width < width || rect.height < height) return kUnsuited;
  return ((rect.height - height) << 15u) + rect.width;
}

bool findRect(uint width, uint height) {
  uint mine = kUnsuited;
  uint rect = 0u;
  for (uint r = gl_LocalInvocationIndex; r < atlas.rectCount; r += gl_WorkGroupSize.x) {
    uint score = scoreOf(atlas.rects[r], width, height);
    if (score < mine) {
      mine = score;
      rect = r;
    }
  }
  atomicMin(bestScore, mine);
  barrier();
  uint best = bestScore;
  if (mine == best && mine != kUnsuited) bestRect = rect;  // equals are equally good
  barrier();
  return best != kUnsuited;
}

// Cuts up to `cells` cells from a free rectangle: a row of them, or full rows. What is left of it is free.
uint cutCells(uint r, uint cells, uint width, uint height, inout TessRun run) {
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

// Called by all of the group.
void provide(uint bin) {
  bool first = gl_LocalInvocationIndex == 0u;
  uint requested = bins[bin].requested;
  uint width = bins[bin].cellWidth;
  uint height = bins[bin].cellHeight;
  uint given = min(requested, uint(bins[bin].stackCount) + (bins[bin].spare != kNoPlace ? 1u : 0u));
  uint cells = (requested - given + 1u) / 2u;
  if (first) {
    bins[bin].runFirst = atlas.runCount;
    cellsLeft = cells;
    bestScore = kUnsuited;
  }
  barrier();
  while (cellsLeft > 0u) {
    bool room = atlas.runCount < atlas.config.runs;
    if (!findRect(width, height) || !room) break;
    if (first) {
      TessRun run;
      run.firstCell = cells - cellsLeft;
      uint cut = cutCells(bestRect, cellsLeft, width, height, run);
      runs[atlas.runCount] = run;
      ++atlas.runCount;
      cellsLeft -= cut;
      bestScore = kUnsuited;
    }
    memoryBarrierBuffer();
    barrier();
  }
  if (first) {
    uint made = cells - cellsLeft;
    atlas.cellTexels += made * width * height;
    bins[bin].runCount = atlas.runCount - bins[bin].runFirst;
    bins[bin].given = given;
    bins[bin].provided = min(requested, given + 2u * made);
    atlas.failed += requested - bins[bin].provided;
    atlas.wantedTexels += cells * width * height;
  }
  memoryBarrierBuffer();
  barrier();
}

void main() {
  if (atlas.requestGroupsX == 0u) return;  // this round is not needed
  uint i = gl_LocalInvocationIndex;
  // Ls from the largest to the smallest, then Oversampling's blocks: bins from high to low numbers within each.
  uint levels = (kLargestLevel + 127u) / 128u;
  uint blocks = (kTessBins - kLargestLevel + 127u) / 128u;
  for (uint k = 0u; k < levels + blocks; ++k) {
    uint top = k < levels ? kLargestLevel - 128u * k : kTessBins - 128u * (k - levels);
    uint least = k < levels ? 0u : kLargestLevel;
    uint bin = top - 1u - i;
    bool wants = false;
    if (top >= least + i + 1u) {
      bins[bin].stackCount = min(bins[bin].stackCount, int(bins[bin].stackCapacity));
      wants = bins[bin].requested > 0u;
    }
    wanting[i] = wants ? 1u : 0u;
    barrier();
    uint before = 0u;
    for (uint j = 0u; j < i; ++j) before += wanting[j];
    if (i == gl_WorkGroupSize.x - 1u) wantingCount = before + wanting[i];
    barrier();
    if (wants) wanting[before] = bin;
    memoryBarrierBuffer();
    barrier();
    for (uint j = 0u; j < wantingCount; ++j) provide(wanting[j]);
  }
}
