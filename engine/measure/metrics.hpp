// Image metrics: MSSIM, PSNR and FLIP of two 8-bit images. No GL.
#pragma once

#include <span>
#include <vector>

#include "engine/core/result.hpp"
#include "engine/image/image.hpp"

namespace tessera {

/// A value per pixel and its mean. `map` is width * height floats, rows from the top.
struct MetricMap {
  int width = 0;
  int height = 0;
  std::vector<float> map;
  double mean = 0.0;
};

/// MSSIM of Wang et al. 2004 with the constants of Mueller et al. 2018, sec. 5.6: Gaussian window of 11,
/// sigma 2, C1 1e-4, C2 9e-4, on luma (0.2126, 0.7152, 0.0722) of display-encoded values in 0..1, windows
/// wholly inside the image (the map is 10 smaller in each direction). Images of less than 11 pixels a side
/// use the largest window that fits. Values in -1..1, 1 where the windows are equal. Fails when sizes differ
/// or an image is empty.
Result<MetricMap> mssim(const Image& reference, const Image& test);
/// The same map with a weighted mean: `weights` is width * height of the images, rows from the top, each
/// finite and >= 0, one a pixel; a window counts by the pixel at its middle. Fails also where weights do not
/// fit or are all 0.
Result<MetricMap> mssim(const Image& reference, const Image& test, std::span<const float> weights);
/// DSSIM = (1 - MSSIM) / 2.
inline double dssim(double mssimMean) { return (1.0 - mssimMean) * 0.5; }
/// PSNR over the three colour channels in dB; infinity for equal images. Fails as mssim does.
Result<double> psnr(const Image& reference, const Image& test);
/// LDR-FLIP (Andersson et al. 2020), error per pixel in 0..1. `pixelsPerDegree` of the observer's visual
/// field, in [1, 1000]. Fails as mssim does, and where pixelsPerDegree is outside its range.
Result<MetricMap> flip(const Image& reference, const Image& test, double pixelsPerDegree = 67.0);

}  // namespace tessera
