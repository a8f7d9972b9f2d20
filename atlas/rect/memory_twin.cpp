#include "atlas/rect/memory_twin.hpp"

#include <algorithm>
#include <tuple>

namespace tessera {

namespace {

enum Paint : std::uint8_t { kNothing, kLive, kStacked, kCarried, kFree };
const char* const kPaintNames[] = {"nothing", "a live block", "a stacked block", "a carried-over superblock",
                                   "a free superblock"};

class Painter {
 public:
  explicit Painter(const MemorySnapshot& snapshot)
      : snapshot_(snapshot), texels_(std::size_t{snapshot.width} * snapshot.height, kNothing) {}

  Result<void> paint(const AtlasBlock& block, Paint what) {
    if (block.x + (1u << block.w) > snapshot_.width || block.y + (1u << block.h) > snapshot_.height)
      return fail("{} at ({}, {}) of 2^{} x 2^{} texels leaves the atlas", kPaintNames[what], block.x,
                  block.y, block.w, block.h);
    for (std::uint32_t y = block.y; y < block.y + (1u << block.h); ++y)
      for (std::uint32_t x = block.x; x < block.x + (1u << block.w); ++x) {
        std::uint8_t& texel = texels_[std::size_t{y} * snapshot_.width + x];
        if (texel != kNothing)
          return fail("texel ({}, {}) is in {} and in {}", x, y, kPaintNames[texel], kPaintNames[what]);
        texel = what;
      }
    return {};
  }

  Result<void> full() const {
    const auto empty = static_cast<std::uint64_t>(std::count(texels_.begin(), texels_.end(), kNothing));
    if (empty == snapshot_.inaccessibleTexels) return {};
    const auto hole = std::find(texels_.begin(), texels_.end(), kNothing);
    if (hole == texels_.end() || snapshot_.inaccessibleTexels > 0)
      return fail("{} texels are in nothing, and {} inaccessible", empty, snapshot_.inaccessibleTexels);
    const auto at = static_cast<std::size_t>(hole - texels_.begin());
    return fail("texel ({}, {}) is in nothing", at % snapshot_.width, at / snapshot_.width);
  }

