#include "atlas/rect/quadtree.hpp"

#include <algorithm>
#include <bit>
#include <cassert>

namespace tessera {

namespace {

constexpr std::uint32_t kNoCell = 0xffffffffu;
constexpr std::uint8_t kNothing = 0;  // no block starts here
constexpr std::uint8_t kUsed = 0x80;  // flag of a block that was given out

/// Of a free block.
std::uint8_t tagOf(std::uint32_t w, std::uint32_t h) {
  static_assert(glsl::kLevels < kUsed);
  return static_cast<std::uint8_t>(glsl::levelIndex(w, h) + 1);
}

}  // namespace

QuadtreeAllocator::QuadtreeAllocator(std::uint32_t width, std::uint32_t height, std::uint32_t rootLog2)
    : width_(width),
      height_(height),
      rootLog2_(rootLog2),
      tags_(std::size_t{width} * height / 2),
      links_(tags_.size()) {
  assert(rootLog2 >= 1 && rootLog2 <= glsl::kMaxBlockLog2);
  assert(width % (1u << rootLog2) == 0 && height % (1u << rootLog2) == 0);
  reset();
}

void QuadtreeAllocator::reset() {
  std::fill(tags_.begin(), tags_.end(), kNothing);
  heads_.fill(kNoCell);
  rows_.fill(0);
  squares_ = 0;
  live_ = 0;
  freeRoots_ = 0;
  const std::uint32_t size = 1u << rootLog2_;
  // Lists are last in, first out: the first root is taken first.
  for (std::uint32_t y = height_; y > 0; y -= size)
    for (std::uint32_t x = width_; x > 0; x -= size) push(x - size, y - size, rootLog2_, rootLog2_);
}

void QuadtreeAllocator::push(std::uint32_t x, std::uint32_t y, std::uint32_t w, std::uint32_t h) {
  const std::uint32_t cell = cellOf(x, y);
  std::uint32_t& head = heads_[glsl::levelIndex(w, h)];
  links_[cell] = {head, kNoCell};
  if (head != kNoCell) links_[head].previous = cell;
  head = cell;
  tags_[cell] = tagOf(w, h);
  rows_[w] |= 1u << h;
  if (w == h) squares_ |= 1u << w;
  if (h == rootLog2_) ++freeRoots_;
}

void QuadtreeAllocator::remove(std::uint32_t cell, std::uint32_t w, std::uint32_t h) {
  const Link link = links_[cell];
  std::uint32_t& head = heads_[glsl::levelIndex(w, h)];
  if (link.previous == kNoCell)
    head = link.next;
  else
    links_[link.previous].next = link.next;
  if (link.next != kNoCell) links_[link.next].previous = link.previous;
  tags_[cell] = kNothing;
  if (h == rootLog2_) --freeRoots_;
  if (head != kNoCell) return;
  rows_[w] &= ~(1u << h);
  if (w == h) squares_ &= ~(1u << w);
}

std::optional<AtlasBlock> QuadtreeAllocator::allocate(std::uint32_t w, std::uint32_t h) {
  assert(w >= 1 && w <= rootLog2_ && h <= w);
  std::uint32_t fromW = w;
  std::uint32_t fromH = 0;
  if (const std::uint32_t rows = rows_[w] >> h << h; rows != 0) {
    fromH = static_cast<std::uint32_t>(std::countr_zero(rows));
  } else {
    const std::uint32_t squares = squares_ >> (w + 1) << (w + 1);
    if (squares == 0) return std::nullopt;
    fromW = fromH = static_cast<std::uint32_t>(std::countr_zero(squares));
  }
  const std::uint32_t cell = heads_[glsl::levelIndex(fromW, fromH)];
  remove(cell, fromW, fromH);
  const std::uint32_t x = cell % (width_ / 2) * 2;
  const std::uint32_t y = cell / (width_ / 2);
  while (fromW > w) {
    const std::uint32_t half = 1u << --fromW;
    fromH = fromW;
    push(x + half, y + half, fromW, fromW);
    push(x, y + half, fromW, fromW);
    push(x + half, y, fromW, fromW);
  }
  while (fromH > h) {
    --fromH;
    push(x, y + (1u << fromH), w, fromH);
  }
  tags_[cell] = tagOf(w, h) | kUsed;
  live_ += std::uint64_t{1} << (w + h);
  return AtlasBlock{x, y, w, h};
}

void QuadtreeAllocator::release(const AtlasBlock& block) {
  auto [x, y, w, h] = block;
  assert(tags_[cellOf(x, y)] == (tagOf(w, h) | kUsed));
  live_ -= std::uint64_t{1} << (w + h);
  tags_[cellOf(x, y)] = kNothing;
  while (h < w && isFree(x, y ^ (1u << h), tagOf(w, h))) {
    remove(cellOf(x, y ^ (1u << h)), w, h);
    y &= ~(1u << h);
    ++h;
  }
  while (h == w && w < rootLog2_) {
    const std::uint32_t half = 1u << w;
    const std::uint8_t tag = tagOf(w, w);
    if (!isFree(x ^ half, y, tag) || !isFree(x, y ^ half, tag) || !isFree(x ^ half, y ^ half, tag)) break;
    remove(cellOf(x ^ half, y), w, w);
    remove(cellOf(x, y ^ half), w, w);
    remove(cellOf(x ^ half, y ^ half), w, w);
    x &= ~half;
    y &= ~half;
    ++w;
    ++h;
  }
  push(x, y, w, h);
}

std::uint64_t QuadtreeAllocator::rootTexels() const { return std::uint64_t{freeRoots_} << (2 * rootLog2_); }

MemorySnapshot QuadtreeAllocator::snapshot() const {
  MemorySnapshot snapshot;
  snapshot.width = width_;
  snapshot.height = height_;
  snapshot.superblockLog2 = rootLog2_;
  for (std::uint32_t cell = 0; cell < tags_.size(); ++cell) {
    if (tags_[cell] == kNothing) continue;
    const std::uint32_t x = cell % (width_ / 2) * 2;
    const std::uint32_t y = cell / (width_ / 2);
    const auto level = static_cast<std::uint32_t>(tags_[cell] & ~kUsed) - 1;
    std::uint32_t w = 0;
    while (glsl::levelIndex(w + 1, 0) <= level) ++w;
    const std::uint32_t h = level - glsl::levelIndex(w, 0);
    if ((tags_[cell] & kUsed) != 0)
      snapshot.live.push_back({x, y, w, h});
    else if (h == rootLog2_)
      snapshot.freeSuperblocks.push_back((y >> rootLog2_) * (width_ >> rootLog2_) + (x >> rootLog2_));
    else
      snapshot.stacked.push_back({x, y, w, h});
  }
  return snapshot;
}

}  // namespace tessera
