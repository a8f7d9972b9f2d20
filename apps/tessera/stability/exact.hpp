// Figures against long double: 64 bits of mantissa, 40 more than the float that is judged.
#pragma once

#include <array>
#include <cmath>
#include <limits>

#include <glm/glm.hpp>

namespace tessera::stability {

using Exact = long double;
using ExactVec = std::array<Exact, 3>;

inline ExactVec exact(const glm::vec3& v) { return {v.x, v.y, v.z}; }
inline ExactVec minus(const ExactVec& a, const ExactVec& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Exact dotOf(const ExactVec& a, const ExactVec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline ExactVec crossOf(const ExactVec& a, const ExactVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Exact lengthOf(const ExactVec& a) { return std::sqrt(dotOf(a, a)); }
inline Exact angleOf(const ExactVec& a, const ExactVec& b) {
  return std::atan2(lengthOf(crossOf(a, minus(b, a))), dotOf(a, b));
}

/// Error over the true value; of a value that is not finite, infinity.
inline double relativeError(Exact value, Exact truth) {
  if (!std::isfinite(value)) return std::numeric_limits<double>::infinity();
  if (value == truth) return 0.0;
  return static_cast<double>(std::abs(value - truth) / std::abs(truth));
}

/// Error in units of the last place of the float nearest to the truth.
inline double ulps(float value, Exact truth) {
  if (!std::isfinite(value)) return std::numeric_limits<double>::infinity();
  const float nearest = std::abs(static_cast<float>(truth));
  const float step = std::nextafter(nearest, std::numeric_limits<float>::infinity()) - nearest;
  return static_cast<double>(std::abs(Exact{value} - truth) / step);
}

}  // namespace tessera::stability
