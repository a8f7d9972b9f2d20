#include "engine/measure/acuity.hpp"

#include <cmath>
#include <numbers>

#include "glsl/shared/acuity.h"

namespace tessera {

Result<void> check(const Foveation& foveation) {
  if (!(std::abs(foveation.gaze.x) <= kGazeFarthest && std::abs(foveation.gaze.y) <= kGazeFarthest))
    return fail("foveation: gaze ({}, {}) is outside [{}, {}]", foveation.gaze.x, foveation.gaze.y,
                -kGazeFarthest, kGazeFarthest);
  if (!(foveation.slope >= 0.0 && foveation.slope <= 10.0))
    return fail("foveation: slope {} is outside [0, 10] degrees a degree", foveation.slope);
  if (!(foveation.smallest > 0.0 && foveation.smallest <= 90.0))
    return fail("foveation: smallest angle {} is outside (0, 90] degrees", foveation.smallest);
  return {};
}

Result<std::vector<float>> acuityScales(int width, int height, double fovY, const Foveation& foveation) {
  if (auto good = check(foveation); !good) return tl::unexpected(good.error());
  if (width < 1 || height < 1) return fail("acuity: a picture of {} x {} pixels", width, height);
  if (!(fovY > 0.0 && fovY < std::numbers::pi))
    return fail("acuity: a field of view of {} radians is outside (0, pi)", fovY);
  // Rays of a rectilinear picture, a unit ahead of the eye.
  const double pixel = 2.0 * std::tan(fovY * 0.5) / height;
  const auto ray = [&](double x, double y) {
    return glm::vec3((x - 0.5 * width) * pixel, (0.5 * height - y) * pixel, -1.0);
  };
  const glm::vec3 gaze = ray(foveation.gaze.x * width, foveation.gaze.y * height);
  const float cycle = glsl::degreesPerCycle(static_cast<float>(height / fovY));
  std::vector<float> scales;
  scales.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float degrees = glsl::angleBetween(gaze, ray(x + 0.5, y + 0.5)) * glsl::kDegreesPerRadian;
      scales.push_back(glsl::acuityScale(degrees, static_cast<float>(foveation.slope),
                                         static_cast<float>(foveation.smallest), cycle));
    }
  return scales;
}

}  // namespace tessera
