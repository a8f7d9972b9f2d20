// Colours for error maps. No GL.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "engine/image/image.hpp"
#include "engine/measure/metrics.hpp"

namespace tessera {

using Rgb8 = std::array<std::uint8_t, 3>;

/// Evenly spaced colours from value 0 (black) to value 1 (pale yellow), rising in lightness all the way, in
/// the manner of matplotlib's "magma". Between them the map is linear in display-encoded values: a legend can
/// be a plain gradient.
std::span<const Rgb8> colormapStops();
/// The colour of `value`, clamped to 0..1. NaN gives cyan, which the map has nowhere else.
Rgb8 colormap(float value);
/// A picture of errors per pixel, 0 dark; `full` (> 0) is the error that gets the brightest colour.
Image errorMap(const MetricMap& error, float full = 1.0F);
/// The errors (1 - similarity) / 2 of an MSSIM map, in 0..1, for errorMap.
MetricMap dissimilarity(const MetricMap& similarity);

}  // namespace tessera
