// The memory of the rectangular atlas on the CPU, one thread: what the GPU passes are checked against.
// Based on Mueller 2021, sec. 3.4, Alg. 1-3. Written for clearness, and without the code of the shaders.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/core/result.hpp"

namespace tessera {

/// A rectangle of 2^w x 2^h texels with its top left corner at (x, y).
struct AtlasBlock {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t w = 0;  // log2
  std::uint32_t h = 0;  // log2
  bool operator==(const AtlasBlock&) const = default;
};

/// All memory of an atlas at one moment.
struct MemorySnapshot {
  std::uint32_t width = 0;   // texels, a multiple of the superblock
  std::uint32_t height = 0;  // texels, a multiple of the superblock
  std::uint32_t superblockLog2 = 0;
  std::vector<AtlasBlock> live;
  std::vector<AtlasBlock> stacked;
  struct Carry {
    std::uint32_t w = 0;  // log2 size of the blocks that it is counted in: squares where there are columns
    std::uint32_t h = 0;
    std::uint32_t superblock = 0;  // number, row by row
    std::uint32_t used = 0;        // of those blocks
  };
  std::vector<Carry> carried;
  std::vector<std::uint32_t> freeSuperblocks;
  std::uint64_t inaccessibleTexels = 0;  // freed, but on no stack
};

/// Paints every texel and fails, naming the first texel that is wrong, unless each one is in exactly one of:
/// a live block, a stacked block, the unused rest of a carried-over superblock, a free superblock; as many
/// texels as are inaccessible are in none of them. So no two overlap.
Result<void> checkPartition(const MemorySnapshot& snapshot);

/// Which parts of the memory's hierarchy are in use; see AtlasStrategy in atlas/rect/memory.hpp. A reset is
/// for the caller to make.
struct TwinOptions {
  bool columns = true;
  bool stacks = true;
  bool merge =
      false;  // needs both: after each frame siblings of all heights are merged, before it blocks are cut
};

class MemoryTwin {
 public:
  struct Level {
    std::vector<AtlasBlock> stack;
    std::uint32_t requested = 0;
    std::uint32_t slotOffset = 0;
    std::uint32_t slotCount = 0;
  };
  /// What fills superblocks one after the other: a width, or a level where there are no columns.
  struct Bin {
    std::uint32_t carryOffset = 0;                 // largest blocks used in the carried-over superblock
    std::optional<std::uint32_t> carrySuperblock;  // none before the first
    std::vector<std::optional<std::uint32_t>>
        list;  // sb[w]: the carried-over one, then those popped this frame
  };
  /// What a visible patch asks for: w = 0 is a single texel, which takes no memory.
  struct Want {
    std::uint32_t patch = 0;
    std::uint32_t w = 0;
    std::uint32_t h = 0;
  };

  /// `width` and `height` in texels, multiples of 2^superblockLog2; superblockLog2 >= 1.
  MemoryTwin(std::uint32_t width, std::uint32_t height, std::uint32_t superblockLog2, std::uint32_t patches,
             const TwinOptions& options = {});

  /// One frame: request, provision, assign for the visible patches, each named at most once.
  void frame(std::span<const Want> visible);
  /// Frees everything.
  void reset();

  void request(std::span<const Want> visible);
  void provision();
  void assign();

  /// The patch's block, or none: not visible, a single texel, or out of memory.
  [[nodiscard]] const std::optional<AtlasBlock>& blockOf(std::uint32_t patch) const { return blocks_[patch]; }
  [[nodiscard]] std::uint32_t failures() const { return failures_; }
  [[nodiscard]] Level& level(std::uint32_t w, std::uint32_t h) { return levels_[w][h]; }
  /// The bin that blocks of a level are cut from.
  [[nodiscard]] Bin& bin(std::uint32_t w, std::uint32_t h) { return bins_[w][options_.columns ? w : h]; }
  [[nodiscard]] std::vector<std::uint32_t>& superblockStack() { return superblocks_; }
  [[nodiscard]] std::uint32_t blocksPerSuperblock(std::uint32_t w, std::uint32_t h) const;
  [[nodiscard]] MemorySnapshot snapshot() const;

 private:
  [[nodiscard]] AtlasBlock place(std::uint32_t superblock, std::uint32_t index, std::uint32_t w,
                                 std::uint32_t h) const;
  [[nodiscard]] std::uint32_t superblockOf(const AtlasBlock& block) const;
  void giveBack(const AtlasBlock& block);
  void provisionBin(std::uint32_t w, std::uint32_t top, std::uint32_t bottom);
  void restartEmpty();
  bool cutFor(std::uint32_t w, std::uint32_t h);
  void cutBlocks();
  void mergeSiblings();
  struct Pending {
    Want want;
    std::uint32_t slot = 0;
  };
  std::uint32_t width_;
  std::uint32_t height_;
  std::uint32_t superblockLog2_;
  TwinOptions options_;
  std::vector<std::vector<Level>> levels_;  // [w][h]
  std::vector<std::vector<Bin>> bins_;      // [w][h]
  std::vector<std::uint32_t> superblocks_;  // free ones, the next to be taken last
  std::vector<std::uint32_t> liveIn_;       // texels of live blocks, a superblock
  std::vector<std::optional<AtlasBlock>> blocks_;
  std::vector<std::uint32_t> holders_;  // patches with a block
  std::vector<Pending> pending_;
  std::uint32_t failures_ = 0;
};

}  // namespace tessera
