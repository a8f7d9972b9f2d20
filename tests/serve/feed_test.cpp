// Cameras between the engine and the stream: the same both ways, and bounds on what a viewer may ask for.
#include "engine/stream/feed.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace tessera {
namespace {

View view() { return lookAt({3, -2, 5}, {-1, 4, 0.5}, 50.0, 640, 360, 0.1); }

TEST(Feed, CamerasComeBackAsTheyWent) {
  const View from = view();
  const auto to = viewOf(cameraOf(from));
  ASSERT_TRUE(to) << to.error().message;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(to->eye[i], from.eye[i]);
    EXPECT_NEAR(to->forward[i], from.forward[i], 1e-12);
    EXPECT_NEAR(to->up[i], from.up[i], 1e-12);
  }
  EXPECT_NEAR(to->fovY, from.fovY, 1e-12);
  EXPECT_EQ(to->zNear, from.zNear);
  EXPECT_EQ(to->width, 640);
  EXPECT_EQ(to->height, 360);
}

void expectRefused(const wire::Camera& camera, const std::string& named) {
  const auto view = viewOf(camera);
  ASSERT_FALSE(view) << named;
  EXPECT_NE(view.error().message.find(named), std::string::npos) << view.error().message;
}

TEST(Feed, CamerasBeyondWhatTheEngineDrawsAreRefused) {
  const wire::Camera good = cameraOf(view());
  const auto with = [&](const auto& change) {
    wire::Camera camera = good;
    change(camera);
    return camera;
  };
  expectRefused(with([](auto& c) { c.width = 0; }), "0 x 360");
  expectRefused(with([](auto& c) { c.width = 8193; }), "8193 x 360");
  expectRefused(with([](auto& c) { c.width = c.height = 8192, c.slopes = {-1, 1, -1, 1}; }), "16777216");
  expectRefused(with([](auto& c) { c.slopes[0] *= 1.01; }), "square pixels");
  expectRefused(with([](auto& c) { c.slopes[1] *= 1.01; }), "square pixels");
  expectRefused(with([](auto& c) { c.slopes *= 20.0; }), "a slope of");
  expectRefused(with([](auto& c) { c.slopes *= 1e-4; }), "a slope of");
  expectRefused(with([](auto& c) { c.zNear = 1e-300; }), "near plane");
  expectRefused(with([](auto& c) { c.zNear = 1e300; }), "near plane");
  expectRefused(with([](auto& c) { c.eye.y = -2e9; }), "axis 1");
  expectRefused(with([](auto& c) { c.eye.z = std::numeric_limits<double>::quiet_NaN(); }), "axis 2");
}

}  // namespace
}  // namespace tessera
