#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "engine/measure/acuity.hpp"
#include "engine/measure/filter.hpp"
#include "engine/measure/metrics.hpp"
#include "engine/measure/metrics_check.hpp"
#include "engine/measure/ssim.hpp"

namespace tessera {
namespace {

/// Half the size, rounded up: means of 2 x 2 values, the last of an odd row or column counted twice.
Plane<double> halved(int width, int height, const LumaRow& luma) {
  Plane<double> out((width + 1) / 2, (height + 1) / 2);
  std::vector<double> upper(static_cast<std::size_t>(width));
  std::vector<double> lower(static_cast<std::size_t>(width));
  for (int y = 0; y < out.height; ++y) {
    luma(2 * y, upper.data());
    luma(std::min(2 * y + 1, height - 1), lower.data());
    for (int x = 0; x < out.width; ++x) {
      const std::size_t left = 2 * static_cast<std::size_t>(x);
      const std::size_t right = std::min(left + 1, upper.size() - 1);
      out.row(y)[x] = 0.25 * (upper[left] + upper[right] + lower[left] + lower[right]);
    }
  }
  return out;
}

LumaRow rowsOf(const Plane<double>& plane) {
  return [&plane](int row, double* out) { std::copy_n(plane.row(row), plane.width, out); };
}

/// SSIM on a level of the pyramid, where a pixel is 2^level pixels of the picture wide.
struct Level {
  MetricMap ssim;
  int left = 0;  // columns and rows before the first window's middle
  int top = 0;
};

Level levelOf(int width, int height, const LumaRow& reference, const LumaRow& test) {
  Level level{ssimMap(width, height, reference, test)};
  level.left = (width - level.ssim.width) / 2;
  level.top = (height - level.ssim.height) / 2;
  return level;
}

/// Levels 0 to `last`, fewer where one of a single pixel comes first.
std::vector<Level> pyramidOf(const Image& reference, const Image& test, int last) {
  std::vector<Level> levels{levelOf(reference.width, reference.height, lumaOf(reference), lumaOf(test))};
  if (last == 0 || std::max(reference.width, reference.height) == 1) return levels;
  Plane<double> a = halved(reference.width, reference.height, lumaOf(reference));
  Plane<double> b = halved(test.width, test.height, lumaOf(test));
  for (int i = 1;; ++i) {
    levels.push_back(levelOf(a.width, a.height, rowsOf(a), rowsOf(b)));
    if (i == last || std::max(a.width, a.height) == 1) return levels;
    a = halved(a.width, a.height, rowsOf(a));
    b = halved(b.width, b.height, rowsOf(b));
  }
}

/// The SSIM at pixel (x, y) of the picture: of the window around the level's pixel that holds it, or of the
/// nearest one where that does not fit.
double at(const std::vector<Level>& levels, int index, int x, int y) {
  const Level& level = levels[static_cast<std::size_t>(index)];
  const int column = std::clamp((x >> index) - level.left, 0, level.ssim.width - 1);
  const int row = std::clamp((y >> index) - level.top, 0, level.ssim.height - 1);
  return static_cast<double>(
      level.ssim.map[static_cast<std::size_t>(row) * static_cast<std::size_t>(level.ssim.width) +
                     static_cast<std::size_t>(column)]);
}

}  // namespace

Result<double> acuityMssim(const Image& reference, const Image& test, double fovY,
                           const Foveation& foveation) {
  if (auto checked = checkPair("acuity MSSIM", reference, test); !checked)
    return tl::unexpected(checked.error());
  const auto scales = acuityScales(reference.width, reference.height, fovY, foveation);
  if (!scales) return tl::unexpected(scales.error());
  const double coarsest = static_cast<double>(*std::max_element(scales->begin(), scales->end()));
  const std::vector<Level> levels =
      pyramidOf(reference, test, static_cast<int>(std::ceil(std::log2(coarsest))));
  const int last = static_cast<int>(levels.size()) - 1;

  // The pixels that plain MSSIM counts: those in the middle of a window of the picture itself.
  const Level& full = levels.front();
  double sum = 0.0;
  double total = 0.0;
  for (int y = full.top; y < full.top + full.ssim.height; ++y)
    for (int x = full.left; x < full.left + full.ssim.width; ++x) {
      const auto scale = static_cast<double>(
          (*scales)[static_cast<std::size_t>(y) * static_cast<std::size_t>(reference.width) +
                    static_cast<std::size_t>(x)]);
      const double level = std::min(std::log2(scale), static_cast<double>(last));
      const int finer = static_cast<int>(level);
      const double fine = at(levels, finer, x, y);
      const double coarse = at(levels, std::min(finer + 1, last), x, y);
      const double weight = 1.0 / (scale * scale);
      sum += weight * std::lerp(fine, coarse, level - finer);
      total += weight;
    }
  return sum / total;
}

}  // namespace tessera
