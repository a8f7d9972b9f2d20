#include "apps/tessera/compare/runs.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "engine/measure/colormap.hpp"

namespace tessera::app {

namespace {

constexpr int kErrorQuality = 75;
constexpr int kAtlasQuality = 80;

bool has(const std::vector<std::string>& names, const char* name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

Runs::Runs(Engine& engine, const std::vector<TimedView>& views, const std::vector<Method>& methods,
           const CompareOptions& options)
    : engine_(engine),
      views_(views),
      options_(options),
      metrics_{has(options.metrics, "psnr"), has(options.metrics, "flip")},
      budget_(pictureBudget(views.size(), options.scenes.size() * methods.size())),
      references_(methods) {}

Result<Series> Runs::run(const Method& method, Progress& progress) {
  Series series;
  if (method.usesAtlas()) {
    auto setup = engineOptions(method.atlas);
    if (!setup) return tl::unexpected(setup.error());
    auto made = setup->gatherer == GathererKind::Tess    ? engine_.remakeAtlas(setup->tess)
                : setup->gatherer == GathererKind::Texel ? engine_.remakeAtlas(setup->texel)
                                                         : engine_.remakeAtlas(setup->atlas.memory);
    if (!made) return tl::unexpected(made.error());
  }
  for (int i = 0; i < options_.warmup; ++i)
    if (auto drawn = drawFrame(engine_, method, views_.front(), {.eyeDistance = options_.eyeDistance});
        !drawn)
      return tl::unexpected(drawn.error());
  const double resetsBefore = resets();
  for (std::size_t f = 0; f < views_.size(); ++f) {
    if (auto done = frame(method, f, series); !done) return fail("frame {}: {}", f, done.error().message);
    progress.step(fmt::format("{} frame {}", method.name, f + 1));
  }
  if (method.usesAtlas()) series.resets = resets() - resetsBefore;
  return series;
}

double Runs::resets() const {
  if (const TessAtlas* tess = engine_.tess())
    return static_cast<double>(tess->memory().readStatistics().resets);
  const RectAtlas* atlas = engine_.atlas();
  return atlas == nullptr ? 0.0 : static_cast<double>(atlas->memory().readStatistics().resets);
}

Result<void> Runs::frame(const Method& method, std::size_t f, Series& series) {
  const TimedView& timed = views_[f];
  std::vector<std::vector<PassTime>> runs;
  Drawn drawn;
  for (int repeat = 0; repeat < options_.repeats; ++repeat) {
    const bool last = repeat + 1 == options_.repeats;
    auto frame = drawFrame(
        engine_, method, timed,
        {.eyeDistance = options_.eyeDistance, .read = last, .alsoBehind = references_.lensFor(method)});
    if (!frame) return tl::unexpected(frame.error());
    drawn = std::move(*frame);
    runs.push_back(drawn.times);
  }
  const bool atlas = method.usesAtlas() && engine_.gatherer() != nullptr;
  // Forward counts fragment-shader invocations. The atlas shades each allocated texel once, whatever the
  // rasterizer runs besides (some count the unlit lanes of its 2 x 2 quads).
  record(series, medianTimes(runs), atlas ? engine_.gatherer()->readSamples() : drawn.invocations);
  series.invocations.push_back(static_cast<double>(drawn.invocations));
  if (!method.usesAtlas() && drawn.passed > 0) {
    series.passed.push_back(static_cast<double>(drawn.passed));
    series.nsPerPassed.push_back(series.gatherMs.back() * 1e6 / series.passed.back());
  }
  references_.keep(method, f, drawn);
  auto quality = qualityOf(references_.of(method, f), drawn.pictures, metrics_,
                           method.spatial.at(timed.time).foveation, timed.view.fovY);
  if (!quality) return tl::unexpected(quality.error());
  series.mssim.push_back(quality->mssim);
  series.mssimViews.resize(quality->mssimViews.size());
  for (std::size_t eye = 0; eye < quality->mssimViews.size(); ++eye)
    series.mssimViews[eye].push_back(quality->mssimViews[eye]);
  if (method.spatial.options.foveation) series.mssimAcuity.push_back(quality->mssimAcuity);
  if (metrics_.psnr) series.psnr.push_back(quality->psnr);
  if (metrics_.flip) series.flip.push_back(quality->flip);
  series.covered.push_back(static_cast<double>(quality->covered));
  series.holes += static_cast<double>(quality->holes);
  if (atlas) keepAtlasNumbers(f, series);
  if (std::find(budget_.frames.begin(), budget_.frames.end(), f) != budget_.frames.end())
    keepPictures(f, drawn.pictures.back(), *quality, atlas, series);
  return {};
}

void Runs::keepAtlasNumbers(std::size_t f, Series& series) const {
  series.triangles.push_back(static_cast<double>(engine_.visibleTriangles()));
  if (engine_.gatherer()->atlas().format == AtlasFormat::Rgba16f)
    series.nonFinite = (f == 0 ? 0.0 : series.nonFinite) + static_cast<double>(engine_.nonFiniteTexels());
  if (const TessAtlas* tess = engine_.tess()) {
    const TessStatistics stats = tess->memory().readStatistics();
    series.allocated.push_back(static_cast<double>(stats.samples));
    series.live.push_back(static_cast<double>(stats.liveTexels));
    series.partly.push_back(0.0);
    series.patches.push_back(static_cast<double>(stats.visible));
    series.bias.push_back(static_cast<double>(stats.bias));
    series.outOfMemory += static_cast<double>(stats.failures);
    return;
  }
  if (const TexelAtlas* texel = engine_.texel()) {
    const TexelStatistics stats = texel->readStatistics();
    series.allocated.push_back(static_cast<double>(stats.samples));
    series.live.push_back(64.0 * stats.tiles + stats.visible);
    series.partly.push_back(0.0);
    series.patches.push_back(static_cast<double>(stats.visible));
    series.bias.push_back(static_cast<double>(stats.bias));
    series.outOfMemory += static_cast<double>(stats.lost);
    return;
  }
  const RectStatistics stats = engine_.atlas()->memory().readStatistics();
  series.allocated.push_back(static_cast<double>(stats.samples));
  series.live.push_back(static_cast<double>(stats.liveTexels));
  series.partly.push_back(static_cast<double>(engine_.samplesPartlyInView(views_[f].view)));
  series.patches.push_back(static_cast<double>(stats.visiblePatches));
  series.bias.push_back(static_cast<double>(stats.bias));
  series.outOfMemory += static_cast<double>(stats.failures);
}

void Runs::keepPictures(std::size_t f, const Image& picture, const Quality& quality, bool atlas,
                        Series& series) const {
  using Bytes = std::vector<std::uint8_t>;
  ReportFrame pictures;
  pictures.frame = static_cast<int>(f);
  pictures.image = encodeJpeg(picture, budget_.quality).value_or(Bytes());
  if (quality.error)
    pictures.error = encodeJpeg(errorMap(*quality.error, kErrorFull), kErrorQuality).value_or(Bytes());
  // One atlas picture a method: the page shows it beside every frame.
  if (atlas && series.pictures.empty())
    pictures.atlas =
        encodeJpeg(halved(engine_.readAtlas(), budget_.atlasSide), kAtlasQuality).value_or(Bytes());
  series.pictures.push_back(std::move(pictures));
}

}  // namespace tessera::app
