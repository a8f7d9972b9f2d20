// Needles, triangles without area, tiny and huge ones.
#include <algorithm>
#include <random>

#include "apps/tessera/stability/case.hpp"
#include "apps/tessera/stability/exact.hpp"
#include "engine/scene/build.hpp"
#include "glsl/shared/tess_measure.h"

namespace tessera::stability {

namespace {

/// Edge lengths of right-angled and of isosceles needles, floats that hold the triangle inequality as they
/// are.
std::vector<std::array<float, 3>> needles() {
  std::vector<std::array<float, 3>> sides;
  for (float aspect = 1.0f; aspect <= 1.1e7f; aspect *= 1.37f) {
    const float width = 1.0f / aspect;
    sides.push_back({1.0f, 1.0f, width});
    sides.push_back({1.0f, static_cast<float>(std::hypot(1.0, static_cast<double>(width))), width});
    sides.push_back({1.0f, std::nextafter(1.0f, 2.0f), std::max(width, 4e-7f)});
  }
  return sides;
}

Exact exactArea(const std::array<float, 3>& sides) {
  std::array<Exact, 3> s{sides[0], sides[1], sides[2]};
  std::sort(s.begin(), s.end(), std::greater<>());
  return std::sqrt((s[0] + (s[1] + s[2])) * (s[2] - (s[0] - s[1])) * (s[2] + (s[0] - s[1])) *
                   (s[0] + (s[1] - s[2]))) /
         4;
}

template <class Area>
double worstArea(const Area& area) {
  double worst = 0.0;
  for (const auto& s : needles())
    worst = std::max(worst, relativeError(area(s[0], s[1], s[2]), exactArea(s)));
  return worst;
}

/// Pairs of vectors at angles of 1e-7 to nearly pi, and of lengths from 1e-3 to 1e6.
template <class Angle>
double worstAngle(const Angle& angle, double smallest) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 axis = glm::normalize(glm::vec3(unit(random), unit(random), unit(random)) + 1e-3f);
    const glm::vec3 side = glm::normalize(glm::cross(axis, glm::vec3(unit(random), 1.3f, unit(random))));
    const float wanted = std::pow(10.0f, -7.0f + 7.49f * static_cast<float>(i) / 20000.0f);
    const float reach = std::pow(10.0f, 4.5f * unit(random) + 1.5f);
    const glm::vec3 a = axis * reach;
    const glm::vec3 b = (axis * std::cos(wanted) + side * std::sin(wanted)) * reach;
    const Exact truth = angleOf(exact(a), exact(b));
    if (truth < static_cast<Exact>(smallest)) continue;
    worst = std::max(worst, relativeError(angle(a, b), truth));
  }
  return worst;
}

/// Right-angled needles some metres from the eye: the height that is measured from the angles of the edges.
double worstNeedleHeight(float mostAspect) {
  double worst = 0.0;
  for (float aspect = 1.0f; aspect <= mostAspect; aspect *= 1.7f) {
    const glm::vec3 a(-1.0f, 0.3f, -3.0f);
    const glm::vec3 b(1.0f, 0.3f, -3.0f);
    const glm::vec3 c(1.0f, 0.3f + 2.0f / aspect, -3.0f);
    const Exact e0 = angleOf(exact(b), exact(c));
    const Exact e1 = angleOf(exact(c), exact(a));
    const Exact e2 = angleOf(exact(a), exact(b));
    std::array<Exact, 3> s{e0, e1, e2};
    std::sort(s.begin(), s.end(), std::greater<>());
    const Exact area = std::sqrt((s[0] + (s[1] + s[2])) * (s[2] - (s[0] - s[1])) * (s[2] + (s[0] - s[1])) *
                                 (s[0] + (s[1] - s[2]))) /
                       4;
    const glsl::TessMeasure measure = glsl::measureTriangle(a, b, c, 1000.0f);
    worst = std::max(worst, relativeError(measure.height, 2 * area / s[0] * 1000));
  }
  return worst;
}

Scene whiteTriangles(const std::vector<glm::vec3>& corners, bool backdrop = true) {
  Scene scene = build::emptyScene();
  Material white = build::unlit();
  white.doubleSided = true;
  const auto material = build::addMaterial(scene, white);
  build::place(scene, build::addTriangles(scene, corners, material));
  if (backdrop)
    build::place(scene, build::addGrid(scene, {-9, -6, -6}, {18, 0, 0}, {0, 12, 0}, 3, 2, material));
  build::finish(scene);
  return scene;
}

std::vector<glm::vec3> needleCorners() {
  std::vector<glm::vec3> corners;
  float y = -1.2f;
  for (const float aspect : {1e1f, 1e2f, 1e3f, 1e4f, 1e5f, 1e6f, 1e7f}) {
    const float height = 4.0f / aspect;
    // Right-angled, obtuse, and with the thin end towards the eye.
    corners.insert(corners.end(), {{-2, y, -3}, {2, y, -3}, {2, y + height, -3}});
    corners.insert(corners.end(), {{-2, y + 0.1f, -3}, {2, y + 0.1f, -3}, {0.3f, y + 0.1f + height, -3}});
    corners.insert(corners.end(), {{0, y + 0.2f, 2}, {0, y + 0.2f, -4}, {height, y + 0.2f, -4}});
    y += 0.32f;
  }
  return corners;
}

const std::vector<View>& frontViews() {
  static const std::vector<View> views = {look({0, 0, 0}, {0, 0, -1}, 80.0),
                                          look({0.4, 0.9, -0.5}, {0, 0, -4}),
                                          look({0, 0.02, -2.9}, {0.4, 0.02, -3}, 80.0)};
  return views;
}

}  // namespace

