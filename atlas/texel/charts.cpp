#include "atlas/texel/charts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {

namespace {

constexpr int kDensities =
    64;  // halvings of the density, from one at which every chart is as large as it may be

double finite(double length) { return std::isfinite(length) ? length : 0.0; }

/// Rounds the longer side up, and the shorter one to what keeps the proportion best.
glsl::TexelChart chartOf(const glm::dvec2& extent, double tilesPerUnit) {
  const double x = finite(extent.x);
  const double y = finite(extent.y);
  const double longer = std::max(x, y);
  constexpr auto kLargest = static_cast<double>(glsl::kTexelLargestLog2);
  const auto log2Tiles = [&](double tiles) { return tiles > 0.0 ? std::log2(tiles) : -kLargest; };
  const double size = std::clamp(std::ceil(log2Tiles(longer * tilesPerUnit)), 0.0, kLargest);
  const auto side = [&](double length) {
    if (length == longer) return static_cast<glsl::uint>(size);
    return static_cast<glsl::uint>(std::clamp(std::round(size + log2Tiles(length / longer)), 0.0, kLargest));
  };
  return {0, side(x) | side(y) << 8u};
}

std::uint64_t tilesOf(const glsl::TexelChart& chart) {
  return glsl::tilesBefore(chart, glsl::recordLevel(chart));
}

}  // namespace

glm::dvec2 patchExtent(const std::array<glm::dvec3, 5>& corners, std::uint32_t triangles) {
  const auto edge = [&](std::size_t a, std::size_t b) { return glm::length(corners[b] - corners[a]); };
  if (triangles == 1) return {edge(0, 1), edge(1, 2)};
  if (triangles == 2) return {std::max(edge(0, 1), edge(2, 3)), std::max(edge(1, 2), edge(0, 3))};
  return {std::max(edge(0, 1) + edge(0, 4), edge(2, 3)), std::max(edge(1, 2), edge(3, 4))};
}

Result<std::vector<glsl::TexelChart>> layOutCharts(std::span<const ChartShape> shapes) {
  double longest = 0.0;
  double shortest = std::numeric_limits<double>::max();
  for (const auto& [extent, single] : shapes) {
    const double longer = std::max(finite(extent.x), finite(extent.y));
    longest = std::max(longest, longer);
    if (longer > 0.0) shortest = std::min(shortest, longer);
  }
  std::vector<glsl::TexelChart> charts(shapes.size());
  double density = longest > 0.0 ? std::ldexp(1.0, glsl::kTexelLargestLog2) / shortest : 1.0;
  for (int i = 0; i <= kDensities; ++i, density *= 0.5) {
    std::uint64_t next = 1;
    for (std::size_t p = 0; p < shapes.size(); ++p) {
      charts[p] = chartOf(shapes[p].extent, density);
      if (shapes[p].single) charts[p].size |= glsl::kChartSingle;
      charts[p].base = static_cast<glsl::uint>(next);
      next += tilesOf(charts[p]);
    }
    if (next <= std::numeric_limits<std::uint32_t>::max()) return charts;
  }
  return fail("texel shading: {} patches have more tiles than there are numbers for", shapes.size());
}

}  // namespace tessera
