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
