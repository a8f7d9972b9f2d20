// Provisioning phase: a thread a block width. Says how many requests of each level come from newly cut superblocks, and
// where those start. Mueller 2021, Alg. 2, but for what is wrong as printed: line 4 adds to r, all loops over heights
// begin at one texel, and the carried offset counts from the start of the last superblock.
// Superblocks go to the widths in rising order, so that the outcome does not depend on the order of threads.
#include "lib/rect_state.glsl"

layout(local_size_x = 16) in;

shared uint wantedOf[16];

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

void main() {
  uint w = gl_LocalInvocationIndex;
  uint log2Size = atlas.config.superblockLog2;
  bool mine = w >= 1u && w <= log2Size;
  bool full = mine && stacksFull(w);

  // Rows of texels, in columns of this width, that requests need beyond the rest of the carried-over superblock.
  uint wanted = 0u;
  if (mine && !full) {
    int rows = int(atlas.widths[w].carryOffset) - int(blocksPerSuperblock(log2Size, w, w));
    rows *= 1 << w;
    for (uint h = 0u; h <= w; ++h) rows += int(needOf(levelIndex(w, h)) << h);
    int perSuperblock = int(blocksPerSuperblock(log2Size, w, 0u));
    if (rows > 0) wanted = uint((rows + perSuperblock - 1) / perSuperblock);
  }
  wantedOf[w] = wanted;
  uint used = atlas.superblocksUsed;
  barrier();

  uint before = used;
  for (uint v = 1u; v < w; ++v) before += wantedOf[v];
  uint popped = before >= atlas.config.superblocks ? 0u : min(wanted, atlas.config.superblocks - before);
  if (w == log2Size) {
    atlas.superblocksUsed = min(before + wanted, atlas.config.superblocks);
    atlas.visible = visibleCount;
    liveCount = visibleCount;
  }
  if (!mine) return;

  WidthState columns = atlas.widths[w];
  columns.sourceSuperblock = columns.carrySuperblock;
  columns.firstPopped = before;
  columns.popped = popped;
  if (popped > 0u) columns.carrySuperblock = before + popped - 1u;

  uint cut = 0u;
  uint square = blocksPerSuperblock(log2Size, w, w);
  uint offset = columns.carryOffset;
  uint available = full ? 0u : (popped + 1u) * square - offset;
  for (uint below = 0u; below <= w; ++below) {
    uint h = w - below;
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
  for (uint h = 0u; h < w; ++h) {
    uint l = levelIndex(w, h);
    atlas.levels[l].requested = 0u;
    offset = (offset + 1u) / 2u;
    if ((offset & 1u) == 0u) continue;
    uint index = offset & (blocksPerSuperblock(log2Size, w, h) - 1u);
    pushBlock(packLevel(w, h, false), blockOrigin(atlas.config, columns.carrySuperblock, index, w, h));
    ++atlas.levels[l].existing;
    cut += 1u << (w + h);
  }
  atlas.levels[levelIndex(w, w)].requested = 0u;
  columns.carryOffset = (offset + 1u) / 2u - popped * square;
  atlas.widths[w] = columns;
  atomicAdd(atlas.cutTexels, cut);
}
