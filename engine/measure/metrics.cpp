#include "engine/measure/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "engine/measure/filter.hpp"
#include "engine/measure/metrics_check.hpp"

namespace tessera {
namespace {

constexpr int kWindow = 11;
constexpr double kSigma = 2.0;
constexpr double kC1 = 1e-4;
constexpr double kC2 = 9e-4;
// Rows of the map worked on at once: bounds the memory for large images, and a band of planes stays near the
// cache.
constexpr int kBandRows = 64;

double luma(const std::uint8_t* pixel) {
  return (0.2126 * pixel[0] + 0.7152 * pixel[1] + 0.0722 * pixel[2]) / 255.0;
}

/// Local means of the two images and of their squares and product over a band.
struct Moments {
  Plane<double> x, y, xx, yy, xy;
};

Moments bandMoments(const Image& reference, const Image& test, int firstRow, int rows) {
  Moments m{{reference.width, rows},
            {reference.width, rows},
            {reference.width, rows},
            {reference.width, rows},
            {reference.width, rows}};
  std::size_t i = 0;
  for (int row = firstRow; row < firstRow + rows; ++row) {
    const std::uint8_t* a = reference.at(0, row);
    const std::uint8_t* b = test.at(0, row);
    for (int column = 0; column < reference.width; ++column, ++i, a += 4, b += 4) {
      const double x = luma(a);
      const double y = luma(b);
      m.x.values[i] = x;
      m.y.values[i] = y;
      m.xx.values[i] = x * x;
      m.yy.values[i] = y * y;
      m.xy.values[i] = x * y;
    }
  }
  return m;
}

double structuralSimilarity(double x, double y, double xx, double yy, double xy) {
  // Rounding can leave a variance a little below zero; the terms in C1 and C2 keep the quotient finite all
  // the same.
  return ((2.0 * x * y + kC1) * (2.0 * (xy - x * y) + kC2)) /
         ((x * x + y * y + kC1) * ((xx - x * x) + (yy - y * y) + kC2));
}

}  // namespace

Result<MetricMap> mssim(const Image& reference, const Image& test) {
  if (auto checked = checkPair("MSSIM", reference, test); !checked) return tl::unexpected(checked.error());
  const std::vector<double> tapsX = gaussianTaps(std::min(kWindow, reference.width), kSigma);
  const std::vector<double> tapsY = gaussianTaps(std::min(kWindow, reference.height), kSigma);
  MetricMap result;
  result.width = reference.width - static_cast<int>(tapsX.size()) + 1;
  result.height = reference.height - static_cast<int>(tapsY.size()) + 1;
  result.map.resize(static_cast<std::size_t>(result.width) * static_cast<std::size_t>(result.height));

  const auto filtered = [&](const Plane<double>& plane) {
    return convolveColumns<double>(convolveRows<double>(plane, tapsX), tapsY);
  };
  const double sum = sumOverBands(result.height, kBandRows, [&](int first, int end) {
    const int rows = end - first + static_cast<int>(tapsY.size()) - 1;
    const Moments in = bandMoments(reference, test, first, rows);
    const Moments mean{filtered(in.x), filtered(in.y), filtered(in.xx), filtered(in.yy), filtered(in.xy)};
    float* out = result.map.data() + static_cast<std::size_t>(first) * static_cast<std::size_t>(result.width);
    double bandSum = 0.0;
    for (std::size_t i = 0; i < mean.x.values.size(); ++i) {
      const double value = structuralSimilarity(mean.x.values[i], mean.y.values[i], mean.xx.values[i],
                                                mean.yy.values[i], mean.xy.values[i]);
      out[i] = static_cast<float>(value);
      bandSum += value;
    }
    return bandSum;
  });
  result.mean = sum / static_cast<double>(result.map.size());
  return result;
}

Result<MetricMap> mssim(const Image& reference, const Image& test, std::span<const float> weights) {
  auto result = mssim(reference, test);
  if (!result) return result;
  if (weights.size() * 4 != reference.pixels.size())
    return fail("MSSIM: {} weights for an image of {} x {} pixels", weights.size(), reference.width,
                reference.height);
  for (const float weight : weights)
    if (!(weight >= 0.0f && std::isfinite(weight))) return fail("MSSIM: a weight of {}", weight);
  // A window counts by its middle.
  const int left = (reference.width - result->width) / 2;
  const int top = (reference.height - result->height) / 2;
  double sum = 0.0;
  double total = 0.0;
  std::size_t i = 0;
  for (int y = 0; y < result->height; ++y) {
    const float* row =
        weights.data() + static_cast<std::size_t>(y + top) * static_cast<std::size_t>(reference.width) + left;
    for (int x = 0; x < result->width; ++x, ++i) {
      sum += static_cast<double>(row[x]) * static_cast<double>(result->map[i]);
      total += static_cast<double>(row[x]);
    }
  }
  if (!(total > 0.0)) return fail("MSSIM: the weights of all windows are 0");
  result->mean = sum / total;
  return result;
}

Result<double> psnr(const Image& reference, const Image& test) {
  if (auto checked = checkPair("PSNR", reference, test); !checked) return tl::unexpected(checked.error());
  std::uint64_t squares = 0;  // at most 2^26 pixels * 3 * 255^2 < 2^44: exact
  for (std::size_t i = 0; i < reference.pixels.size(); ++i) {
    if (i % 4 == 3) continue;
    const int difference = int{reference.pixels[i]} - int{test.pixels[i]};
    squares += static_cast<std::uint64_t>(difference * difference);
  }
  if (squares == 0) return std::numeric_limits<double>::infinity();
  const std::size_t values = reference.pixels.size() / 4 * 3;
  return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(values) / static_cast<double>(squares));
}

}  // namespace tessera
