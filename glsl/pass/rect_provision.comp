// Provisioning phase: a thread a bin. Says how many requests of each level come from newly cut superblocks, and where
// those start. Mueller 2021, Alg. 2, but for what is wrong as printed: line 4 adds to r, all loops over heights begin at
// one texel, and the carried offset counts from the start of the last superblock. Before that, where siblings merge,
// free blocks that nobody asks for are cut for the requests that the stacks cannot serve.
// Superblocks go to the bins in rising order, so that the outcome does not depend on the order of threads.
#include "lib/rect_state.glsl"

layout(local_size_x = 128) in;

shared uint wantedOf[128];
// Of each level, while blocks are cut: free blocks, those that it lacks for its requests and its descendants, how many
// of the parents are cut for it.
shared uint freeOf[kLevels];
shared uint lackOf[kLevels];
shared uint cutsOf[kLevels];
shared bool cutting;

// Blocks of a level that its stack cannot give. Never more than the stack could take back, less one for an odd
// remainder; what is beyond fails like any request without memory.
uint needOf(uint l) {
  LevelState level = atlas.levels[l];
  int need = int(level.requested) - level.stackCount;
  return uint(clamp(need, 0, max(0, int(level.stackCapacity) - 1 - int(level.existing))));
}

// No place for a remainder on some stack of this width: then nothing is cut, as a frame may leave one on each.
bool stacksFull(uint w) {
  for (uint h = 0u; h < w; ++h) {
    LevelState level = atlas.levels[levelIndex(w, h)];
    if (level.existing >= level.stackCapacity) return true;
  }
  return false;
}

// Plans the cuts: what is lacking is summed from the smallest blocks up, then what nobody asks for is handed down.
void planCuts() {
  uint log2Size = atlas.config.superblockLog2;
  for (uint w = 1u; w <= log2Size; ++w)
    for (uint h = 0u; h <= w; ++h) {
      uint l = levelIndex(w, h);
      uint asked = atlas.levels[l].requested + lackOf[l];
      lackOf[l] = asked > freeOf[l] ? asked - freeOf[l] : 0u;
      if (h < log2Size && lackOf[l] > 0u) {
        uint siblings = siblingCount(w, h);
        lackOf[parentIndex(w, h)] += (lackOf[l] + siblings - 1u) / siblings;
      }
    }
  for (uint w = log2Size; w > 0u; --w)
    for (uint below = 0u; below <= w; ++below) {
      uint h = w - below;
      uint l = levelIndex(w, h);
      if (h == log2Size || lackOf[l] == 0u) continue;
      uint parent = parentIndex(w, h);
      uint siblings = siblingCount(w, h);
      uint asked = atlas.levels[parent].requested;
      uint spare = freeOf[parent] > asked ? freeOf[parent] - asked : 0u;
      uint room = atlas.levels[l].stackCapacity - 1u - min(atlas.levels[l].existing, atlas.levels[l].stackCapacity - 1u);
      uint cuts = min(min((lackOf[l] + siblings - 1u) / siblings, spare), room / siblings);
      if (cuts == 0u) continue;
      cutting = true;
      cutsOf[l] = cuts;
      freeOf[parent] -= cuts;
      freeOf[l] += cuts * siblings;
    }
}

// Cuts blocks on the stacks, the largest first.
void cutBlocks() {
  uint me = gl_LocalInvocationIndex;
  if (me < kLevels) {
    freeOf[me] = uint(atlas.levels[me].stackCount);
    lackOf[me] = 0u;
    cutsOf[me] = 0u;
  }
  if (me == 0u) cutting = false;
  barrier();
  if (me == 0u) planCuts();
  barrier();
  if (!cutting) return;
  for (uint w = atlas.config.superblockLog2; w > 0u; --w)
    for (uint below = 0u; below <= w; ++below) {
      uint h = w - below;
      uint l = levelIndex(w, h);
      uint cuts = cutsOf[l];
      if (cuts == 0u) continue;
      uint parent = parentIndex(w, h);
      uint siblings = siblingCount(w, h);
      uint from = atlas.levels[parent].stackBase + uint(atlas.levels[parent].stackCount) - cuts;
      uint to = atlas.levels[l].stackBase + uint(atlas.levels[l].stackCount);
      for (uint i = me; i < cuts; i += gl_WorkGroupSize.x) {
        uint origin = stackEntries[from + i];
        for (uint s = 0u; s < siblings; ++s) stackEntries[to + siblings * i + s] = siblingOrigin(origin, s, w, h);
      }
      memoryBarrierBuffer();
      barrier();
      if (me == 0u) {
        atlas.levels[parent].stackCount -= int(cuts);
        atlas.levels[parent].existing -= cuts;
        atlas.levels[l].stackCount += int(cuts * siblings);
        atlas.levels[l].existing += cuts * siblings;
      }
      memoryBarrierBuffer();
      barrier();
    }
}

