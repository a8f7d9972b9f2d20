// The geometry message: its layout, and the models that its two ends keep alike.
//
// A message is one range-coded string (range_coder.hpp). In order:
//   head     counts: objects, fresh elements, moved places, changed vertices, freed and hidden elements
//   objects  of each: number, 12 doubles, column by column, plain
//   moved    of each element that has another place, or is shown again: number, place
//   fresh    of each element: whether it is a piece
//              of a piece: its triangle's number, as a step from the last one's
//              else: style (same as the last one's or not), triangles, mirrored, and its corners, each
//                new     a vertex that was never sent: object (same or not), level, steps from where it is
//                        expected, and in masked elements mask coordinates
//                recent  its place in a list of the vertices used last
//                else    its number, as a step from the last one so given
//            then its place
//   changed  of each vertex: number, level, steps from where it was
//   freed    of each element: number
//   hidden   of each element: number
//   end      kEndMark, plain
// Numbers rise within a part, and are given as steps. A place is
//   of a patch     its level, same as before or not; its block's x and y in units of the block, as steps
//                  from those of the last block of this level
//   of a triangle  kind, level or sizes, each compared with what was before; x, y and turn of each slot, as
//                  steps from the last slot of its stock
// where before is the element's own last place, or for a fresh one the last element's.
//
// Numbers of fresh elements, triangles and vertices are not sent: both ends take them from a SlotPool, an
// element's before its triangles' and those before its vertices'. A vertex is freed with its last element.
// Moved comes before fresh, for a triangle that is split from this frame on is moved; freed is last, so that
// what fresh elements share stays.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "codec/wire/geometry.hpp"
#include "codec/wire/range_coder.hpp"
#include "glsl/shared/oversample.h"
#include "glsl/shared/tess_atlas.h"

namespace tessera::wire {

inline constexpr std::uint32_t kEndMark = 0x5a;
inline constexpr int kEndBits = 8;

/// The vertices used last, most recent first.
class RecentVertices {
 public:
  static constexpr int kBits = 6;
  static constexpr std::uint32_t kNotFound = 1u << kBits;
  RecentVertices() { entries_.fill(kNone); }
  [[nodiscard]] std::uint32_t find(std::uint32_t vertex) const {
    const auto found = std::find(entries_.begin(), entries_.end(), vertex);
    return static_cast<std::uint32_t>(found - entries_.begin());
  }
  [[nodiscard]] std::uint32_t at(std::uint32_t place) const { return entries_[place]; }
  /// To the front, from its place or, if it has none (kNotFound), in place of the oldest.
  void use(std::uint32_t vertex, std::uint32_t place) {
    const std::size_t from = std::min<std::size_t>(place, entries_.size() - 1);
    std::copy_backward(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(from),
                       entries_.begin() + static_cast<std::ptrdiff_t>(from) + 1);
    entries_[0] = vertex;
  }

 private:
  std::array<std::uint32_t, std::size_t{1} << kBits> entries_{};
};

/// Of a patch's level word: sizes and whether it is transposed. The bits above are the server's own.
inline constexpr int kRectLevelBits = 9;

/// Sizes of blocks by their class: 0, 1, and 1 more than a number of steps of overClass() in
/// glsl/shared/oversample.h.
inline constexpr int kSizeClassBits = 7;
inline std::uint32_t sizeClass(std::uint32_t size) { return size < 2 ? size : 2 + glsl::overClass(size - 1); }
inline std::uint32_t sizeOfClass(std::uint32_t number) {
  return number < 2 ? number : 1 + glsl::overClassSteps(number - 2);
}

/// Triangles that get their slots from one stock: places in it follow each other.
struct TessStock {
  std::uint32_t number;   // below kTessStocks
  std::uint32_t context;  // below kTessStockContexts: of about that size
};
inline constexpr std::uint32_t kTessStocks = 256u + (1u << (2 * kSizeClassBits));
inline constexpr std::uint32_t kTessStockContexts = 81;
inline TessStock stockOfLevel(std::uint32_t level) {
  return {level, level == 0 ? 0 : 1 + std::min(level / 4, 15u)};
}
inline TessStock stockOfBlock(std::uint32_t columns, std::uint32_t rows) {
  const std::uint32_t across = sizeClass(columns);
  return {256 + (across << kSizeClassBits | sizeClass(rows)), 17 + across / 2};
}

/// Of triangles' places. Each pair is of fresh ones and of those that had a place.
struct TessModels {
  std::array<std::array<SymbolModel<2>, 4>, 2> kind;  // by the kind before
  SymbolModel<8> level;
  SignedModel levelStep;
  std::array<BitModel, 2> sameShape;
  struct Size {
    BitModel regular;
    std::array<SymbolModel<kSizeClassBits>, 32> number;  // by a size that is known
    SignedModel step;
  };
  std::array<Size, 3> sizes;  // columns of half 0, of half 1, rows
  SymbolModel<2> apex;
  BitModel sameApex;
  std::array<SignedModel, 2> foot;
  BitModel split;
  SignedModel pieceSize;
  SignedModel pieceStep;
  std::array<BitModel, 2> keptPlace;
  std::array<BitModel, 2> turned;  // by that of the last
  std::array<std::array<std::array<SignedModel, 2>, kTessStockContexts>, 2>
      step;  // by axis, stock, turned as the last
  std::vector<std::uint32_t> place = std::vector<std::uint32_t>(kTessStocks, 0);  // the last of each stock
};

/// Everything that both ends remember from message to message.
struct GeometryModels {
  std::array<NumberModel, 6> counts;
  NumberModel objectGap;

  BitModel sameStyle;
  SymbolModel<2> triangles;
  BitModel mirrored;
  BitModel piece;
  SignedModel parentStep;
  struct Corner {
    std::array<BitModel, 4> fresh;  // by whether the corners before were
    BitModel recent;
    SymbolModel<RecentVertices::kBits> place;
    SignedModel step;
  };
  std::array<Corner, 5> corners;
  BitModel sameObject;
  SignedModel level;
  std::array<std::array<std::array<SignedModel, 4>, 3>, 5> steps;  // by corner, axis, size of the axes before
  std::array<SignedModel, 2> mask;

  std::array<BitModel, 2> rectKept;  // fresh, moved
  std::array<SymbolModel<kRectLevelBits>, 2> rectLevel;
  std::array<BitModel, 2> rectAligned;
  std::array<std::array<std::array<SignedModel, 16>, 2>, 2>
      rectStep;  // by fresh or moved, axis, size of the block
  std::array<std::uint32_t, std::size_t{1} << kRectLevelBits>
      rectOrigin{};  // of the last block of each level
  TessModels tess;

  NumberModel movedGap;
  NumberModel changedGap;
  SignedModel changedLevel;
  std::array<std::array<SignedModel, 8>, 3> changedStep;  // by axis, levels refined
  NumberModel freedGap;
  NumberModel hiddenGap;

  // What the next number is expected to be near.
  std::uint32_t style = 0;
  std::uint32_t parent = 0;
  std::uint32_t explicitVertex = 0;
  std::uint32_t object = 0;
  int vertexLevel = 0;
  glm::dvec3 vertexPosition{0.0};
  glm::ivec2 maskSteps{0};
  std::array<std::uint32_t, kMostWords> words{};
  RecentVertices recent;
};

}  // namespace tessera::wire
