// Quality figures of constant, equal, tiny and huge pictures.
#include "engine/measure/metrics.hpp"

#include <algorithm>

#include "apps/tessera/stability/case.hpp"

namespace tessera::stability {

namespace {

Image filled(int width, int height, std::uint8_t value) {
  return {width, height,
          std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4,
                                    value)};
}

Image noise(int width, int height, std::uint32_t seed) {
  Image image = filled(width, height, 255);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    seed = seed * 1664525U + 1013904223U;
    if (i % 4 != 3) image.pixels[i] = static_cast<std::uint8_t>(seed >> 24U);
  }
  return image;
}

/// SSIM of two constant pictures is its luminance term alone.
double exactConstant(int a, int b) {
  const long double x = a / 255.0L;
  const long double y = b / 255.0L;
  return static_cast<double>((2 * x * y + 1e-4L) / (x * x + y * y + 1e-4L));
}

Result<double> constants() {
  double worst = 0.0;
  for (const int a : {0, 1, 128, 254, 255})
    for (const int b : {0, 1, 127, 255}) {
      const auto map =
          mssim(filled(40, 23, static_cast<std::uint8_t>(a)), filled(40, 23, static_cast<std::uint8_t>(b)));
      if (!map) return tl::unexpected(map.error());
      worst = std::max(worst, std::abs(map->mean - exactConstant(a, b)));
    }
  return worst;
}

/// The textbook variance E[x^2] - E[x]^2 with float sums, over constant pictures.
double floatConstants() {
  double worst = 0.0;
  for (const int a : {1, 77, 128, 201, 254})
    for (const int side : {11, 64, 1024}) {
      const float x = static_cast<float>(a) / 255.0f;
      float sum = 0.0f;
      float squares = 0.0f;
      const int count = side * side;
      for (int i = 0; i < count; ++i) {
        sum += x;
        squares += x * x;
      }
      const float mean = sum / static_cast<float>(count);
      worst = std::max(
          worst, std::abs(static_cast<double>(squares / static_cast<float>(count) - mean * mean)) / 9e-4);
    }
  return worst;
}

Result<double> equals() {
  double worst = 0.0;
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(1, 50), std::pair(50, 1), std::pair(10, 10),
                                      std::pair(11, 11), std::pair(64, 37)}) {
    const Image image = noise(width, height, 5);
    const auto map = mssim(image, image);
    const auto ratio = psnr(image, image);
    const auto error = flip(image, image);
    if (!map || !ratio || !error) return fail("a metric refuses {} x {}", width, height);
    // Equal pictures: 1, infinity, 0.
    worst = std::max(
        {worst, std::abs(map->mean - 1.0), error->mean, std::isinf(*ratio) && *ratio > 0.0 ? 0.0 : 1.0});
  }
  return worst;
}

Result<double> onePixel() {
  double worst = 0.0;
  for (const int a : {0, 3, 255})
    for (const int b : {1, 128, 255}) {
      const Image x = filled(1, 1, static_cast<std::uint8_t>(a));
      const Image y = filled(1, 1, static_cast<std::uint8_t>(b));
      const auto map = mssim(x, y);
      const auto ratio = psnr(x, y);
      const auto error = flip(x, y);
      if (!map || !ratio || !error) return fail("a metric refuses one pixel");
      if (!std::isfinite(error->mean)) return std::numeric_limits<double>::infinity();
      worst = std::max(worst, std::abs(map->mean - exactConstant(a, b)));
      if (a != b) worst = std::max(worst, std::abs(*ratio - 20.0 * std::log10(255.0 / std::abs(a - b))));
    }
  return worst;
}

Result<double> huge() {
  double worst = 0.0;
  for (const auto& [width, height] : {std::pair(16384, 64), std::pair(16, 16384), std::pair(2048, 1024)}) {
    const auto constant = mssim(filled(width, height, 200), filled(width, height, 100));
    if (!constant) return tl::unexpected(constant.error());
    const auto ratio = psnr(filled(width, height, 255), filled(width, height, 0));
    if (!ratio) return tl::unexpected(ratio.error());
    worst = std::max({worst, std::abs(constant->mean - exactConstant(200, 100)), std::abs(*ratio)});
  }
  return worst;
}

/// SSIM is symmetric, and within -1..1.
Result<double> noisy() {
  double worst = 0.0;
  for (std::uint32_t seed = 1; seed < 6; ++seed) {
    const Image a = noise(61, 47, seed);
    Image b = noise(61, 47, seed * 77);
    if (seed % 2 == 0)
      for (std::size_t i = 0; i < b.pixels.size(); ++i)
        b.pixels[i] = static_cast<std::uint8_t>(255 - a.pixels[i]);
    const auto there = mssim(a, b);
    const auto back = mssim(b, a);
    if (!there || !back) return fail("MSSIM refuses noise");
    worst = std::max(worst, std::abs(there->mean - back->mean));
    for (const float value : there->map) worst = std::max(worst, std::abs(static_cast<double>(value)) - 1.0);
  }
  return worst;
}

}  // namespace

void addMetricCases(Cases& cases) {
  cases.push_back({"metrics/constant",
                   "pictures without variance: SSIM is the luminance term, rounding must not make "
                   "a negative variance count",
                   "error", 1e-9, Sense::AtMost, [](Bench&) { return constants(); }});
  cases.push_back({"metrics/float-variance-fails",
                   "the textbook E[x^2] - E[x]^2 with float sums: its error of a "
                   "constant picture, against C2",
                   "of C2", 1.0, Sense::AtLeast, [](Bench&) -> Result<double> { return floatConstants(); }});
  cases.push_back({"metrics/equal", "equal pictures down to 1 x 1: MSSIM 1, FLIP 0, PSNR infinite", "error",
                   1e-9, Sense::AtMost, [](Bench&) { return equals(); }});
  cases.push_back({"metrics/one-pixel", "pictures of one pixel, smaller than any window", "error", 1e-9,
                   Sense::AtMost, [](Bench&) { return onePixel(); }});
  cases.push_back({"metrics/huge",
                   "pictures of 16384 a side: sums of squares pass 2^32, means keep their digits", "error",
                   1e-9, Sense::AtMost, [](Bench&) { return huge(); }});
  cases.push_back({"metrics/noise", "noise against noise and against its negative: symmetric, within -1 to 1",
                   "error", 1e-6, Sense::AtMost, [](Bench&) { return noisy(); }});
}

}  // namespace tessera::stability
