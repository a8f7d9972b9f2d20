#include "apps/tessera/compare/runs.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "engine/measure/colormap.hpp"

namespace tessera::app {

namespace {

constexpr int kErrorQuality = 75;
constexpr int kAtlasQuality = 80;
// Of the picture of an atlas by kind, texels: small enough that a column of the page shows each of them.
constexpr int kKindsWidth = 768;
constexpr int kKindsHeight = 384;

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
      references_(methods) {
  if (std::any_of(methods.begin(), methods.end(), [](const Method& m) { return m.usesAtlasOnce(); }))
    crops_ = chooseCrops(engine, views, budget_.frames);
}

Result<Series> Runs::run(const Method& method, Progress& progress, Wanted wanted) {
  Series series;
  if (auto made = useAtlas(engine_, method); !made) return tl::unexpected(made.error());
  for (int i = 0; i < options_.warmup; ++i)
    if (auto drawn = drawFrame(engine_, method, views_.front(), {.eyeDistance = options_.eyeDistance});
        !drawn)
      return tl::unexpected(drawn.error());
  const std::uint64_t resetsBefore = method.usesAtlas() ? resets() : 0;
  for (std::size_t f = 0; f < views_.size(); ++f) {
    if (auto done = frame(method, f, wanted, series); !done)
      return fail("frame {}: {}", f, done.error().message);
    progress.step(fmt::format("{} frame {}", method.name, f + 1));
  }
  if (method.usesAtlas()) series.resets = static_cast<double>(resets() - resetsBefore);
  return series;
}

std::uint64_t Runs::resets() const {
  return engine_.gatherer() == nullptr ? 0 : engine_.gatherer()->readStatistics().resets;
}

Result<void> Runs::frame(const Method& method, std::size_t f, Wanted wanted, Series& series) {
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
  if (atlas) keepAtlasNumbers(f, series);
  // Forward counts fragment-shader invocations. The atlas shades each allocated texel once, whatever the
  // rasterizer runs besides (some count the unlit lanes of its 2 x 2 quads).
  record(series, medianTimes(runs), atlas ? series.gathered.back().samples : drawn.invocations);
  series.invocations.push_back(static_cast<double>(drawn.invocations));
  if (!method.usesAtlas() && drawn.passed > 0) {
    series.passed.push_back(static_cast<double>(drawn.passed));
    series.nsPerPassed.push_back(series.gatherMs.back() * 1e6 / series.passed.back());
  }
  references_.keep(method, f, drawn);
  const MetricChoice metrics = wanted == Wanted::All ? metrics_ : MetricChoice{false, false};
  auto quality = qualityOf(references_.of(method, f), drawn.pictures, metrics,
                           method.spatial.at(timed.time).foveation, timed.view.fovY);
  if (!quality) return tl::unexpected(quality.error());
  series.mssim.push_back(quality->mssim);
  series.mssimViews.resize(quality->mssimViews.size());
  for (std::size_t eye = 0; eye < quality->mssimViews.size(); ++eye)
    series.mssimViews[eye].push_back(quality->mssimViews[eye]);
  if (method.spatial.options.foveation) series.mssimAcuity.push_back(quality->mssimAcuity);
  if (metrics.psnr) series.psnr.push_back(quality->psnr);
  if (metrics.flip) series.flip.push_back(quality->flip);
  series.covered.push_back(static_cast<double>(quality->covered));
  series.holes += static_cast<double>(quality->holes);
  if (wanted == Wanted::Numbers) return {};
  if (auto kept = keepCrops(method, f, drawn.pictures.back()); !kept) return kept;
  if (std::find(budget_.frames.begin(), budget_.frames.end(), f) != budget_.frames.end())
    keepPictures(f, drawn.pictures.back(), *quality, atlas, series);
  return {};
}

void Runs::keepAtlasNumbers(std::size_t f, Series& series) const {
  series.triangles.push_back(static_cast<double>(engine_.visibleTriangles()));
  if (engine_.gatherer()->atlas().format == AtlasFormat::Rgba16f)
    series.nonFinite = (f == 0 ? 0.0 : series.nonFinite) + static_cast<double>(engine_.nonFiniteTexels());
  series.gathered.push_back(engine_.gatherer()->readStatistics());
  const GatherStatistics& stats = series.gathered.back();
  if (engine_.atlas() != nullptr)
    series.partly.push_back(static_cast<double>(engine_.samplesPartlyInView(views_[f].view)));
  series.bias.push_back(stats.bias);
  series.outOfMemory += static_cast<double>(stats.failures);
}

Result<void> Runs::keepCrops(const Method& method, std::size_t f, const Image& picture) {
  if (method.isStereo() || method.spatial.options.lens) return {};
  for (ReportCrop& crop : crops_) {
    if (crop.frame != static_cast<int>(f)) continue;
    const Image part = cropped(picture, crop);
    auto image = encodePng(part);
    if (!image) return tl::unexpected(image.error());
    auto likeness = mssim(cropped(references_.of(method, f).back(), crop), part);
    if (!likeness) return tl::unexpected(likeness.error());
    crop.pictures.push_back({method.name, likeness->mean, std::move(*image)});
  }
  return {};
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
  if (atlas && series.pictures.empty()) {
    Image atlasPicture = engine_.readAtlas();
    pictures.atlas = encodeJpeg(halved(atlasPicture, budget_.atlasSide), kAtlasQuality).value_or(Bytes());
    const std::vector<std::uint8_t> kinds = engine_.gatherer()->readKinds();
    if (colorByKind(atlasPicture, kinds, series.gathered.back().kinds)) {
      const ReportCrop part =
          fullestPart(atlasPicture.width, atlasPicture.height, kinds, kKindsWidth, kKindsHeight);
      series.kindPicture = encodePng(cropped(atlasPicture, part)).value_or(Bytes());
    }
  }
  series.pictures.push_back(std::move(pictures));
}

}  // namespace tessera::app
