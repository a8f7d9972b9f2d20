// Alpha of masked materials, in levels.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace tessera::wire {

/// Rows from the top, no padding.
struct AlphaPlane {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> alpha;
};

/// Half as wide and high, at least 1 x 1: each texel the rounded mean of four. Of an odd side the last texel
/// has no part, as in mip levels.
inline AlphaPlane halved(std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> alpha) {
  AlphaPlane half{std::max(width / 2, 1u), std::max(height / 2, 1u), {}};
  half.alpha.reserve(std::size_t{half.width} * half.height);
  for (std::uint32_t y = 0; y < half.height; ++y)
    for (std::uint32_t x = 0; x < half.width; ++x) {
      const auto at = [&](std::uint32_t dx, std::uint32_t dy) {
        return std::uint32_t{
            alpha[std::size_t{std::min(2 * y + dy, height - 1)} * width + std::min(2 * x + dx, width - 1)]};
      };
      half.alpha.push_back(static_cast<std::uint8_t>((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) / 4));
    }
  return half;
}

}  // namespace tessera::wire