 private:
  const MemorySnapshot& snapshot_;
  std::vector<std::uint8_t> texels_;
};

}  // namespace

Result<void> checkPartition(const MemorySnapshot& snapshot) {
  Painter painter(snapshot);
  const std::uint32_t log2 = snapshot.superblockLog2;
  const std::uint32_t across = snapshot.width >> log2;
  for (const AtlasBlock& block : snapshot.live)
    if (auto painted = painter.paint(block, kLive); !painted) return painted;
  for (const AtlasBlock& block : snapshot.stacked)
    if (auto painted = painter.paint(block, kStacked); !painted) return painted;
  for (const std::uint32_t free : snapshot.freeSuperblocks)
    if (auto painted = painter.paint({(free % across) << log2, (free / across) << log2, log2, log2}, kFree);
        !painted)
      return painted;
  for (const MemorySnapshot::Carry& carry : snapshot.carried) {
    const std::uint32_t inColumn = 1u << (log2 - carry.h);
    for (std::uint32_t i = carry.used; i < inColumn << (log2 - carry.w); ++i) {
      const std::uint32_t x = ((carry.superblock % across) << log2) + ((i / inColumn) << carry.w);
      const std::uint32_t y = ((carry.superblock / across) << log2) + ((i % inColumn) << carry.h);
      if (auto painted = painter.paint({x, y, carry.w, carry.h}, kCarried); !painted) return painted;
    }
  }
  return painter.full();
}

MemoryTwin::MemoryTwin(std::uint32_t width, std::uint32_t height, std::uint32_t superblockLog2,
                       std::uint32_t patches, const TwinOptions& options)
    : width_(width), height_(height), superblockLog2_(superblockLog2), options_(options), blocks_(patches) {
  reset();
}

void MemoryTwin::reset() {
  levels_.assign(superblockLog2_ + 1, {});
  bins_.assign(superblockLog2_ + 1, {});
  for (std::uint32_t w = 1; w <= superblockLog2_; ++w) {
    levels_[w].resize(w + 1);
    bins_[w].resize(w + 1);
    // A full superblock that does not exist.
    for (std::uint32_t h = 0; h <= w; ++h) bins_[w][h].carryOffset = blocksPerSuperblock(w, h);
  }
  const std::uint32_t count = (width_ >> superblockLog2_) * (height_ >> superblockLog2_);
  superblocks_.clear();
  for (std::uint32_t i = count; i > 0; --i) superblocks_.push_back(i - 1);
  liveIn_.assign(count, 0);
  for (const std::uint32_t patch : holders_) blocks_[patch].reset();
  holders_.clear();
  pending_.clear();
  failures_ = 0;
}

std::uint32_t MemoryTwin::blocksPerSuperblock(std::uint32_t w, std::uint32_t h) const {
  return (1u << (superblockLog2_ - w)) * (1u << (superblockLog2_ - h));
}

AtlasBlock MemoryTwin::place(std::uint32_t superblock, std::uint32_t index, std::uint32_t w,
                             std::uint32_t h) const {
  const std::uint32_t size = 1u << superblockLog2_;
  const std::uint32_t across = width_ / size;
  const std::uint32_t inColumn = size >> h;
  return {superblock % across * size + index / inColumn * (1u << w),
          superblock / across * size + index % inColumn * (1u << h), w, h};
}

std::uint32_t MemoryTwin::superblockOf(const AtlasBlock& block) const {
  return (block.y >> superblockLog2_) * (width_ >> superblockLog2_) + (block.x >> superblockLog2_);
}

void MemoryTwin::giveBack(const AtlasBlock& block) {
  const std::uint32_t superblock = superblockOf(block);
  liveIn_[superblock] -= 1u << (block.w + block.h);
  if (options_.stacks)
    levels_[block.w][block.h].stack.push_back(block);
  else if (liveIn_[superblock] == 0 && bin(block.w, block.h).carrySuperblock != superblock)
    superblocks_.push_back(superblock);
}

void MemoryTwin::frame(std::span<const Want> visible) {
  if (options_.merge) mergeSiblings();
  request(visible);
  provision();
  assign();
}

void MemoryTwin::request(std::span<const Want> visible) {
  // What a patch wants this frame; 0 x 0 for the invisible, which so lose their blocks.
  std::vector<Want> wants(blocks_.size());
  for (const Want& want : visible) wants[want.patch] = want;
  std::vector<std::uint32_t> keep;
  for (const std::uint32_t patch : holders_) {
    const AtlasBlock& block = *blocks_[patch];
    if (wants[patch].w == block.w && wants[patch].h == block.h) {
      keep.push_back(patch);
      continue;
    }
    giveBack(block);
    blocks_[patch].reset();
  }
  holders_ = std::move(keep);
  pending_.clear();
  for (const Want& want : visible)
    if (want.w > 0 && !blocks_[want.patch]) pending_.push_back({want, levels_[want.w][want.h].requested++});
}

void MemoryTwin::mergeSiblings() {
  for (std::uint32_t h = 0; h <= superblockLog2_; ++h)
    for (std::uint32_t w = std::max(h, 1u); w <= superblockLog2_; ++w) {
      const bool square = w == h;
      const std::uint32_t needed = square ? 4 : 2;
      const std::uint32_t acrossMask = square ? (2u << w) - 1 : (1u << w) - 1;
      const std::uint32_t downMask = (2u << h) - 1;
      std::vector<AtlasBlock>& stack = levels_[w][h].stack;
      if (w == superblockLog2_ && square) {
        for (const AtlasBlock& block : stack) superblocks_.push_back(superblockOf(block));
        stack.clear();
        continue;
      }
      const auto family = [&](const AtlasBlock& block) {
        return std::pair(block.y & ~downMask, block.x & ~acrossMask);
      };
      std::sort(stack.begin(), stack.end(), [&](const AtlasBlock& a, const AtlasBlock& b) {
        return std::tuple(family(a), a.y, a.x) < std::tuple(family(b), b.y, b.x);
      });
      std::vector<AtlasBlock> kept;
      for (std::size_t first = 0; first < stack.size();) {
        std::size_t last = first;
        while (last < stack.size() && family(stack[last]) == family(stack[first])) ++last;
        const auto [y, x] = family(stack[first]);
        if (last - first == needed)
          levels_[square ? w + 1 : w][h + 1].stack.push_back({x, y, square ? w + 1 : w, h + 1});
        else
          kept.insert(kept.end(), stack.begin() + static_cast<std::ptrdiff_t>(first),
                      stack.begin() + static_cast<std::ptrdiff_t>(last));
        first = last;
      }
      stack = std::move(kept);
    }
}

// Gets one more free block of a level by cutting a larger one that nobody asks for; false if there is none.
bool MemoryTwin::cutFor(std::uint32_t w, std::uint32_t h) {
  if (h == superblockLog2_) return false;
  const bool square = w == h;
  const std::uint32_t pw = square ? w + 1 : w;
  Level& parent = levels_[pw][h + 1];
  if (parent.stack.size() <= parent.requested && !cutFor(pw, h + 1)) return false;
  const AtlasBlock whole = parent.stack.back();
  parent.stack.pop_back();
  for (std::uint32_t i = 0; i < (square ? 4u : 2u); ++i)
    levels_[w][h].stack.push_back(square ? AtlasBlock{whole.x + (i % 2 << w), whole.y + (i / 2 << h), w, h}
                                         : AtlasBlock{whole.x, whole.y + (i << h), w, h});
  return true;
}

void MemoryTwin::cutBlocks() {
  for (std::uint32_t w = superblockLog2_; w > 0; --w)
    for (std::uint32_t h = w + 1; h-- > 0;)
      while (levels_[w][h].stack.size() < levels_[w][h].requested && cutFor(w, h)) {
      }
}

void MemoryTwin::restartEmpty() {
  for (std::vector<Bin>& row : bins_)
    for (Bin& bin : row)
      if (bin.carrySuperblock && liveIn_[*bin.carrySuperblock] == 0) bin.carryOffset = 0;
}

void MemoryTwin::provision() {
  if (options_.merge) cutBlocks();
  if (!options_.stacks) restartEmpty();
  for (std::uint32_t w = 1; w <= superblockLog2_; ++w) {
    if (options_.columns) {
      provisionBin(w, w, 0);
      continue;
    }
    for (std::uint32_t h = 0; h <= w; ++h) provisionBin(w, h, h);
  }
}

void MemoryTwin::provisionBin(std::uint32_t w, std::uint32_t top, std::uint32_t bottom) {
  Bin& filled = bin(w, top);
  const auto largest = static_cast<std::int64_t>(blocksPerSuperblock(w, top));
  const auto need = [&](std::uint32_t h) {
    const Level& level = levels_[w][h];
    return std::max<std::int64_t>(
        0, static_cast<std::int64_t>(level.requested) - static_cast<std::int64_t>(level.stack.size()));
  };
  std::int64_t rows = (static_cast<std::int64_t>(filled.carryOffset) - largest) * (1 << top);
  for (std::uint32_t h = bottom; h <= top; ++h) rows += need(h) * (1 << h);

  filled.list.assign(1, filled.carrySuperblock);
  const auto rowsEach = largest * (1 << top);
  for (; rows > 0 && !superblocks_.empty(); rows -= rowsEach) {
    filled.list.emplace_back(superblocks_.back());
    superblocks_.pop_back();
  }

  std::int64_t offset = filled.carryOffset;
  std::int64_t available = static_cast<std::int64_t>(filled.list.size()) * largest - offset;
  for (std::uint32_t h = top + 1; h-- > bottom;) {
    Level& level = levels_[w][h];
    const std::int64_t count = std::min(need(h), available);
    level.slotOffset = static_cast<std::uint32_t>(offset);
    level.slotCount = static_cast<std::uint32_t>(count);
    level.requested = 0;
    offset = 2 * (offset + count);
    available = 2 * (available - count);
  }
  for (std::uint32_t h = bottom; h < top; ++h) {
    offset = (offset + 1) / 2;
    if (offset % 2 == 0) continue;
    const auto index = static_cast<std::uint32_t>(offset % blocksPerSuperblock(w, h));
    levels_[w][h].stack.push_back(place(*filled.list.back(), index, w, h));
  }
  offset = (offset + 1) / 2;
  filled.carryOffset =
      static_cast<std::uint32_t>(offset - static_cast<std::int64_t>(filled.list.size() - 1) * largest);
  filled.carrySuperblock = filled.list.back();
}

void MemoryTwin::assign() {
  failures_ = 0;
  for (const Pending& pending : pending_) {
    const auto [patch, w, h] = pending.want;
    Level& level = levels_[w][h];
    std::optional<AtlasBlock>& block = blocks_[patch];
    if (pending.slot < level.slotCount) {
      const std::uint32_t s = pending.slot + level.slotOffset;
      const std::uint32_t i = s / blocksPerSuperblock(w, h);
      block = place(*bin(w, h).list[i], s - i * blocksPerSuperblock(w, h), w, h);
    } else if (!level.stack.empty()) {
      block = level.stack.back();
      level.stack.pop_back();
    } else {
      ++failures_;
      continue;
    }
    liveIn_[superblockOf(*block)] += 1u << (w + h);
    holders_.push_back(patch);
  }
}

MemorySnapshot MemoryTwin::snapshot() const {
  MemorySnapshot snapshot{width_, height_, superblockLog2_, {}, {}, {}, superblocks_, 0};
  std::uint64_t known = std::uint64_t{superblocks_.size()} << (2 * superblockLog2_);
  for (const std::uint32_t patch : holders_) {
    snapshot.live.push_back(*blocks_[patch]);
    known += 1u << (blocks_[patch]->w + blocks_[patch]->h);
  }
  for (std::uint32_t w = 1; w <= superblockLog2_; ++w) {
    for (const Level& level : levels_[w])
      snapshot.stacked.insert(snapshot.stacked.end(), level.stack.begin(), level.stack.end());
    for (std::uint32_t h = options_.columns ? w : 0; h <= w; ++h) {
      const Bin& bin = bins_[w][h];
      if (!bin.carrySuperblock) continue;
      snapshot.carried.push_back({w, h, *bin.carrySuperblock, bin.carryOffset});
      known += std::uint64_t{blocksPerSuperblock(w, h) - bin.carryOffset} << (w + h);
    }
  }
  if (!options_.stacks) snapshot.inaccessibleTexels = std::uint64_t{width_} * height_ - known;
  return snapshot;
}

}  // namespace tessera
