#include "engine/measure/metrics.hpp"

#include <cmath>
#include <cstdint>
#include <limits>

#include "engine/measure/metrics_check.hpp"
#include "engine/measure/ssim.hpp"

namespace tessera {

Result<MetricMap> mssim(const Image& reference, const Image& test) {
  if (auto checked = checkPair("MSSIM", reference, test); !checked) return tl::unexpected(checked.error());
  return ssimMap(reference.width, reference.height, lumaOf(reference), lumaOf(test));
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
