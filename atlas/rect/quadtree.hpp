// Blocks of one atlas from a quadtree, on one CPU thread: the baseline that the parallel memory is compared
// with (Mueller 2021, sec. 3.6.2). A buddy system: squares split into four squares, or into two halves by
// rows, and halves again down to one row; what is free together with all of its siblings merges at once.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "atlas/rect/memory_twin.hpp"
#include "glsl/shared/rect_memory.h"

namespace tessera {

class QuadtreeAllocator {
 public:
  /// `width` and `height` in texels, multiples of 2^rootLog2; rootLog2 from 1 to kMaxBlockLog2 is the largest
  /// block.
  QuadtreeAllocator(std::uint32_t width, std::uint32_t height, std::uint32_t rootLog2);

  /// A block of 2^w x 2^h texels, 1 <= w <= rootLog2, h <= w, from the smallest free one that serves; none
  /// when there is none. Constant time, and no memory is taken.
  std::optional<AtlasBlock> allocate(std::uint32_t w, std::uint32_t h);
  /// Gives back what allocate() returned.
  void release(const AtlasBlock& block);
  /// Frees everything.
  void reset();

  [[nodiscard]] std::uint64_t liveTexels() const { return live_; }
  /// Of the free texels, those of whole roots.
  [[nodiscard]] std::uint64_t rootTexels() const;
  /// Free blocks below the roots count as stacked, free roots as free superblocks.
  [[nodiscard]] MemorySnapshot snapshot() const;

 private:
  /// A free block, kept where its first pair of texels is: no other block starts there.
  struct Link {
    std::uint32_t next = 0;
    std::uint32_t previous = 0;
  };
  [[nodiscard]] std::uint32_t cellOf(std::uint32_t x, std::uint32_t y) const { return (y * width_ + x) / 2; }
  [[nodiscard]] bool isFree(std::uint32_t x, std::uint32_t y, std::uint8_t tag) const {
    return tags_[cellOf(x, y)] == tag;
  }
  void push(std::uint32_t x, std::uint32_t y, std::uint32_t w, std::uint32_t h);
  void remove(std::uint32_t cell, std::uint32_t w, std::uint32_t h);

  std::uint32_t width_;
  std::uint32_t height_;
  std::uint32_t rootLog2_;
  std::uint64_t live_ = 0;
  std::uint32_t freeRoots_ = 0;
  std::vector<std::uint8_t> tags_;  // what starts at each pair of texels: see tagOf in quadtree.cpp
  std::vector<Link> links_;
  std::array<std::uint32_t, glsl::kLevels> heads_{};           // first free block of each level
  std::array<std::uint32_t, glsl::kMaxBlockLog2 + 1> rows_{};  // bit h: there are free blocks of (w, h)
  std::uint32_t squares_ = 0;                                  // bit w: of (w, w)
};

}  // namespace tessera