void addTriangleCases(Cases& cases) {
  cases.push_back({"triangles/kahan-area",
                   "the area of needles to an aspect of 1e7 from their float lengths, against long double",
                   "relative error", 4e-7, Sense::AtMost,
                   [](Bench&) { return worstArea(glsl::triangleArea); }});
  cases.push_back({"triangles/heron-fails",
                   "Heron's formula as printed loses all digits of the same needles: the case above can fail",
                   "relative error", 0.5, Sense::AtLeast,
                   [](Bench&) { return worstArea(glsl::triangleAreaByHeron); }});
  cases.push_back(
      {"triangles/angle",
       "angles of 1e-7 to 3.1 rad between vectors of 1e-3 to 1e6, by atan2 of the difference's cross product",
       "relative error", 2e-6, Sense::AtMost, [](Bench&) { return worstAngle(glsl::angleBetween, 1e-7); }});
  cases.push_back({"triangles/acos-fails",
                   "acos of the normalized dot product has no digit left of the small ones", "relative error",
                   0.5, Sense::AtLeast, [](Bench&) { return worstAngle(glsl::angleByAcos, 1e-7); }});
  cases.push_back(
      {"triangles/arc-tangent", "drivers' atan is off by 5e-6 (Mesa 22.3), which needles multiply", "ulp",
       4.0, Sense::AtMost, [](Bench&) -> Result<double> {
         double worst = 0.0;
         for (int i = 0; i < 200000; ++i) {
           const float angle = 3.14159f * (static_cast<float>(i) + 0.5f) / 200000.0f;
           const float y = std::sin(angle);
           const float x = std::cos(angle);
           worst = std::max(worst, ulps(glsl::upperArcTangent(y, x), std::atan2(Exact{y}, Exact{x})));
         }
         return worst;
       }});
  cases.push_back({"triangles/needle-height",
                   "heights in pixels of right-angled needles to an aspect of 1e7, from float corners, "
                   "against long double",
                   "relative error", 1e-3, Sense::AtMost, [](Bench&) { return worstNeedleHeight(1e7f); }});
  cases.push_back({"triangles/needles",
                   "needles of aspect 10 to 1e7, right-angled, obtuse, and towards the eye: "
                   "every pixel white, every texel finite",
                   "bad pixels", 0.0, Sense::AtMost, [](Bench& bench) {
                     return badPixels(bench, whiteTriangles(needleCorners()), {}, frontViews(),
                                      Pixels::White);
                   }});
  cases.push_back({"triangles/without-area",
                   "zero area: collinear, two corners in one place, all three, and an index "
                   "used twice",
                   "bad pixels", 0.0, Sense::AtMost, [](Bench& bench) {
                     std::vector<glm::vec3> corners = {{-1, 0, -3},    {0, 0, -3},     {1, 0, -3},
                                                       {-1, 0.5f, -3}, {-1, 0.5f, -3}, {1, 0.6f, -3},
                                                       {0, 0.3f, -2},  {0, 0.3f, -2},  {0, 0.3f, -2},
                                                       {-1, -1, -3},   {1, -1, -3},    {0, -0.2f, -3}};
                     Scene scene = whiteTriangles(corners);
                     Primitive& primitive = scene.primitives[0];
                     scene.indices[primitive.firstIndex + 10] = scene.indices[primitive.firstIndex + 9];
                     return badPixels(bench, std::move(scene), {}, frontViews(), Pixels::White);
                   }});
  cases.push_back(
      {"triangles/only-without-area",
       "a scene in which no triangle has an area: nothing is visible, and "
       "nothing fails",
       "bad pixels", 0.0, Sense::AtMost, [](Bench& bench) {
         return badPixels(
             bench,
             whiteTriangles(
                 {{-1, 0, -3}, {0, 0, -3}, {1, 0, -3}, {0, 0.3f, -2}, {0, 0.3f, -2}, {0, 0.3f, -2}}, false),
             {}, frontViews(), Pixels::White);
       }});
  cases.push_back({"triangles/1e-6-pixels",
                   "a grid of triangles of 1e-6 pixels each: most are never seen, and those "
                   "that are have a texel",
                   "bad pixels", 0.0, Sense::AtMost, [](Bench& bench) {
                     Scene scene = build::emptyScene();
                     Material white = build::unlit();
                     white.doubleSided = true;
                     const auto material = build::addMaterial(scene, white);
                     // 100 x 100 cells over a tenth of a pixel: one at 3 m is 0.032 m.
                     build::place(scene, build::addGrid(scene, {0, 0, -3}, {0.0045f, 0, 0}, {0, 0.0045f, 0},
                                                        100, 100, material));
                     build::place(scene, build::addGrid(scene, {0.016f, 0.016f, -3}, {0.04f, 0, 0},
                                                        {0, 0.04f, 0}, 100, 100, material));
                     build::finish(scene);
                     return badPixels(bench, std::move(scene), {}, frontViews(), Pixels::White);
                   }});
  cases.push_back({"triangles/1e6-pixels",
                   "triangles of 1e6 pixels and more, of which the view shows a corner: split "
                   "at load, and whole",
                   "bad pixels", 0.0, Sense::AtMost, [](Bench& bench) -> Result<double> {
                     double worst = 0.0;
                     for (const double split : {0.0, 1.0 / 24.0}) {
                       EngineOptions options;
                       options.splitEdges = split;
                       const auto bad = badPixels(
                           bench, whiteTriangles({{-300, -200, -4}, {300, -200, -4}, {0, 400, -4}}, false),
                           {},
                           std::vector<View>{look({0, 0, 0}, {0, 0, -1}), look({0, 0, -3.99}, {5, 0, -4})},
                           Pixels::White, options);
                       if (!bad) return bad;
                       worst += *bad;
                     }
                     return worst;
                   }});
}

}  // namespace tessera::stability
