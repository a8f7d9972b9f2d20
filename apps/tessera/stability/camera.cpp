// Cameras where they should not be.
#include <algorithm>
#include <random>

#include "apps/tessera/stability/case.hpp"
#include "apps/tessera/stability/exact.hpp"
#include "engine/scene/build.hpp"
#include "glsl/shared/interpolate.h"
#include "glsl/shared/levels.h"

namespace tessera::stability {

namespace {

/// A white box of 4 x 4 x 4 around the origin, seen from both sides, with a board in it.
Scene box(int cells = 3) {
  Scene scene = build::emptyScene();
  Material white = build::unlit();
  white.doubleSided = true;
  const auto material = build::addMaterial(scene, white);
  const auto wall = [&](glm::vec3 origin, glm::vec3 u, glm::vec3 v) {
    build::place(scene, build::addGrid(scene, origin, u, v, cells, cells, material));
  };
  wall({-2, -2, -2}, {4, 0, 0}, {0, 4, 0});
  wall({-2, -2, 2}, {4, 0, 0}, {0, 4, 0});
  wall({-2, -2, -2}, {0, 0, 4}, {0, 4, 0});
  wall({2, -2, -2}, {0, 0, 4}, {0, 4, 0});
  wall({-2, -2, -2}, {4, 0, 0}, {0, 0, 4});
  wall({-2, 2, -2}, {4, 0, 0}, {0, 0, 4});
  build::place(scene, build::addGrid(scene, {-0.5f, -0.5f, -1}, {1, 0.1f, 0}, {0, 1, 0.2f}, 1, 1, material));
  build::finish(scene);
  return scene;
}

Case boxCase(const char* name, const char* why, std::vector<View> views) {
  return {name,
          why,
          "bad pixels",
          0.0,
          Sense::AtMost,
          [views = std::move(views)](Bench& bench) -> Result<double> {
            double sum = 0.0;
            for (const double split : {0.0, 1.0 / 24.0}) {
              EngineOptions options;
              options.splitEdges = split;
              const auto bad = badPixels(bench, box(), {}, views, Pixels::White, options);
              if (!bad) return bad;
              sum += *bad;
            }
            return sum;
          }};
}

/// Rays against triangles that hold the eye, nearly or wholly: coordinates that do not sum to 1 or are not
/// finite.
template <class Meet>
double badRays(const Meet& meet) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  double bad = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const float lift = i % 3 == 0 ? 0.0f : std::pow(10.0f, -10.0f * std::abs(unit(random)));
    const glm::vec3 a(unit(random), lift, unit(random));
    const glm::vec3 b(unit(random), lift, unit(random));
    const glm::vec3 c(unit(random), lift, unit(random));
    const glm::vec3 ray(unit(random), i % 2 == 0 ? 0.0f : lift, unit(random));
    const glm::vec3 at = meet(ray, a, b, c);
    const float largest = std::max({1.0f, std::abs(at.x), std::abs(at.y), std::abs(at.z)});
    const bool good = std::isfinite(at.x) && std::isfinite(at.y) && std::isfinite(at.z) &&
                      std::abs(at.x + at.y + at.z - 1.0f) <= 1e-6f * largest;
    bad += good ? 0.0 : 1.0;
  }
  return bad;
}

/// The textbook way: the point on the triangle's plane, then areas.
glm::vec3 meetPlane(const glm::vec3& ray, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::vec3 n = glm::cross(b - a, c - a);
  const glm::vec3 p = ray * (glm::dot(n, a) / glm::dot(n, ray));
  const float whole = glm::dot(n, n);
  const float x = glm::dot(glm::cross(c - b, p - b), n) / whole;
  const float y = glm::dot(glm::cross(a - c, p - c), n) / whole;
  return {x, y, 1.0f - x - y};
}

