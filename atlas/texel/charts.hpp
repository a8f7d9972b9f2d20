// Charts of Texel Shading: which size each patch has in the virtual texture. CPU, load time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "engine/core/result.hpp"
#include "glsl/shared/scene.h"
#include "glsl/shared/texel.h"

namespace tessera {

/// What the chart of a patch follows from: its size, and whether it is a single triangle.
struct ChartShape {
  glm::dvec2 extent{0.0};  // along the chart's axes, in any unit that all patches share
  bool single = false;
};

/// Lengths of a patch along the axes of its chart, in the units of its corners v0 to v4: the longest of the
/// edges that run along each.
glm::dvec2 patchExtent(const std::array<glm::dvec3, 5>& corners, std::uint32_t triangles);

/// A chart for each patch instance of such shapes. All have the same texels a unit of length at their finest
/// level, as many as leave all tiles of all levels a 32-bit number of their own, and no more than
/// 7 * 2^kTexelLargestLog2 along a side. Lengths that are not finite count as 0. Fails where even a tile for
/// each level of each chart is too many.
Result<std::vector<glsl::TexelChart>> layOutCharts(std::span<const ChartShape> shapes);

}  // namespace tessera
