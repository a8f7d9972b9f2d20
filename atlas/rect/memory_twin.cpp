#include "atlas/rect/memory_twin.hpp"

#include <algorithm>

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
    const auto hole = std::find(texels_.begin(), texels_.end(), kNothing);
    if (hole == texels_.end()) return {};
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
    const std::uint32_t perColumn = 1u << (log2 - carry.w);
    for (std::uint32_t i = carry.used; i < perColumn * perColumn; ++i) {
      const std::uint32_t x = ((carry.superblock % across) << log2) + ((i / perColumn) << carry.w);
      const std::uint32_t y = ((carry.superblock / across) << log2) + ((i % perColumn) << carry.w);
      if (auto painted = painter.paint({x, y, carry.w, carry.w}, kCarried); !painted) return painted;
    }
  }
  return painter.full();
}

MemoryTwin::MemoryTwin(std::uint32_t width, std::uint32_t height, std::uint32_t superblockLog2,
                       std::uint32_t patches)
    : width_(width), height_(height), superblockLog2_(superblockLog2), blocks_(patches) {
  reset();
}

void MemoryTwin::reset() {
  levels_.assign(superblockLog2_ + 1, {});
  columns_.assign(superblockLog2_ + 1, {});
  for (std::uint32_t w = 1; w <= superblockLog2_; ++w) {
    levels_[w].resize(w + 1);
    columns_[w].carryOffset = blocksPerSuperblock(w, w);  // a full superblock that does not exist
  }
  const std::uint32_t count = (width_ >> superblockLog2_) * (height_ >> superblockLog2_);
  superblocks_.clear();
  for (std::uint32_t i = count; i > 0; --i) superblocks_.push_back(i - 1);
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

void MemoryTwin::frame(std::span<const Want> visible) {
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
    levels_[block.w][block.h].stack.push_back(block);
    blocks_[patch].reset();
  }
  holders_ = std::move(keep);
  pending_.clear();
  for (const Want& want : visible)
    if (want.w > 0 && !blocks_[want.patch]) pending_.push_back({want, levels_[want.w][want.h].requested++});
}

void MemoryTwin::provision() {
  for (std::uint32_t w = 1; w <= superblockLog2_; ++w) {
    Column& column = columns_[w];
    const auto square = static_cast<std::int64_t>(blocksPerSuperblock(w, w));
    const auto need = [&](std::uint32_t h) {
      const Level& level = levels_[w][h];
      return std::max<std::int64_t>(
          0, static_cast<std::int64_t>(level.requested) - static_cast<std::int64_t>(level.stack.size()));
    };
    std::int64_t rows = (static_cast<std::int64_t>(column.carryOffset) - square) * (1 << w);
    for (std::uint32_t h = 0; h <= w; ++h) rows += need(h) * (1 << h);

    column.list.assign(1, column.carrySuperblock);
    const auto rowsEach = static_cast<std::int64_t>(blocksPerSuperblock(w, 0));
    for (; rows > 0 && !superblocks_.empty(); rows -= rowsEach) {
      column.list.emplace_back(superblocks_.back());
      superblocks_.pop_back();
    }

    std::int64_t offset = column.carryOffset;
    std::int64_t available = static_cast<std::int64_t>(column.list.size()) * square - offset;
    for (std::uint32_t h = w + 1; h-- > 0;) {
      Level& level = levels_[w][h];
      const std::int64_t count = std::min(need(h), available);
      level.slotOffset = static_cast<std::uint32_t>(offset);
      level.slotCount = static_cast<std::uint32_t>(count);
      level.requested = 0;
      offset = 2 * (offset + count);
      available = 2 * (available - count);
    }
    for (std::uint32_t h = 0; h < w; ++h) {
      offset = (offset + 1) / 2;
      if (offset % 2 == 0) continue;
      const auto index = static_cast<std::uint32_t>(offset % blocksPerSuperblock(w, h));
      levels_[w][h].stack.push_back(place(*column.list.back(), index, w, h));
    }
    offset = (offset + 1) / 2;
    column.carryOffset =
        static_cast<std::uint32_t>(offset - static_cast<std::int64_t>(column.list.size() - 1) * square);
    column.carrySuperblock = column.list.back();
  }
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
      block = place(*columns_[w].list[i], s - i * blocksPerSuperblock(w, h), w, h);
    } else if (!level.stack.empty()) {
      block = level.stack.back();
      level.stack.pop_back();
    } else {
      ++failures_;
      continue;
    }
    holders_.push_back(patch);
  }
}

MemorySnapshot MemoryTwin::snapshot() const {
  MemorySnapshot snapshot{width_, height_, superblockLog2_, {}, {}, {}, superblocks_};
  for (const std::uint32_t patch : holders_) snapshot.live.push_back(*blocks_[patch]);
  for (std::uint32_t w = 1; w <= superblockLog2_; ++w) {
    for (const Level& level : levels_[w])
      snapshot.stacked.insert(snapshot.stacked.end(), level.stack.begin(), level.stack.end());
    if (columns_[w].carrySuperblock)
      snapshot.carried.push_back({w, *columns_[w].carrySuperblock, columns_[w].carryOffset});
  }
  return snapshot;
}

}  // namespace tessera