/// Small triangles far away, hit in the middle: coordinates against long double.
template <class Meet>
double worstFarRay(const Meet& meet) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  double worst = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const glm::vec3 centre = glm::normalize(glm::vec3(unit(random), unit(random), 1.5f)) * 1000.0f;
    const glm::vec3 a = centre + glm::vec3(unit(random), unit(random), unit(random));
    const glm::vec3 b = a + glm::vec3(1.0f, 0.2f * unit(random), 0.0f);
    const glm::vec3 c = a + glm::vec3(0.2f * unit(random), 1.0f, 0.0f);
    const glm::vec3 ray = (a + b + c) / 3.0f;
    const glm::vec3 at = meet(ray, a, b, c);
    const ExactVec r = exact(ray);
    const std::array<Exact, 3> v = {dotOf(r, crossOf(exact(b), exact(c))),
                                    dotOf(r, crossOf(exact(c), exact(a))),
                                    dotOf(r, crossOf(exact(a), exact(b)))};
    const Exact sum = v[0] + v[1] + v[2];
    for (int k = 0; k < 3; ++k)
      worst = std::max(worst, static_cast<double>(std::abs(at[k] - v[static_cast<std::size_t>(k)] / sum)));
  }
  return worst;
}

/// The three volumes as printed, each of corners instead of an edge.
glm::vec3 meetByCorners(const glm::vec3& ray, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::vec3 volumes(glm::dot(ray, glm::cross(b, c)), glm::dot(ray, glm::cross(c, a)),
                          glm::dot(ray, glm::cross(a, b)));
  return volumes / (volumes.x + volumes.y + volumes.z);
}

/// Where points in view land, in pixels of a picture 1080 high, against long double.
double worstProjection(double fovYDegrees) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  View view = lookAt({0.3, 1.7, 4.0}, {0.1, 0.2, -3.0}, fovYDegrees, 1920, 1080, 0.01);
  const glsl::ViewGpu gpu = viewGpu(view, {0, 0, 0});
  const auto f = 1 / std::tan(static_cast<Exact>(view.fovY) / 2);
  const glm::dvec3 right = glm::normalize(glm::cross(view.forward, view.up));
  const glm::dvec3 up = glm::cross(right, view.forward);
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double depth = std::pow(10.0, 1.5 + 1.5 * unit(random));
    const double reach = depth / static_cast<double>(f);
    const glm::vec3 p(view.eye + view.forward * depth + right * (reach * unit(random)) +
                      up * (reach * unit(random)));
    const glm::vec4 clip = gpu.viewProjection * glm::vec4(p, 1.0f);
    Exact x = 0;
    Exact y = 0;
    Exact z = 0;
    for (int k = 0; k < 3; ++k) {
      const Exact d = Exact{p[k]} - static_cast<Exact>(view.eye[k]);
      x += d * static_cast<Exact>(right[k]);
      y += d * static_cast<Exact>(up[k]);
      z += d * static_cast<Exact>(view.forward[k]);
    }
    const Exact trueX = f * x / z;
    const Exact trueY = f * y / z;
    worst = std::max({worst, static_cast<double>(std::abs(clip.x * 1920.0f / 1080.0f / clip.w - trueX) * 540),
                      static_cast<double>(std::abs(clip.y / clip.w - trueY) * 540)});
  }
  return worst;
}

}  // namespace

