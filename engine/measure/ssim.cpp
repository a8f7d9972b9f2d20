#include "engine/measure/ssim.hpp"

#include <algorithm>
#include <cstdint>

#include "engine/measure/filter.hpp"

namespace tessera {
namespace {

constexpr int kWindow = 11;
constexpr double kSigma = 2.0;
constexpr double kC1 = 1e-4;
constexpr double kC2 = 9e-4;
// Rows of the map worked on at once: bounds the memory for large images, and a band of planes stays near the
// cache.
constexpr int kBandRows = 64;

/// Local means of the two images and of their squares and product over a band.
struct Moments {
  Plane<double> x, y, xx, yy, xy;
};

Moments bandMoments(int width, const LumaRow& reference, const LumaRow& test, int firstRow, int rows) {
  Moments m{{width, rows}, {width, rows}, {width, rows}, {width, rows}, {width, rows}};
  for (int row = 0; row < rows; ++row) {
    reference(firstRow + row, m.x.row(row));
    test(firstRow + row, m.y.row(row));
  }
  for (std::size_t i = 0; i < m.x.values.size(); ++i) {
    const double x = m.x.values[i];
    const double y = m.y.values[i];
    m.xx.values[i] = x * x;
    m.yy.values[i] = y * y;
    m.xy.values[i] = x * y;
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

LumaRow lumaOf(const Image& image) {
  return [&image](int row, double* out) {
    const std::uint8_t* pixel = image.at(0, row);
    for (int x = 0; x < image.width; ++x, pixel += 4)
      out[x] = (0.2126 * pixel[0] + 0.7152 * pixel[1] + 0.0722 * pixel[2]) / 255.0;
  };
}

MetricMap ssimMap(int width, int height, const LumaRow& reference, const LumaRow& test) {
  const std::vector<double> tapsX = gaussianTaps(std::min(kWindow, width), kSigma);
  const std::vector<double> tapsY = gaussianTaps(std::min(kWindow, height), kSigma);
  MetricMap result;
  result.width = width - static_cast<int>(tapsX.size()) + 1;
  result.height = height - static_cast<int>(tapsY.size()) + 1;
  result.map.resize(static_cast<std::size_t>(result.width) * static_cast<std::size_t>(result.height));

  const auto filtered = [&](const Plane<double>& plane) {
    return convolveColumns<double>(convolveRows<double>(plane, tapsX), tapsY);
  };
  const double sum = sumOverBands(result.height, kBandRows, [&](int first, int end) {
    const int rows = end - first + static_cast<int>(tapsY.size()) - 1;
    const Moments in = bandMoments(width, reference, test, first, rows);
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

}  // namespace tessera
