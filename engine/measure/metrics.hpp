// Image metrics: MSSIM, PSNR and FLIP of two 8-bit images. No GL.
#pragma once

#include <vector>

#include "engine/core/result.hpp"
#include "engine/image/image.hpp"
#include "engine/measure/acuity.hpp"

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
/// SSIM at the scale that the eye resolves, averaged by the share of the display's cycles that it resolves
/// there. `fovY` is the pictures' vertical field of view in radians, (0, pi). A pixel of acuity scale s (see
/// acuityScales) takes mssim's SSIM between the two levels around log2 s of a pyramid, linearly; each level
/// is half as large, means of 2 x 2 of the luma. Its weight is 1 / s^2, so all that can be told apart has one
/// vote. Counted are the pixels that mssim counts, and where s = 1 everywhere this is mssim's mean; on
/// coarser levels a pixel near the border takes the nearest whole window. Fails as mssim and acuityScales do.
Result<double> acuityMssim(const Image& reference, const Image& test, double fovY,
                           const Foveation& foveation = {});
/// DSSIM = (1 - MSSIM) / 2.
inline double dssim(double mssimMean) { return (1.0 - mssimMean) * 0.5; }
/// PSNR over the three colour channels in dB; infinity for equal images. Fails as mssim does.
Result<double> psnr(const Image& reference, const Image& test);
/// LDR-FLIP (Andersson et al. 2020), error per pixel in 0..1. `pixelsPerDegree` of the observer's visual
/// field, in [1, 1000]. Fails as mssim does, and where pixelsPerDegree is outside its range.
Result<MetricMap> flip(const Image& reference, const Image& test, double pixelsPerDegree = 67.0);

}  // namespace tessera
