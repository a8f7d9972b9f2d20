// How two pictures of the engine differ.
#pragma once

#include <algorithm>
#include <cstdlib>

#include "engine/frame/engine.hpp"
#include "engine/image/image.hpp"

namespace tessera::test {

inline std::size_t countCovered(const Image& image) {
  std::size_t covered = 0;
  for (std::size_t i = 3; i < image.pixels.size(); i += 4) covered += image.pixels[i] > 0 ? 1 : 0;
  return covered;
}

inline int largestDifference(const Image& a, const Image& b) {
  int largest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    largest = std::max(largest, std::abs(static_cast<int>(a.pixels[i]) - static_cast<int>(b.pixels[i])));
  return largest;
}

inline double meanDifference(const Image& a, const Image& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    sum += std::abs(static_cast<int>(a.pixels[i]) - static_cast<int>(b.pixels[i]));
  return sum / static_cast<double>(a.pixels.size());
}

/// Covered pixels that are not white.
inline std::size_t darkPixels(const Image& image) {
  std::size_t dark = 0;
  for (std::size_t i = 0; i < image.pixels.size(); i += 4)
    dark +=
        image.pixels[i + 3] > 0 && std::min({image.pixels[i], image.pixels[i + 1], image.pixels[i + 2]}) < 250
            ? 1
            : 0;
  return dark;
}

/// What the atlas held is gone; texels that are not shaded anew show.
inline void blackenAtlas(Engine& engine) {
  gl::api().ClearTexImage(engine.gatherer()->atlas().texture.get(), 0, GL_RGBA, GL_FLOAT, nullptr);
}

}  // namespace tessera::test
