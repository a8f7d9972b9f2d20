// Order statistics of repeated measurements. No GL.
#pragma once

#include <cstddef>
#include <span>

namespace tessera {

/// Median and spread of samples, in the samples' unit. NaN in every value where `count` is 0.
struct Statistics {
  std::size_t count = 0;  // finite samples that were used
  double min;
  double max;
  double mean;
  double median;
  double p95;
  double spread;  // interquartile range: p75 - p25

  Statistics();
};

/// Quantile `q` in [0, 1] of samples in rising order, linear between the two nearest (Hyndman and Fan 1996,
/// type 7). NaN for no samples.
double quantileOfSorted(std::span<const double> sorted, double q);

/// Statistics of samples in any order. Samples that are not finite (a timer that was lost) are left out;
/// `count` says how many remain.
Statistics summarize(std::span<const double> samples);

}  // namespace tessera
