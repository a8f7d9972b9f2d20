// How much more a server sees than a viewer shows.
#pragma once

#include <cmath>

#include "engine/frame/view.hpp"

namespace tessera::app {

/// Radians more to each side of a view whose horizontal angle of view is to grow by `share` (Mueller 2021,
/// sec. 7.2: 20 %).
inline double marginOf(const View& view, double share) {
  return share * std::atan(std::tan(view.fovY / 2.0) * view.width / view.height);
}

}  // namespace tessera::app
