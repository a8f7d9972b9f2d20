// What the eye can resolve of a picture: less, the farther from where it looks.
#pragma once

#include <vector>

#include <glm/vec2.hpp>

#include "engine/core/result.hpp"

namespace tessera {

/// How far from the picture's top left a gaze may lie, in shares of the picture's size.
inline constexpr double kGazeFarthest = 10.0;

/// Where the eye looks and how its resolution falls off: the smallest angle it resolves is
/// slope * eccentricity + smallest, in degrees (Mueller 2021, eq. 4.1; numbers of Guenter et al. 2012).
struct Foveation {
  glm::dvec2 gaze{0.5, 0.5};     // share of the picture from its top left, within kGazeFarthest
  double slope = 0.022;          // degrees a degree, [0, 10]
  double smallest = 1.0 / 48.0;  // degrees at the gaze, (0, 90]
};

/// Fails with the number that is outside its range.
Result<void> check(const Foveation& foveation);

/// Acuity scale s of each pixel of a picture, rows from the top: how many times larger than the display's
/// smallest cycle, of two pixels, the smallest is that the eye resolves there (eq. 4.2), at least 1. `fovY`
/// in radians, (0, pi). Fails where check() does, and for a size below 1 or a field of view outside its
/// range.
Result<std::vector<float>> acuityScales(int width, int height, double fovY, const Foveation& foveation = {});

}  // namespace tessera
