// SSIM window by window, for the metrics that average it; not part of the API.
#pragma once

#include <functional>

#include "engine/image/image.hpp"
#include "engine/measure/metrics.hpp"

namespace tessera {

/// Writes the luma of a row of a picture, one value a pixel. Called from two threads at once.
using LumaRow = std::function<void(int row, double* out)>;

/// Rows of an image's luma (0.2126, 0.7152, 0.0722) of display-encoded values, in 0..1. Borrows `image`.
LumaRow lumaOf(const Image& image);

/// SSIM of each window, and its mean, of two pictures of this size, each at least 1; see mssim.
MetricMap ssimMap(int width, int height, const LumaRow& reference, const LumaRow& test);

}  // namespace tessera
