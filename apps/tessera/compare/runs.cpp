#include "apps/tessera/compare/runs.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "apps/tessera/compare/pictures.hpp"
#include "engine/measure/colormap.hpp"
#include "engine/measure/metrics.hpp"

namespace tessera::app {

namespace {

// A page of four scenes and five methods stays a page that a browser opens at once.
constexpr int kPictureQuality = 90;
constexpr int kErrorQuality = 75;
constexpr int kAtlasQuality = 80;
constexpr int kAtlasPreview = 2048;

}  // namespace

Runs::Runs(Engine& engine, const std::vector<TimedView>& views, const CompareOptions& options)
    : engine_(engine), views_(views), options_(options), chosen_(pictureFrames(views.size())) {}

Result<Series> Runs::run(const Method& method, Progress& progress) {
  Series series;
  if (method.usesAtlas() && engine_.atlas() != nullptr) {
    engine_.atlas()->memory().setBias(static_cast<float>(method.bias));
    engine_.atlas()->memory().reset();
  }
  for (int i = 0; i < options_.warmup; ++i) draw(method, views_.front());
  const double resetsBefore = resets();
  for (std::size_t f = 0; f < views_.size(); ++f) {
    if (auto done = frame(method, f, series); !done) return tl::unexpected(done.error());
    progress.step(fmt::format("{} frame {}", method.name, f + 1));
  }
  if (method.usesAtlas()) series.resets = resets() - resetsBefore;
  return series;
}

void Runs::draw(const Method& method, const TimedView& timed) {
  engine_.clearTimes();
  engine_.update(timed.time);
  switch (method.kind) {
    case Kind::Forward:
      engine_.forward(timed.view, false);
      break;
    case Kind::ForwardPrepass:
      engine_.forward(timed.view, true);
      break;
    case Kind::Rect:
      engine_.rect(timed.view, DisplayMode::Geometry);
      break;
    case Kind::RectDeferred:
      engine_.rect(timed.view, DisplayMode::Deferred);
      break;
  }
}

double Runs::resets() const {
  return engine_.atlas() == nullptr ? 0.0
                                    : static_cast<double>(engine_.atlas()->memory().readStatistics().resets);
}

Result<void> Runs::frame(const Method& method, std::size_t f, Series& series) {
  const TimedView& timed = views_[f];
  std::vector<std::vector<PassTime>> runs;
  for (int repeat = 0; repeat < options_.repeats; ++repeat) {
    draw(method, timed);
    runs.push_back(engine_.times());
  }
  // Forward counts fragment-shader invocations. The atlas shades each allocated texel once, whatever the
  // rasterizer runs besides (some count the unlit lanes of its 2 x 2 quads).
  const std::uint64_t shaded = method.usesAtlas() && engine_.atlas() != nullptr
                                   ? engine_.atlas()->memory().readStatistics().samples
                                   : engine_.fragments();
  record(series, medianTimes(runs), shaded);
  if (!method.usesAtlas() && engine_.samplesPassed() > 0) {
    series.passed.push_back(static_cast<double>(engine_.samplesPassed()));
    series.nsPerPassed.push_back(series.gatherMs.back() * 1e6 / series.passed.back());
  }
  const Image picture = engine_.readColor();
  if (references_.size() <= f) references_.push_back(picture);
  const Image& reference = references_[f];
  auto similarity = mssim(reference, picture);
  auto ratio = psnr(reference, picture);
  auto difference = flip(reference, picture);
  if (!similarity || !ratio || !difference) return fail("frame {}: pictures cannot be compared", f);
  series.mssim.push_back(similarity->mean);
  series.psnr.push_back(*ratio);
  series.flip.push_back(difference->mean);
  series.covered.push_back(static_cast<double>(coveredPixels(reference)));
  series.holes += static_cast<double>(holesOf(reference, picture));
  if (method.usesAtlas() && engine_.atlas() != nullptr) {
    const RectStatistics stats = engine_.atlas()->memory().readStatistics();
    series.allocated.push_back(static_cast<double>(stats.samples));
    series.live.push_back(static_cast<double>(stats.liveTexels));
    series.partly.push_back(static_cast<double>(engine_.samplesPartlyInView(timed.view)));
    series.patches.push_back(static_cast<double>(stats.visiblePatches));
    series.triangles.push_back(static_cast<double>(engine_.visibleTriangles()));
    series.bias.push_back(static_cast<double>(stats.bias));
    series.outOfMemory += static_cast<double>(stats.failures);
    if (engine_.atlas()->format() == AtlasFormat::Rgba16f)
      series.nonFinite = (f == 0 ? 0.0 : series.nonFinite) + static_cast<double>(engine_.nonFiniteTexels());
  }
  if (std::find(chosen_.begin(), chosen_.end(), f) != chosen_.end()) {
    ReportFrame pictures;
    pictures.frame = static_cast<int>(f);
    pictures.image = encodeJpeg(picture, kPictureQuality).value_or(std::vector<std::uint8_t>());
    pictures.error =
        encodeJpeg(errorMap(*difference, kErrorFull), kErrorQuality).value_or(std::vector<std::uint8_t>());
    // One atlas picture a method: the page shows it beside every frame.
    if (method.usesAtlas() && engine_.atlas() != nullptr && series.pictures.empty())
      pictures.atlas = encodeJpeg(halved(engine_.readAtlas(), kAtlasPreview), kAtlasQuality)
                           .value_or(std::vector<std::uint8_t>());
    series.pictures.push_back(std::move(pictures));
  }
  return {};
}

}  // namespace tessera::app
