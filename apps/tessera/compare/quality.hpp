// How close a method's pictures of a frame come to forward's.
#pragma once

#include <optional>
#include <span>

#include "apps/tessera/compare/options.hpp"
#include "apps/tessera/report/report.hpp"
#include "engine/measure/metrics.hpp"

namespace tessera::app {

/// Means over the eyes' pictures, or sums where it says so.
struct Quality {
  double mssim = kNotMeasured;
  std::vector<double> mssimViews;     // of each eye
  double mssimAcuity = kNotMeasured;  // where the eye resolves more counts for more; of foveated frames
  double psnr = kNotMeasured;         // of the mean squared error
  double flip = kNotMeasured;
  std::size_t covered = 0;         // pixels of the references with a surface, sum
  std::size_t holes = 0;           // of those, pixels that the method leaves open, sum
  std::optional<MetricMap> error;  // FLIP of the last eye
};

/// The PSNR of all pictures together is that of their mean squared error: means of decibels hide the bad
/// ones. kNotMeasured without any.
double pooledPsnr(std::span<const double> decibels);

/// `foveation` with the vertical field of view of the pictures, for mssimAcuity. Fails where the pictures do
/// not match.
Result<Quality> qualityOf(std::span<const Image> references, std::span<const Image> pictures,
                          const MetricChoice& metrics, const std::optional<Foveation>& foveation,
                          double fovY);

}  // namespace tessera::app
