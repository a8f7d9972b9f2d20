#include "apps/tessera/compare/pvs.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "apps/tessera/options.hpp"

namespace tessera::app {

namespace {

// Of a picture's angle: pictures that are turned against each other meet in arcs, not along their edges.
constexpr double kOverlap = 2.0 / 3.0;

/// Angles over `range` around 0, no two further apart than `step`.
std::vector<double> turns(double range, double step) {
  const int count = range > 0.0 ? 1 + std::max(1, static_cast<int>(std::ceil(range / step))) : 1;
  std::vector<double> angles;
  for (int i = 0; i < count; ++i) angles.push_back(count == 1 ? 0.0 : range * (i / (count - 1.0) - 0.5));
  return angles;
}

}  // namespace

Result<std::vector<Pvs>> parsePvs(const std::vector<std::string>& texts) {
  std::vector<Pvs> sets;
  for (const std::string& text : texts) {
    if (text == "all") {
      for (const Pvs& set : {Pvs{0.1, 40.0}, Pvs{0.2, 80.0}, Pvs{0.3, 120.0}}) sets.push_back(set);
      continue;
    }
    auto pair = parsePair("--pvs", text);
    if (!pair) return fail("{}, nor 'all'", pair.error().message);
    const auto [radius, degrees] = std::array<double, 2>{pair->x, pair->y};
    if (!(radius >= 0.0 && radius <= 1000.0))
      return fail("--pvs {}: radius {} is outside [0, 1000]", text, radius);
    if (!(degrees >= 0.0 && degrees <= 180.0))
      return fail("--pvs {}: {} degrees are outside [0, 180]", text, degrees);
    sets.push_back({radius, degrees});
  }
  return sets;
}

std::string nameOf(const Pvs& pvs) { return fmt::format("{:g}, {:g}°", pvs.radius, pvs.degrees); }

std::vector<View> pvsViews(const View& view, const Pvs& pvs) {
  const double range = pvs.degrees * std::numbers::pi / 180.0;
  const double fovX = 2.0 * std::atan(std::tan(0.5 * view.fovY) * view.width / view.height);
  const glm::dvec3 right = glm::cross(view.forward, view.up);
  const glm::dmat3 axes(right, view.up, view.forward);
  const double side = pvs.radius / std::sqrt(3.0);
  std::vector<glm::dvec3> places = {glm::dvec3(0.0)};
  if (pvs.radius > 0.0)
    for (const glm::dvec3& corner : {glm::dvec3(1, 1, 1), {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}})
      places.push_back(side * corner);
  std::vector<View> views;
  for (const glm::dvec3& place : places)
    for (const double yaw : turns(range, kOverlap * fovX))
      for (const double pitch : turns(range, kOverlap * view.fovY)) {
        const glm::dvec3 level = std::cos(yaw) * view.forward + std::sin(yaw) * right;
        View turned = view;
        turned.eye += axes * place;
        turned.forward = std::cos(pitch) * level + std::sin(pitch) * view.up;
        turned.up = std::cos(pitch) * view.up - std::sin(pitch) * level;
        views.push_back(turned);
      }
  return views;
}

}  // namespace tessera::app
