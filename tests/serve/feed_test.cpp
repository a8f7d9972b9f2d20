// Cameras between the engine and the stream: the same both ways, and bounds on what a viewer may ask for.
#include "engine/stream/feed.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "engine/scene/build.hpp"
#include "engine/stream/regions.hpp"

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

TEST(Feed, MasksAreTheAlphaOfTheirImages) {
  Scene scene = build::emptyScene();
  SceneImage image;
  image.image = {3, 2, std::vector<std::uint8_t>(24, 255)};
  for (std::size_t i = 0; i < 6; ++i) image.image.pixels[4 * i + 3] = static_cast<std::uint8_t>(40 * i);
  scene.images.push_back(image);
  Material leaf;
  leaf.alphaMode = AlphaMode::Mask;
  leaf.alphaCutoff = 0.25f;
  leaf.baseColor.image = 0;
  leaf.baseColor.sampler.wrapS = Wrap::Mirror;
  leaf.baseColorFactor.a = 0.5f;
  build::addMaterial(scene, leaf);
  Material plain;
  plain.alphaMode = AlphaMode::Mask;
  plain.baseColorFactor.a = 0.75f;
  build::addMaterial(scene, plain);
  const auto masks = masksOf(scene);
  ASSERT_EQ(masks.size(), 2u);
  EXPECT_EQ(masks[0].number, 0);
  EXPECT_EQ(masks[0].width, 3u);
  EXPECT_EQ(masks[0].height, 2u);
  EXPECT_EQ(masks[0].across, wire::Wrap::Mirror);
  EXPECT_EQ(masks[0].up, wire::Wrap::Repeat);
  EXPECT_EQ(masks[0].cutoff, 0.25f);
  EXPECT_EQ(masks[0].alpha, (std::vector<std::uint8_t>{0, 20, 40, 60, 80, 100}));
  EXPECT_EQ(masks[1].number, 1);
  EXPECT_EQ(masks[1].alpha, (std::vector<std::uint8_t>{191}));
}

TEST(Feed, MasksBeyondTheWiresSidesAreHalved) {
  Scene scene = build::emptyScene();
  SceneImage image;
  const int side = static_cast<int>(wire::kMostMaskSide) * 2;
  image.image = {side, 2, std::vector<std::uint8_t>(static_cast<std::size_t>(side) * 8, 255)};
  for (int y = 0; y < 2; ++y) image.image.at(2, y)[3] = image.image.at(3, y)[3] = 101;
  scene.images.push_back(image);
  Material leaf;
  leaf.alphaMode = AlphaMode::Mask;
  leaf.baseColor.image = 0;
  build::addMaterial(scene, leaf);
  const auto masks = masksOf(scene);
  ASSERT_EQ(masks.size(), 1u);
  EXPECT_EQ(masks[0].width, wire::kMostMaskSide);
  EXPECT_EQ(masks[0].height, 1u);
  EXPECT_EQ(masks[0].alpha[0], 255);
  EXPECT_EQ(masks[0].alpha[1], 101);
}

TEST(Regions, MacroblocksCountByThePixelsThatShowThem) {
  // A block of one macroblock that 512 pixels show, one over two macroblocks with 128 pixels in all, and one
  // that nobody sees.
  const std::vector<ShownBlock> blocks = {{0, 0, 16, 16, 512.0}, {24, 16, 16, 8, 128.0}, {0, 32, 8, 8, 0.0}};
  const auto regions = regionsOf(blocks, 40, 36);
  ASSERT_EQ(regions.size(), 9u);
  const double mean = (512.0 + 64.0 + 64.0) / 3.0;
  EXPECT_DOUBLE_EQ(regions[0].importance, 512.0 / mean);
  EXPECT_DOUBLE_EQ(regions[4].importance, 64.0 / mean);  // (1, 1)
  EXPECT_DOUBLE_EQ(regions[5].importance, 64.0 / mean);
  EXPECT_DOUBLE_EQ(regions[6].importance, 0.25);
  EXPECT_DOUBLE_EQ(regions[1].importance, 0.25);
  EXPECT_EQ(regions[5].x, 32);
  EXPECT_EQ(regions[5].width, 8);
  EXPECT_EQ(regions[8].height, 4);
  EXPECT_TRUE(regionsOf({}, 64, 64).empty());
}

TEST(Regions, ImportanceStaysWithinTwoHalvings) {
  const std::vector<ShownBlock> blocks = {{0, 0, 16, 16, 1e6},  {16, 0, 16, 16, 1.0}, {32, 0, 16, 16, 1.0},
                                          {48, 0, 16, 16, 1.0}, {64, 0, 16, 16, 1.0}, {80, 0, 16, 16, 1.0}};
  const auto regions = regionsOf(blocks, 96, 16);
  EXPECT_EQ(regions[0].importance, 4.0);
  EXPECT_EQ(regions[1].importance, 0.25);
}

}  // namespace
}  // namespace tessera
