// What the tests of the tessellation gatherer compare with: the tessellator's pattern drawn ring by ring in
// long double, and bilinear filtering of texels that may be missing.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

namespace tessera::test {

using Long = long double;
using Bary = std::array<Long, 3>;

/// All samples of OpenGL's equal-spaced pattern in point mode, in no particular order. OpenGL 4.6,
/// sec. 11.2.2.2: concentric triangles, each edge of which has two segments less than the one around it; the
/// outermost is then subdivided anew by the outer levels.
inline std::vector<Bary> pattern(const std::array<unsigned, 3>& outer, unsigned inner) {
  if (inner == 1 && outer[0] + outer[1] + outer[2] > 3) inner = 2;
  std::vector<Bary> samples;
  const auto ring = [&](const std::array<Bary, 3>& corners, const std::array<unsigned, 3>& segments) {
    for (unsigned corner = 0; corner < 3; ++corner)
      for (unsigned step = 0; step < segments[corner]; ++step) {
        const Long t = static_cast<Long>(step) / segments[corner];
        Bary at{};
        for (unsigned axis = 0; axis < 3; ++axis)
          at[axis] = corners[corner][axis] * (1 - t) + corners[(corner + 1) % 3][axis] * t;
        samples.push_back(at);
      }
  };
  // The segment from corner c to the next one is the edge where coordinate c + 2 is zero.
  ring({Bary{1, 0, 0}, Bary{0, 1, 0}, Bary{0, 0, 1}}, {outer[2], outer[0], outer[1]});
  std::array<Bary, 3> corners{Bary{1, 0, 0}, Bary{0, 1, 0}, Bary{0, 0, 1}};
  for (int segments = static_cast<int>(inner); segments >= 2;) {
    // The corner of the next triangle: where perpendiculars on the two edges, through the first subdivision
    // of each, meet. In coordinates of an equilateral triangle that is 2/3 of a segment along the bisector's
    // two neighbours.
    std::array<Bary, 3> next{};
    for (unsigned c = 0; c < 3; ++c)
      for (unsigned axis = 0; axis < 3; ++axis)
        next[c][axis] = corners[c][axis] +
                        (corners[(c + 1) % 3][axis] + corners[(c + 2) % 3][axis] - 2 * corners[c][axis]) * 2 /
                            (3 * static_cast<Long>(segments));
    corners = next;
    segments -= 2;
    if (segments == 0)
      samples.push_back(corners[0]);
    else if (segments > 0)
      ring(corners, {static_cast<unsigned>(segments), static_cast<unsigned>(segments),
                     static_cast<unsigned>(segments)});
  }
  return samples;
}

inline glm::vec3 toFloat(const Bary& at) {
  return {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])};
}

/// A point inside of the triangle; every third one lies on an edge, a bisector or a corner, or very close to
/// it.
inline glm::vec3 randomBary(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  float u = unit(random);
  float v = unit(random);
  if (u + v > 1.0f) {
    u = 1.0f - u;
    v = 1.0f - v;
  }
  glm::vec3 at(u, v, std::max(1.0f - u - v, 0.0f));
  const unsigned special = random() % 12;
  const auto c = static_cast<int>(random() % 3);
  const int next = (c + 1) % 3;
  const int previous = (c + 2) % 3;
  if (special == 0) at[c] = 0.0f;
  if (special == 1) at[c] = at[next];
  if (special == 2) at = glm::vec3(0.0f), at[c] = 1.0f;
  if (special == 3) at[c] = 1e-6f * unit(random), at[next] = unit(random), at[previous] = 1.0f - at[next];
  return at / (at.x + at.y + at.z);
}

/// What interpolation must reproduce, and how far apart its values over a triangle are.
inline Long linear(const Bary& at) { return 3 * at[0] - 2 * at[1] + at[2]; }
constexpr Long kRange = 5;

/// Texels by place.
using Texels = std::map<std::pair<int, int>, Long>;

/// A bilinear fetch at `at`, in coordinates where texels lie at whole numbers. False where a tap with more
/// than a millionth of the weight finds no texel.
inline bool fetch(const Texels& texels, glm::vec2 at, Long& value) {
  const int x = static_cast<int>(std::floor(at.x));
  const int y = static_cast<int>(std::floor(at.y));
  const Long s = static_cast<Long>(at.x) - x;
  const Long t = static_cast<Long>(at.y) - y;
  value = 0;
  for (int tap = 0; tap < 4; ++tap) {
    const int dx = tap % 2;
    const int dy = tap / 2;
    const Long weight = (dx == 1 ? s : 1 - s) * (dy == 1 ? t : 1 - t);
    if (weight <= 1e-6L) continue;
    const auto found = texels.find({x + dx, y + dy});
    if (found == texels.end()) return false;
    value += weight * found->second;
  }
  return true;
}

}  // namespace tessera::test