// Without stacks: a carried-over superblock that holds no live block is filled again from its start.
// There are no columns then either, so the bin is a level.
void restartIfEmpty(uint bin, uint texels) {
  BinState carried = atlas.bins[bin];
  if (carried.carrySuperblock == kNoSuperblock || superblockWords[liveWord(carried.carrySuperblock)] != 0u) return;
  atlas.levels[bin].existing -= carried.carryOffset;
  atlas.levels[bin].lost -= carried.carryOffset;
  atomicAdd(atlas.cutTexels, -(carried.carryOffset * texels));
  atlas.bins[bin].carryOffset = 0u;
}

// Fills the superblocks of one bin, whose blocks are of width w and of heights `bottom` to `top`.
void provision(uint bin, uint w, uint top, uint bottom, uint firstPopped, uint popped, bool full) {
  uint log2Size = atlas.config.superblockLog2;
  BinState columns = atlas.bins[bin];
  columns.sourceSuperblock = columns.carrySuperblock;
  columns.firstPopped = firstPopped;
  columns.popped = popped;
  if (popped > 0u) columns.carrySuperblock = superblockWords[firstPopped - (popped - 1u)];

  uint cut = 0u;
  uint largest = blocksPerSuperblock(log2Size, w, top);
  uint offset = columns.carryOffset;
  uint available = full ? 0u : (popped + 1u) * largest - offset;
  for (uint below = 0u; below <= top - bottom; ++below) {
    uint h = top - below;
    uint l = levelIndex(w, h);
    uint count = min(needOf(l), available);
    atlas.levels[l].slotOffset = offset;
    atlas.levels[l].slotCount = count;
    atlas.levels[l].existing += count;
    atlas.levels[l].lastRequested = atlas.levels[l].requested;
    cut += count << (w + h);
    offset = 2u * (offset + count);
    available = 2u * (available - count);
  }
  // Odd remainders at the end, smallest first, go on their stacks: the next frame starts at a square block. The
  // stacks may be pushed to only now that needOf has seen their counts.
  for (uint h = bottom; h < top; ++h) {
    uint l = levelIndex(w, h);
    atlas.levels[l].requested = 0u;
    offset = (offset + 1u) / 2u;
    if ((offset & 1u) == 0u) continue;
    uint index = offset & (blocksPerSuperblock(log2Size, w, h) - 1u);
    pushBlock(l, blockOrigin(atlas.config, columns.carrySuperblock, index, w, h));
    ++atlas.levels[l].existing;
    cut += 1u << (w + h);
  }
  atlas.levels[levelIndex(w, top)].requested = 0u;
  columns.carryOffset = (offset + 1u) / 2u - popped * largest;
  atlas.bins[bin] = columns;
  atomicAdd(atlas.cutTexels, cut);
}

void main() {
  if (atlas.config.merges != 0u) cutBlocks();
  uint bin = gl_LocalInvocationIndex;
  uint log2Size = atlas.config.superblockLog2;
  bool columns = atlas.config.columns != 0u;
  uint w = bin;
  if (!columns)
    for (w = 1u; w < log2Size && levelIndex(w + 1u, 0u) <= bin;) ++w;
  uint top = columns ? w : bin - levelIndex(w, 0u);
  uint bottom = columns ? 0u : top;
  bool mine = bin >= 1u && w <= log2Size && top <= w;
  bool full = mine && columns && stacksFull(w);
  if (mine && atlas.config.stacks == 0u) restartIfEmpty(bin, 1u << (w + top));

  // Rows of the lowest blocks, in columns of this width, that requests need beyond the rest of the carried-over
  // superblock.
  uint wanted = 0u;
  if (mine && !full) {
    int rows = int(atlas.bins[bin].carryOffset) - int(blocksPerSuperblock(log2Size, w, top));
    rows *= 1 << (top - bottom);
    for (uint h = bottom; h <= top; ++h) rows += int(needOf(levelIndex(w, h)) << (h - bottom));
    int perSuperblock = int(blocksPerSuperblock(log2Size, w, bottom));
    if (rows > 0) wanted = uint((rows + perSuperblock - 1) / perSuperblock);
  }
  wantedOf[bin] = wanted;
  uint free = atlas.superblocksFree;
  barrier();

  uint before = 0u;
  for (uint b = 1u; b < bin; ++b) before += wantedOf[b];
  uint popped = min(wanted, free - min(before, free));
  if (bin == gl_WorkGroupSize.x - 1u) {
    atlas.superblocksFree = free - min(before + wanted, free);
    atlas.visible = visibleCount;
    liveCount = visibleCount;
  }
  if (mine) provision(bin, w, top, bottom, free - 1u - before, popped, full);
}
