// Visible sets of a camera that may move and turn before the next one is known.
#pragma once

#include <string>
#include <vector>

#include "engine/core/result.hpp"
#include "engine/frame/view.hpp"

namespace tessera::app {

/// How far the camera may go (Hladky 2019, table 1).
struct Pvs {
  double radius = 0.1;    // [0, 1000] in the scene's unit (glTF: metres), to any side
  double degrees = 40.0;  // [0, 180] of turning in all: half of it to either side, up and down
};

/// "0.1,40", or "all" for the paper's three. Fails with what is not two numbers in range.
Result<std::vector<Pvs>> parsePvs(const std::vector<std::string>& texts);
/// "0.1 m, 40°" without the unit's name: what a table calls it.
std::string nameOf(const Pvs& pvs);

/// Views from the eye and from four places around it, the corners of a tetrahedron `radius` away, in as many
/// directions as cover what the turning camera sees; each as wide as `view`, which is not among them.
std::vector<View> pvsViews(const View& view, const Pvs& pvs);

}  // namespace tessera::app
