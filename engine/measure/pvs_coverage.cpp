#include "engine/measure/pvs_coverage.hpp"

#include <algorithm>
#include <cassert>

namespace tessera {

PvsCoverage coverageOf(const ElementPixels& shown, const ElementPixels& sampled,
                       const std::vector<bool>& inSet) {
  assert(shown.pixels.size() == inSet.size() && sampled.pixels.size() == inSet.size());
  std::uint64_t needed = 0;
  std::uint64_t missed = 0;
  std::uint64_t needless = 0;
  PvsCoverage coverage;
  for (std::size_t i = 0; i < inSet.size(); ++i) {
    const bool seen = shown.pixels[i] > 0;
    needed += shown.pixels[i];
    coverage.neededElements += seen ? 1 : 0;
    coverage.setElements += inSet[i] ? 1 : 0;
    if (seen && !inSet[i]) {
      missed += shown.pixels[i];
      ++coverage.missedElements;
    }
    if (!seen && inSet[i]) {
      needless += sampled.pixels[i];
      ++coverage.needlessElements;
    }
  }
  const auto shownViews = static_cast<double>(std::max<std::size_t>(shown.views, 1));
  const auto sampledViews = static_cast<double>(std::max<std::size_t>(sampled.views, 1));
  coverage.needed = static_cast<double>(needed) / shownViews;
  coverage.missed = static_cast<double>(missed) / shownViews;
  coverage.needless = static_cast<double>(needless) / sampledViews;
  return coverage;
}

}  // namespace tessera
