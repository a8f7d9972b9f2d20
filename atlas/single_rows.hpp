// Where an atlas texture keeps what has a single texel: in rows below its blocks.
#pragma once

#include <cstdint>

namespace tessera {

/// Rows for `texels` of them below `height` rows of `width`; one more where the texture's height would be
/// odd, since video of 4:2:0 takes squares of two texels a side.
[[nodiscard]] constexpr std::uint32_t singleRows(std::uint32_t width, std::uint32_t height,
                                                 std::uint32_t texels) {
  const std::uint32_t rows = (texels + width - 1) / width;
  return rows + (height + rows) % 2;
}

}  // namespace tessera
