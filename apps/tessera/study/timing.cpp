#include "apps/tessera/study/timing.hpp"

#include <algorithm>
#include <cmath>

namespace tessera::app {

namespace {

constexpr double kStep = 1.0 / 30.0;  // seconds from one predicted view to the next, at most
constexpr double kRounding = 1e-6;    // frames: times are sums of fractions

}  // namespace

std::int64_t shownFrame(double time, const StreamTiming& timing) {
  return static_cast<std::int64_t>(std::floor((time - timing.latency) * timing.serverHz + kRounding));
}

double longestUse(const StreamTiming& timing) { return timing.latency + 1.0 / timing.serverHz; }

int predictionSteps(const StreamTiming& timing) {
  return std::max(1, static_cast<int>(std::ceil(longestUse(timing) / kStep - kRounding)));
}

Samples samplesOver(double seconds, int count, double displayHz, double lead) {
  Samples samples;
  samples.displayHz = displayHz;
  samples.count = count;
  samples.first = std::ceil(lead * displayHz - kRounding) / displayHz;
  const int apart = static_cast<int>(seconds * displayHz / count);
  samples.stride = std::max(1, apart % 2 == 0 ? apart - 1 : apart);
  return samples;
}

}  // namespace tessera::app
