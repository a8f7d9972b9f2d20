#include "engine/view/camera.hpp"

#include <gtest/gtest.h>

namespace tessera {
namespace {

// Where a world position is in the picture, in [-1, 1], and its depth.
glm::dvec3 seen(const wire::Camera& camera, const glm::dvec3& world) {
  const glm::dvec4 clip = view::viewProjection(camera) * glm::dvec4(world - camera.eye, 1.0);
  return glm::dvec3(clip) / clip.w;
}

TEST(ViewerCamera, LooksAtItsTarget) {
  const auto camera = view::lookAt({1, 2, 3}, {4, 2, 3}, 90.0, 200, 100, 0.5);
  const glm::dvec3 centre = seen(camera, {11, 2, 3});
  EXPECT_NEAR(centre.x, 0.0, 1e-12);
  EXPECT_NEAR(centre.y, 0.0, 1e-12);
  EXPECT_NEAR(centre.z, 0.5 / 10.0, 1e-12);  // near / distance
  // 45 degrees up is the upper edge; along +x, right is +z, and the picture is twice as wide.
  EXPECT_NEAR(seen(camera, {2, 3, 3}).y, 1.0, 1e-12);
  EXPECT_NEAR(seen(camera, {2, 2, 5}).x, 1.0, 1e-12);
}

TEST(ViewerCamera, LooksStraightDown) {
  const auto camera = view::lookAt({0, 5, 0}, {0, 0, 0}, 90.0, 100, 100, 0.1);
  EXPECT_NEAR(seen(camera, {0, 0, -5}).y, 1.0, 1e-9);
  EXPECT_NEAR(seen(camera, {5, 0, 0}).x, 1.0, 1e-9);
}

TEST(ViewerCamera, AnotherSizeKeepsTheHeightsAngle) {
  const auto camera = view::resized(view::lookAt({0, 0, 0}, {0, 0, -1}, 90.0, 200, 100, 0.1), 50, 100);
  EXPECT_NEAR(camera.slopes.w, 1.0, 1e-12);
  EXPECT_NEAR(camera.slopes.y, 0.5, 1e-12);
}

TEST(ViewerCamera, AsksForNoMoreThanServersDraw) {
  const auto of = [](double fovY, std::uint32_t width, std::uint32_t height) {
    return view::lookAt({0, 0, 0}, {0, 0, -1}, fovY, width, height, 0.1);
  };
  const wire::Camera usual = of(60, 1280, 720);
  EXPECT_EQ(view::askable(usual).slopes, usual.slopes);
  EXPECT_EQ(view::askable(usual).width, 1280u);
  for (const wire::Camera& camera :
       {of(60, 7680, 4320), of(60, 1280, 50), of(150, 3000, 1000), of(60, 16384, 100), of(1, 16, 9000),
        of(178, 500, 500), of(1, 1, 4000)}) {
    SCOPED_TRACE(testing::Message() << camera.width << " x " << camera.height << ", " << camera.slopes[3]);
    const wire::Camera asked = view::askable(camera);
    EXPECT_LE(std::max(asked.width, asked.height), wire::kMostViewSide);
    EXPECT_LE(asked.width * asked.height, wire::kMostViewPixels);
    EXPECT_GE(std::min(asked.slopes[1], asked.slopes[3]), wire::kLeastSlope);
    EXPECT_LE(std::max(asked.slopes[1], asked.slopes[3]), wire::kMostSlope);
    EXPECT_NEAR(asked.slopes[1] * asked.height, asked.slopes[3] * asked.width,
                1e-9 * asked.slopes[3] * asked.width);
    EXPECT_EQ(asked.slopes[0], -asked.slopes[1]);
    EXPECT_EQ(asked.slopes[2], -asked.slopes[3]);
  }
  // Too many pixels: the same picture, coarser. Too wide: as fine, less of it.
  const wire::Camera coarse = view::askable(of(60, 7680, 4320));
  EXPECT_NEAR(coarse.slopes[3], std::tan(glm::radians(30.0)), 1e-3);
  EXPECT_GT(coarse.width * coarse.height, 16'500'000u);
  const wire::Camera strip = view::askable(of(60, 1280, 50));
  EXPECT_EQ(strip.height, 50u);
  EXPECT_NEAR(strip.width, 1280 * 10.989 / (std::tan(glm::radians(30.0)) * 25.6), 2.0);
}

TEST(ViewerCamera, EyesStandApart) {
  const auto camera = view::lookAt({0, 0, 0}, {0, 0, -1}, 90.0, 100, 100, 0.1);
  EXPECT_NEAR(view::eyeOf(camera, 0.06, -1).eye.x, -0.03, 1e-12);
  EXPECT_NEAR(view::eyeOf(camera, 0.06, 1).eye.x, 0.03, 1e-12);
}

TEST(FlyCamera, TurnsAndMovesAlongItsOwnAxes) {
  view::FlyCamera fly;
  fly.set(view::lookAt({1, 1, 1}, {1, 1, 0}, 60.0, 100, 100, 0.1));
  fly.turn(glm::radians(90.0), 0.0);  // to the right: now along +x
  fly.move({0, 0, 2});
  EXPECT_NEAR(fly.camera().eye.x, 3.0, 1e-9);
  EXPECT_NEAR(fly.camera().eye.z, 1.0, 1e-9);
  fly.turn(0.0, 10.0);  // stops short of the vertical
  EXPECT_GT(view::axesOf(fly.camera())[1].y, 0.0);
  EXPECT_LT(-view::axesOf(fly.camera())[2].y, 1.0);
}

TEST(FlyCamera, TakesAViewAsItIs) {
  view::FlyCamera fly;
  const auto camera = view::lookAt({1, 2, 3}, {-4, 1, 7}, 60.0, 100, 100, 0.1);
  fly.set(camera);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_LT(glm::distance(view::axesOf(fly.camera())[axis], view::axesOf(camera)[axis]), 1e-9);
}

}  // namespace
}  // namespace tessera
