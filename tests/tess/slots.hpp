// Which texels the triangles of a TessMemory hold: painted on the CPU, so that two in one place show.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "atlas/tess/tess_memory.hpp"

namespace tessera::test {

using TexelList = std::vector<glm::uvec2>;

/// The texels of a level's L, and those of a block, as the samples need them and not by the closed forms: an
/// L's are those that some sample is written to, a block's are the corners of every cell that the triangle
/// reaches into.
TexelList lTexelList(std::uint32_t level);
TexelList blockTexelList(std::uint32_t columns, std::uint32_t rows);

/// An image of the atlas, every texel 0 or the triangle that holds it plus 1.
class SlotPainter {
 public:
  SlotPainter(int width, int height) : width_(width), height_(height) {}

  /// Paints what `visible` hold and the free rectangles; says what is wrong first, or nothing. Slots lie in
  /// cells of the sizes that `bins` have, and above the record rows.
  std::string paint(std::span<const std::uint32_t> visible, const glsl::TessAtlasState& state,
                    const std::vector<glsl::TessState>& states, const std::vector<glsl::TessBin>& bins);
  /// Slots of each bin that the last paint() met.
  [[nodiscard]] const std::vector<std::uint32_t>& held() const { return held_; }

 private:
  std::string paintSlot(std::uint32_t triangle, std::uint32_t bin, std::uint32_t place,
                        const TexelList& texels, const glsl::TessBin& cell,
                        const glsl::TessAtlasState& state);
  std::string paintTexel(std::uint32_t owner, std::uint32_t x, std::uint32_t y);
  const TexelList& listOf(std::uint32_t bin);

  int width_;
  int height_;
  std::vector<std::uint32_t> owners_;
  std::vector<std::uint32_t> held_;
  std::map<std::uint32_t, TexelList> lists_;  // by bin
};

}  // namespace tessera::test
