#include "codec/wire/pixel_bound.hpp"

#include <algorithm>
#include <cmath>

namespace tessera::wire {

int PixelBound::level(double distance, double scale) const {
  const double from = std::max(distance - reach, nearest);
  const double step = 2.0 * pixels * from / (std::sqrt(3.0) * focal * (1.0 + widestSlope2) * scale);
  if (!(step > 0.0)) return kFinestLevel;
  if (!std::isfinite(step)) return kCoarsestLevel;
  return std::clamp(std::ilogb(step), kFinestLevel, kCoarsestLevel);
}

PixelBound boundOf(const Camera& camera, double pixels, double reach) {
  const glm::dvec4& s = camera.slopes;
  const double across = std::max(std::abs(s.x), std::abs(s.y));
  const double up = std::max(std::abs(s.z), std::abs(s.w));
  PixelBound bound;
  bound.pixels = pixels;
  bound.focal = std::max(camera.width / (s.y - s.x), camera.height / (s.w - s.z));
  bound.widestSlope2 = across * across + up * up;
  bound.nearest = camera.zNear;
  bound.reach = reach;
  return bound;
}

int levelFor(const glm::vec3& position, int level) {
  const float largest = std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
  if (!(largest > 0.0f)) return level;
  // |position| < 2^(e + 1), and rounding may reach that: 2^22 steps at most.
  return std::max(level, std::ilogb(largest) + 1 - 22);
}

glm::ivec3 stepsOf(const glm::vec3& position, int level) {
  return glm::ivec3(static_cast<int>(std::lrint(std::ldexp(static_cast<double>(position.x), -level))),
                    static_cast<int>(std::lrint(std::ldexp(static_cast<double>(position.y), -level))),
                    static_cast<int>(std::lrint(std::ldexp(static_cast<double>(position.z), -level))));
}

glm::vec3 positionOf(const glm::ivec3& steps, int level) {
  return {std::ldexp(static_cast<float>(steps.x), level), std::ldexp(static_cast<float>(steps.y), level),
          std::ldexp(static_cast<float>(steps.z), level)};
}

double distanceToTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const auto toEdge = [](const glm::dvec3& p, const glm::dvec3& q) {
    const glm::dvec3 along = q - p;
    const double length2 = glm::dot(along, along);
    const double t = length2 > 0.0 ? std::clamp(-glm::dot(p, along) / length2, 0.0, 1.0) : 0.0;
    return glm::length(p + t * along);
  };
  const double edges = std::min({toEdge(a, b), toEdge(b, c), toEdge(c, a)});
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double length = glm::length(normal);
  if (!(length > 0.0)) return edges;
  // The origin's foot on the plane lies in the triangle where it is on the inner side of every edge.
  const auto inside = [&](const glm::dvec3& p, const glm::dvec3& q) {
    return glm::dot(glm::cross(q - p, -p), normal) >= 0.0;
  };
  if (inside(a, b) && inside(b, c) && inside(c, a))
    return std::min(edges, std::abs(glm::dot(a, normal)) / length);
  return edges;
}

double stretchOf(const glm::dmat4x3& world) {
  double largest = 0.0;
  for (int i = 0; i < 3; ++i) {
    double row = 0.0;
    for (int k = 0; k < 3; ++k) row += std::abs(glm::dot(world[i], world[k]));
    largest = std::max(largest, row);
  }
  return std::sqrt(largest);
}

}  // namespace tessera::wire
