// The measure of a patch in long double, by other formulas than the shared header's.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/glm.hpp>

namespace tessera::test {

using Long = long double;
using LongVector = glm::vec<3, Long>;
using Corners = std::array<glm::vec3, 5>;

inline Long length(const LongVector& v) { return std::sqrt(glm::dot(v, v)); }
inline Long angle(const glm::vec3& a, const glm::vec3& b) {
  return std::atan2(length(glm::cross(LongVector(a), LongVector(b))), glm::dot(LongVector(a), LongVector(b)));
}
/// From edge lengths by the law of cosines: neither Heron's nor Kahan's form.
inline Long area(Long a, Long b, Long c) {
  const Long cosine = (a * a + b * b - c * c) / (2 * a * b);
  return a * b * std::sqrt(std::max(Long{0}, (1 - cosine) * (1 + cosine))) / 2;
}

/// A patch measured in long double, with the conditioning of its area on its edge lengths.
struct Reference {
  Long logArea = 0;
  Long logAspect = 0;
  Long condition = 0;  // how much a relative error of the lengths grows in the area
};
inline Reference referenceMeasure(const Corners& v, unsigned triangles, Long pixels) {
  Long sum = 0;
  Long condition = 0;
  const auto add = [&](int i, int j, int k) {
    const Long a = angle(v[i], v[j]);
    const Long b = angle(v[j], v[k]);
    const Long c = angle(v[i], v[k]);
    const Long longest = std::max({a, b, c});
    const Long one = area(a, b, c);
    sum += one;
    condition += longest * longest * longest * longest / one;
  };
  add(0, 1, 2);
  Long x = angle(v[0], v[1]);
  Long y = angle(v[1], v[2]);
  if (triangles == 1) sum *= 2;
  if (triangles >= 2) add(0, 2, 3);
  if (triangles == 2) {
    x = std::max(x, angle(v[2], v[3]));
    y = std::max(y, angle(v[3], v[0]));
  }
  if (triangles == 3) {
    add(0, 3, 4);
    x = std::max(x + angle(v[0], v[4]), angle(v[2], v[3]));
    y = std::max(y, angle(v[3], v[4]));
  }
  return {std::log2(sum * pixels * pixels), std::log2(x / y), condition / sum};
}

}  // namespace tessera::test
