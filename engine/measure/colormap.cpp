#include "engine/measure/colormap.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tessera {
namespace {
constexpr std::array<Rgb8, 9> kStops{{{0, 0, 4},
                                      {28, 16, 68},
                                      {79, 18, 123},
                                      {129, 37, 129},
                                      {181, 54, 122},
                                      {229, 89, 100},
                                      {251, 135, 97},
                                      {254, 194, 135},
                                      {252, 253, 191}}};
constexpr Rgb8 kNotANumber{0, 255, 255};
}  // namespace

std::span<const Rgb8> colormapStops() { return kStops; }

Rgb8 colormap(float value) {
  if (std::isnan(value)) return kNotANumber;
  const float position = std::clamp(value, 0.0F, 1.0F) * static_cast<float>(kStops.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(position), kStops.size() - 2);
  const float t = position - static_cast<float>(below);
  Rgb8 out{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto from = static_cast<float>(kStops[below][c]);
    const auto to = static_cast<float>(kStops[below + 1][c]);
    out[c] = static_cast<std::uint8_t>(std::lround(from + t * (to - from)));
  }
  return out;
}

Image errorMap(const MetricMap& error, float full) {
  Image image{error.width, error.height, {}};
  image.pixels.reserve(error.map.size() * 4);
  for (const float value : error.map) {
    const Rgb8 colour = colormap(value / full);
    image.pixels.insert(image.pixels.end(), {colour[0], colour[1], colour[2], 255});
  }
  return image;
}

MetricMap dissimilarity(const MetricMap& similarity) {
  MetricMap out = similarity;
  for (float& value : out.map) value = (1.0F - value) * 0.5F;
  out.mean = dssim(similarity.mean);
  return out;
}

}  // namespace tessera
