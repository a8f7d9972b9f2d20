#include "apps/tessera/accuracy/supersample.hpp"

#include <array>
#include <cmath>

#include <glm/glm.hpp>

#include "glsl/shared/tone.h"

namespace tessera::app {

namespace {

/// IEC 61966-2-1, encoded bytes to linear 0..1.
const std::array<float, 256>& linearOf() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> light{};
    for (std::size_t i = 0; i < light.size(); ++i) {
      const double encoded = static_cast<double>(i) / 255.0;
      light[i] =
          static_cast<float>(encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4));
    }
    return light;
  }();
  return table;
}

}  // namespace

Image averaged(const Image& image, int factor) {
  Image mean{image.width / factor, image.height / factor, {}};
  mean.pixels.resize(static_cast<std::size_t>(mean.width) * static_cast<std::size_t>(mean.height) * 4);
  const std::array<float, 256>& linear = linearOf();
  const float samples = static_cast<float>(factor) * static_cast<float>(factor);
  for (int y = 0; y < mean.height; ++y)
    for (int x = 0; x < mean.width; ++x) {
      std::array<float, 4> sum{};
      for (int row = 0; row < factor; ++row) {
        const std::uint8_t* pixel = image.at(x * factor, y * factor + row);
        for (int column = 0; column < factor; ++column, pixel += 4) {
          for (std::size_t c = 0; c < 3; ++c) sum[c] += linear[pixel[c]];
          sum[3] += static_cast<float>(pixel[3]);
        }
      }
      std::uint8_t* pixel = mean.at(x, y);
      for (std::size_t c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(std::lround(255.0f * glsl::encodeSrgb(sum[c] / samples)));
      pixel[3] = static_cast<std::uint8_t>(std::lround(sum[3] / samples));
    }
  return mean;
}

}  // namespace tessera::app
