// Charts of the patches of a drawn scene, for Texel Shading. CPU only.
#pragma once

#include <vector>

#include "atlas/texel/charts.hpp"
#include "engine/frame/batches.hpp"

namespace tessera {

/// A chart for each patch instance, by its size in the world at time 0. Fails where layOutCharts does.
Result<std::vector<glsl::TexelChart>> chartsOf(const Scene& scene, const DrawScene& draw);

}  // namespace tessera
