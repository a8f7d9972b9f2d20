#include "apps/tessera/compare/quality.hpp"

#include <cmath>
#include <limits>
#include <numeric>

#include "apps/tessera/compare/pictures.hpp"
#include "engine/measure/acuity.hpp"

namespace tessera::app {

namespace {

double squaredError(double decibels) { return std::isinf(decibels) ? 0.0 : std::pow(10.0, -decibels / 10.0); }

double decibels(double squaredError) {
  return squaredError == 0.0 ? std::numeric_limits<double>::infinity() : -10.0 * std::log10(squaredError);
}

double plainMean(const std::vector<float>& map) {
  return std::accumulate(map.begin(), map.end(), 0.0) / static_cast<double>(map.size());
}

}  // namespace

Result<Quality> qualityOf(std::span<const Image> references, std::span<const Image> pictures,
                          const MetricChoice& metrics, const std::optional<Foveation>& foveation,
                          double fovY) {
  if (references.size() != pictures.size() || pictures.empty())
    return fail("{} pictures cannot be compared with {} of the reference", pictures.size(),
                references.size());
  std::vector<float> weights;
  if (foveation) {
    auto made = acuityWeights(pictures[0].width, pictures[0].height, fovY, *foveation);
    if (!made) return tl::unexpected(made.error());
    weights = std::move(*made);
  }
  Quality quality;
  double similarity = 0.0;
  double weighted = 0.0;
  double squared = 0.0;
  double difference = 0.0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    auto map = foveation ? mssim(references[i], pictures[i], weights) : mssim(references[i], pictures[i]);
    if (!map) return tl::unexpected(map.error());
    if (foveation) weighted += map->mean;
    quality.mssimViews.push_back(foveation ? plainMean(map->map) : map->mean);
    similarity += quality.mssimViews.back();
    if (metrics.psnr) {
      auto ratio = psnr(references[i], pictures[i]);
      if (!ratio) return tl::unexpected(ratio.error());
      squared += squaredError(*ratio);
    }
    if (metrics.flip) {
      auto errors = flip(references[i], pictures[i]);
      if (!errors) return tl::unexpected(errors.error());
      difference += errors->mean;
      quality.error = std::move(*errors);
    }
    quality.covered += coveredPixels(references[i]);
    quality.holes += holesOf(references[i], pictures[i]);
  }
  const auto eyes = static_cast<double>(pictures.size());
  quality.mssim = similarity / eyes;
  if (foveation) quality.mssimAcuity = weighted / eyes;
  if (metrics.psnr) quality.psnr = decibels(squared / eyes);
  if (metrics.flip) quality.flip = difference / eyes;
  return quality;
}

}  // namespace tessera::app