void addCameraCases(Cases& cases) {
  cases.push_back(boxCase(
      "camera/on-a-vertex", "the eye is a corner of a triangle: its direction is 0 / 0",
      {look({-0.5, -0.5, -1}, {0, 0, -3}), look({2, 2, 2}, {0, 0, 0}), look({-2, -2, -2}, {1, 2, 1}, 90.0)}));
  cases.push_back(boxCase("camera/on-an-edge",
                          "the eye lies on an edge of one wall, and on the diagonal of a quad",
                          {look({0, -0.45, -1}, {0, 0.3, -4}), look({0, -2, 0}, {0.3, 1, -1}, 90.0)}));
  cases.push_back(
      boxCase("camera/on-two-walls",
              "the eye lies on the edge where two walls meet, so both cross the picture with w = 0",
              {look({2, 0.25, 2}, {0, 0, 0})}));
  cases.push_back(boxCase("camera/in-a-plane", "the eye lies in the plane of triangles that cross the view",
                          {look({0.3, -2, 0.2}, {0.1, -2, -1}), look({2, 0.1, 0.3}, {2, 0, -1}, 100.0),
                           look({0, 0, 2}, {1, 0.2, 2}, 90.0)}));
  cases.push_back(boxCase("camera/inside-a-wall", "the near plane cuts the wall that the eye stands in",
                          {look({0, 0, -1.995}, {0, 0, -3}), look({0, 0, -2.005}, {0, 0, 3}),
                           look({0, 0, -2}, {0, 0, 3}), look({1.9999, 0.3, 0.1}, {3, 0, 0})}));
  cases.push_back(
      boxCase("camera/behind-and-near", "corners behind the eye, at w = 0, and near-plane crossings",
              {look({0, 0, -0.9}, {0.2, 0.1, -1}, 120.0), look({0, -1.99, 0}, {0, -1.99, -2}, 60.0),
               look({0, 0, -2.5}, {0, 0, 3}, 60.0, 2.6), look({0.1, 0.2, 0.1}, {0, 0, -1}, 60.0, 1.9)}));
  cases.push_back(boxCase("camera/field-0.1-degrees",
                          "a field of view of a tenth of a degree: a triangle has 1e6 pixels",
                          {look({0, 0, 0}, {0.1, 0.2, -1}, 0.1), look({0.3, 0.2, 1.9}, {2, 2, -2}, 0.1)}));
  cases.push_back(
      boxCase("camera/field-175-degrees",
              "a field of view of 175 degrees: pixels at the border are seen "
              "under 1e-3 of the angle of those in the middle",
              {look({0, 0, 0}, {0.1, 0.2, -1}, 175.0), look({1.5, -1.5, 1.5}, {0, 0, 0}, 175.0)}));
  cases.push_back(
      boxCase("camera/straight-up", "looking along the axis that is up elsewhere",
              {look({0, 0, 0}, {0, 1, 0}), look({0, 0, 0}, {0, -1, 1e-9}), look({0, 0, 0}, {0, 0, 0})}));
  cases.push_back({"camera/rays-in-the-plane",
                   "rays from an eye in, or 1e-10 off, the plane of the triangle they meet: "
                   "coordinates are finite and sum to 1",
                   "bad rays", 0.0, Sense::AtMost,
                   [](Bench&) -> Result<double> { return badRays(glsl::rayBarycentrics); }});
  cases.push_back({"camera/plane-distance-fails", "the point on the plane first, as textbooks have it: 0 / 0",
                   "bad rays", 100.0, Sense::AtLeast,
                   [](Bench&) -> Result<double> { return badRays(meetPlane); }});
  cases.push_back({"camera/rays-to-far-triangles",
                   "triangles a thousandth of their distance large, hit in the middle", "error", 1e-4,
                   Sense::AtMost,
                   [](Bench&) -> Result<double> { return worstFarRay(glsl::rayBarycentrics); }});
  cases.push_back({"camera/corner-volumes-fail",
                   "the same by volumes of corners instead of edges: they cancel", "error", 0.01,
                   Sense::AtLeast, [](Bench&) -> Result<double> { return worstFarRay(meetByCorners); }});
  cases.push_back(
      {"camera/projection-0.1-degrees",
       "where points land under a field of view of 0.1 degrees. A pixel is "
       "1.6e-6 rad, 14 units of a float's last place of the direction: no matrix of floats has more",
       "pixels", 0.25, Sense::AtMost, [](Bench&) -> Result<double> { return worstProjection(0.1); }});
  cases.push_back({"camera/projection-175-degrees", "where points land under a field of view of 175 degrees",
                   "pixels", 0.01, Sense::AtMost,
                   [](Bench&) -> Result<double> { return worstProjection(175.0); }});
}

}  // namespace tessera::stability
