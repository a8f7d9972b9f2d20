#include "apps/tessera/accuracy/choose.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/ranges.h>

#include "engine/core/file.hpp"

namespace tessera::app {

namespace {

constexpr std::uint64_t kLargestStudy = std::uint64_t{64} << 20;

std::string withSpread(const Spread& ms) {
  return fmt::format("{:.4g} ms a frame ({:.4g} to {:.4g})", ms.median, ms.low, ms.high);
}

/// The best configuration that is cheaper, or the cheapest that is better: what one more wish would cost.
std::string alternatives(const std::vector<AccuracyPoint>& points, const AccuracyPoint& chosen) {
  const AccuracyPoint* cheaper = nullptr;
  const AccuracyPoint* better = nullptr;
  for (const AccuracyPoint& point : points) {
    if (!point.pareto) continue;
    if (point.ms.median < chosen.ms.median && (cheaper == nullptr || point.ms.median > cheaper->ms.median))
      cheaper = &point;
    if (point.dssim.median < chosen.dssim.median &&
        (better == nullptr || point.ms.median < better->ms.median))
      better = &point;
  }
  std::string text;
  const auto add = [&](const char* what, const AccuracyPoint* point) {
    if (point != nullptr)
      text += fmt::format("\n  {}: {}, {:.4g} ms, DSSIM {:.4g}", what, point->name, point->ms.median,
                          point->dssim.median);
  };
  add("next cheaper", cheaper);
  add("next better", better);
  return text;
}

}  // namespace

Result<Chosen> chooseIn(std::string_view study, const StudyChoice& choice, const std::string& scene) {
  auto points = parseAccuracy(study, choice.file);
  if (!points) return tl::unexpected(points.error());
  // A configuration that this program does not know is a fault of the file, wherever it stands.
  for (std::size_t i = 0; i < points->size(); ++i) {
    auto settings = completed((*points)[i].config);
    if (!settings) return fail("{}: points[{}].config.{}", choice.file, i, settings.error().message);
    (*points)[i].name = nameOf(*settings);
  }
  const std::string wanted = std::filesystem::path(scene).filename().string();
  std::vector<std::string> scenes;
  for (const AccuracyPoint& point : *points)
    if (std::find(scenes.begin(), scenes.end(), point.scene) == scenes.end()) scenes.push_back(point.scene);
  std::erase_if(*points, [&](const AccuracyPoint& point) {
    return std::filesystem::path(point.scene).filename().string() != wanted;
  });
  if (points->empty())
    return fail("{}: points: none is of scene {}, they are of {}", choice.file, wanted,
                fmt::join(scenes, ", "));
  findFront(*points);
  auto best =
      choice.budgetMs ? bestWithin(*points, *choice.budgetMs) : cheapestFor(*points, *choice.targetDssim);
  if (!best) return fail("{}: {}: {}", choice.file, wanted, best.error().message);
  const AccuracyPoint& point = *best->point;
  auto configuration = configurationOf(point.config);
  if (!configuration) return tl::unexpected(configuration.error());
  Chosen chosen{std::move(*configuration), {}};
  chosen.reason = fmt::format(
      "chosen: {}\n  why: of {} configurations of {} in {} the {}\n  measured there: {}, DSSIM {:.4g}",
      point.name, points->size(), wanted, choice.file,
      choice.budgetMs ? fmt::format("best at {:g} ms a frame or less", *choice.budgetMs)
                      : fmt::format("cheapest with a DSSIM of {:g} or less", *choice.targetDssim),
      withSpread(point.ms), point.dssim.median);
  if (best->alike > 0)
    chosen.reason +=
        fmt::format("\n  within its spread: {} other{}", best->alike, best->alike == 1 ? "" : "s");
  chosen.reason += alternatives(*points, point);
  return chosen;
}

Result<Chosen> chooseFrom(const StudyChoice& choice, const std::string& scene) {
  auto bytes = readFile(choice.file, kLargestStudy);
  if (!bytes) return tl::unexpected(bytes.error());
  return chooseIn({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, choice, scene);
}

}  // namespace tessera::app
