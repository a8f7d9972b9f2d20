#include "engine/measure/statistics.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <vector>

namespace tessera {
namespace {
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
}

Statistics::Statistics() : min(kNone), max(kNone), mean(kNone), median(kNone), p95(kNone), spread(kNone) {}

double quantileOfSorted(std::span<const double> sorted, double q) {
  assert(q >= 0.0 && q <= 1.0);
  if (sorted.empty()) return kNone;
  const double position = q * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], position - static_cast<double>(below));
}

Statistics summarize(std::span<const double> samples) {
  std::vector<double> sorted;
  sorted.reserve(samples.size());
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(sorted),
               [](double sample) { return std::isfinite(sample); });
  std::sort(sorted.begin(), sorted.end());
  Statistics out;
  if (sorted.empty()) return out;
  out.count = sorted.size();
  out.min = sorted.front();
  out.max = sorted.back();
  out.mean = std::accumulate(sorted.begin(), sorted.end(), 0.0) / static_cast<double>(sorted.size());
  out.median = quantileOfSorted(sorted, 0.5);
  out.p95 = quantileOfSorted(sorted, 0.95);
  out.spread = quantileOfSorted(sorted, 0.75) - quantileOfSorted(sorted, 0.25);
  return out;
}

}  // namespace tessera
