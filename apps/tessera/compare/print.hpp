// What `tessera compare` prints of a scene.
#pragma once

#include "apps/tessera/report/report.hpp"

namespace tessera::app {

/// A line a method; then, where there are any, what atlases hold, cells of a moving camera, curves and crops.
void printSummary(const ReportScene& scene);

}  // namespace tessera::app
