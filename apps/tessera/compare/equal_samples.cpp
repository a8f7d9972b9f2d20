#include "apps/tessera/compare/equal_samples.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/tessera/compare/drawing.hpp"

namespace tessera::app {

namespace {

constexpr std::size_t kMostFrames = 8;  // of the views, spread over them
constexpr int kMostTries = 12;
constexpr double kGoodEnough = 0.02;  // of the samples: what the search stops at
constexpr double kTolerance = 0.1;    // and what it must reach
constexpr double kLeastBias = -8.0;
constexpr double kMostBias = 16.0;

/// Samples a frame, as a run of these frames would place them.
Result<double> samplesOf(Engine& engine, const Method& method, const std::vector<TimedView>& views,
                         int warmup) {
  if (auto made = useAtlas(engine, method); !made) return tl::unexpected(made.error());
  const auto samples = [&](const TimedView& timed) -> Result<double> {
    engine.update(timed.time);
    if (auto placed = placeFrame(engine, method, timed, {timed.view}); !placed)
      return tl::unexpected(placed.error());
    return static_cast<double>(engine.gatherer()->readStatistics().samples);
  };
  for (int i = 0; i < warmup; ++i)
    if (auto placed = samples(views.front()); !placed) return placed;
  const std::size_t frames = std::min(kMostFrames, views.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < frames; ++i) {
    auto placed = samples(views[i * views.size() / frames]);
    if (!placed) return placed;
    sum += *placed;
  }
  return sum / static_cast<double>(frames);
}

}  // namespace

const Method* samplesReference(const std::vector<Method>& methods) {
  const auto found = std::find_if(methods.begin(), methods.end(), [](const Method& method) {
    return method.usesAtlasOnce() && method.atlas.sampling == Sampling::Rect;
  });
  return found == methods.end() ? nullptr : &*found;
}

Result<void> equalizeSamples(Engine& engine, const std::vector<TimedView>& views, int warmup,
                             std::vector<Method>& methods) {
  const Method* reference = samplesReference(methods);
  if (reference == nullptr) return fail("--equal-samples: no method fills rectangles for one view");
  auto wanted = samplesOf(engine, *reference, views, warmup);
  if (!wanted) return tl::unexpected(wanted.error());
  for (Method& method : methods) {
    if (!method.usesAtlasOnce() || &method == reference) continue;
    double bias = method.atlas.bias;
    double ratio = 0.0;
    double lastBias = 0.0;
    double lastExcess = 0.0;
    double slope = 1.0;  // powers of two of samples that a step of bias takes away
    for (int i = 0; i < kMostTries; ++i) {
      // Rounded: the name that the report gives can be asked for.
      bias = std::clamp(std::round(100.0 * bias) / 100.0, kLeastBias, kMostBias);
      method.atlas.bias = bias;
      auto samples = samplesOf(engine, method, views, warmup);
      if (!samples) return fail("{}: {}", method.name, samples.error().message);
      ratio = *samples / *wanted;
      if (std::abs(ratio - 1.0) <= kGoodEnough) break;
      const double excess = std::log2(ratio);
      if (i > 0 && bias != lastBias) slope = std::clamp((lastExcess - excess) / (bias - lastBias), 0.25, 2.0);
      lastBias = bias;
      lastExcess = excess;
      bias += excess / slope;
    }
    const std::string before = method.name;
    method.name = withSetting(method.name, fmt::format("bias={:g}", method.atlas.bias));
    method.equalSamples = ratio;
    fmt::print("equal samples: {}: bias {:g}, {:.0f} samples a frame placed, {:.3f} of {}'s{}\n", before,
               method.atlas.bias, ratio * *wanted, ratio, reference->name,
               std::abs(ratio - 1.0) <= kTolerance ? "" : ": no bias comes within a tenth");
  }
  return {};
}

}  // namespace tessera::app
