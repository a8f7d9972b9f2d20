// The bound on what rounding positions does to a picture, against projection in double.
#include "codec/wire/pixel_bound.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace tessera::wire {
namespace {

glm::dvec2 pixelOf(const Camera& camera, const glm::dvec3& p) {
  return {(p.x / -p.z - camera.slopes.x) / (camera.slopes.y - camera.slopes.x) * camera.width,
          (p.y / -p.z - camera.slopes.z) / (camera.slopes.w - camera.slopes.z) * camera.height};
}

// Points all over the picture, at all distances, from eyes anywhere within reach. Rounding is at its worst
// half a step.
TEST(PixelBound, HoldsAndIsNotWasteful) {
  std::mt19937 random(2);
  const auto within = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  Camera camera;
  camera.slopes = {-1.2, 1.2, -0.6, 0.6};
  camera.width = 1920;
  camera.height = 960;
  for (const double reach : {0.0, 0.3}) {
    const PixelBound bound = boundOf(camera, 0.1, reach);
    double worst = 0.0;
    for (int i = 0; i < 200000; ++i) {
      const double depth = std::exp(within(std::log(0.06), std::log(1000.0)));
      const glm::dvec3 p(within(-1.2, 1.2) * depth, within(-0.6, 0.6) * depth, -depth);
      // The eye is at the origin; the place that the bound is asked for lies within reach of it.
      glm::dvec3 away(within(-1, 1), within(-1, 1), within(-1, 1));
      away *= reach / std::max(glm::length(away), 1e-9);
      const double step = std::ldexp(1.0, bound.level(glm::length(p - away), 1.0));
      const glm::dvec3 sign(random() % 2 ? 0.5 : -0.5, random() % 2 ? 0.5 : -0.5, random() % 2 ? 0.5 : -0.5);
      worst = std::max(worst, glm::length(pixelOf(camera, p) - pixelOf(camera, p + sign * step)));
    }
    // The gradient is taken at the point itself: over half a step it grows by as much as the depth shrinks.
    EXPECT_LT(worst, 0.1 * 1.001) << reach;
    EXPECT_GT(worst, 0.05) << reach;
  }
}

TEST(PixelBound, LevelsFollowDistanceAndScale) {
  PixelBound bound;
  bound.nearest = 0.25;
  const int at = bound.level(1.0, 1.0);
  EXPECT_EQ(bound.level(2.0, 1.0), at + 1);
  EXPECT_EQ(bound.level(0.5, 1.0), at - 1);
  EXPECT_EQ(bound.level(0.0, 1.0), at - 2);  // the near plane
  EXPECT_EQ(bound.level(1.0, 4.0), at - 2);
  bound.reach = 0.5;
  EXPECT_EQ(bound.level(1.0, 1.0), at - 1);
  EXPECT_EQ(bound.level(std::numeric_limits<double>::infinity(), 1.0), kCoarsestLevel);
  EXPECT_EQ(bound.level(1.0, std::numeric_limits<double>::infinity()), kFinestLevel);
}

TEST(Grid, PositionsAreTheNearestStepsAndFloatsToTheBit) {
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    const auto coordinate = [&] {
      return std::ldexp(std::uniform_real_distribution<float>(-1, 1)(random),
                        static_cast<int>(random() % 60) - 30);
    };
    const glm::vec3 p(coordinate(), coordinate(), coordinate());
    const int asked = static_cast<int>(random() % 60) - 40;
    const int level = levelFor(p, asked);
    ASSERT_GE(level, asked);
    const glm::ivec3 steps = stepsOf(p, level);
    const glm::vec3 back = positionOf(steps, level);
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_LT(std::abs(steps[axis]), kMostSteps);
      ASSERT_LE(std::abs(double(back[axis]) - double(p[axis])), std::ldexp(0.5, level));
      ASSERT_EQ(double(back[axis]), std::ldexp(double(steps[axis]), level));
    }
  }
}

// Against the nearest of many points of the triangle.
TEST(DistanceToTriangle, IsThatOfItsNearestPoint) {
  std::mt19937 random(6);
  const auto within = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  for (int i = 0; i < 400; ++i) {
    glm::dvec3 a(within(), within(), within()), b(within(), within(), within()),
        c(within(), within(), within());
    if (i % 5 == 1) c = b;                  // a line
    if (i % 5 == 2) c = a + 2.0 * (b - a);  // another
    if (i % 5 == 3) b = c = a;              // a point
    double nearest = 1e9;
    constexpr int kSteps = 100;
    for (int u = 0; u <= kSteps; ++u)
      for (int v = 0; u + v <= kSteps; ++v)
        nearest = std::min(nearest,
                           glm::length(a + (b - a) * (double(u) / kSteps) + (c - a) * (double(v) / kSteps)));
    const double found = distanceToTriangle(a, b, c);
    EXPECT_LE(found, nearest + 1e-12);
    EXPECT_GT(found, nearest - 0.03);
  }
}

TEST(Stretch, IsTheLargestScale) {
  glm::dmat4x3 world(1.0);
  const double s = std::sin(0.7), c = std::cos(0.7);
  world[0] = glm::dvec3(c, s, 0) * 3.0;
  world[1] = glm::dvec3(-s, c, 0) * 0.5;
  world[2] = {0, 0, -2};
  EXPECT_NEAR(stretchOf(world), 3.0, 1e-12);
  world[1] = {1, 1, 0};  // sheared: an upper bound
  EXPECT_GE(stretchOf(world), 3.0);
  EXPECT_LT(stretchOf(world), 3.0 * std::sqrt(3.0));
}

}  // namespace
}  // namespace tessera::wire
