#include "apps/tessera/compare/quality.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "apps/tessera/compare/pictures.hpp"

namespace tessera::app {

double pooledPsnr(std::span<const double> decibels) {
  double mse = 0.0;
  for (const double db : decibels) mse += std::isinf(db) ? 0.0 : std::pow(10.0, -db / 10.0);
  if (decibels.empty()) return kNotMeasured;
  return mse == 0.0 ? std::numeric_limits<double>::infinity()
                    : -10.0 * std::log10(mse / static_cast<double>(decibels.size()));
}

Result<Quality> qualityOf(std::span<const Image> references, std::span<const Image> pictures,
                          const MetricChoice& metrics, const std::optional<Foveation>& foveation,
                          double fovY) {
  if (references.size() != pictures.size() || pictures.empty())
    return fail("{} pictures cannot be compared with {} of the reference", pictures.size(),
                references.size());
  Quality quality;
  double similarity = 0.0;
  double byAcuity = 0.0;
  std::vector<double> ratios;
  double difference = 0.0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const auto map = mssim(references[i], pictures[i]);
    if (!map) return tl::unexpected(map.error());
    quality.mssimViews.push_back(map->mean);
    similarity += map->mean;
    if (foveation) {
      const auto resolved = acuityMssim(references[i], pictures[i], fovY, *foveation);
      if (!resolved) return tl::unexpected(resolved.error());
      byAcuity += *resolved;
    }
    if (metrics.psnr) {
      auto ratio = psnr(references[i], pictures[i]);
      if (!ratio) return tl::unexpected(ratio.error());
      ratios.push_back(*ratio);
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
  if (foveation) quality.mssimAcuity = byAcuity / eyes;
  quality.psnr = pooledPsnr(ratios);
  if (metrics.flip) quality.flip = difference / eyes;
  return quality;
}

}  // namespace tessera::app
