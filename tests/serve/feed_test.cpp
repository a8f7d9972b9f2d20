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

TEST(Feed, MasksOfBlendedMaterialsAreThoseOfTheirImages) {
  Scene scene = build::emptyScene();
  build::addCheckers(scene, 4, 2, true);
  build::addCheckers(scene, 4, 2, false);
  Material glass;
  glass.alphaMode = AlphaMode::Blend;
  glass.baseColorFactor.a = 0.5f;
  build::addMaterial(scene, glass);  // its style says all
  glass.baseColor.image = 0;
  build::addMaterial(scene, glass);
  glass.baseColor.image = 1;
  build::addMaterial(scene, glass);
  const auto masks = masksOf(scene);
  ASSERT_EQ(masks.size(), 2u);
  EXPECT_EQ(masks[0].number, 0);
  EXPECT_EQ(masks[0].cutoff, 0.0f);
  EXPECT_EQ(masks[0].alpha,
            (std::vector<std::uint8_t>{128, 128, 0, 0, 128, 128, 0, 0, 0, 0, 128, 128, 0, 0, 128, 128}));
  EXPECT_EQ(masks[1].width, 1u);
  EXPECT_EQ(masks[1].alpha, (std::vector<std::uint8_t>{128}));
}

TEST(Feed, MaterialsOfOneMaskShareIt) {
  Scene scene = build::emptyScene();
  build::addCheckers(scene, 4, 2, true);
  Material leaf;
  leaf.alphaMode = AlphaMode::Mask;
  leaf.baseColor.image = 0;
  build::addMaterial(scene, leaf);
  leaf.roughnessFactor = 0.1f;
  leaf.baseColorFactor.r = 0.5f;
  build::addMaterial(scene, leaf);  // nothing that a mask is made of
  leaf.alphaCutoff = 0.75f;
  build::addMaterial(scene, leaf);
  leaf.baseColor.sampler.wrapT = Wrap::Clamp;
  build::addMaterial(scene, leaf);
  leaf.alphaMode = AlphaMode::Blend;
  build::addMaterial(scene, leaf);
  const auto masks = masksOf(scene);
  ASSERT_EQ(masks.size(), 4u);
  for (std::size_t i = 0; i < masks.size(); ++i) EXPECT_EQ(masks[i].number, i);
  EXPECT_EQ(masks[0].cutoff, 0.5f);
  EXPECT_EQ(masks[1].cutoff, 0.75f);
  EXPECT_EQ(masks[2].up, wire::Wrap::Clamp);
  EXPECT_EQ(masks[3].cutoff, 0.0f);
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

TEST(Feed, LightsArePlacedFromTheEye) {
  std::vector<LightSample> lights(4);
  lights[0].type = LightType::Directional;
  lights[0].direction = {0, 0, 1};
  lights[1].type = LightType::Spot;
  lights[1].position = {1e7, 2, 3};
  lights[1].radiance = {4, 5, 6};
  lights[1].range = 7;
  lights[1].innerCone = 0.25f;
  lights[1].outerCone = 0.5f;
  lights[2].position.y = std::numeric_limits<double>::infinity();
  lights[3].type = LightType::Point;
  const auto sent = lightsOf(lights, {1e7, 1, 1});
  ASSERT_EQ(sent.size(), 3u) << "one is nowhere";
  EXPECT_EQ(sent[0].type, wire::FrameLight::Directional);
  EXPECT_EQ(sent[0].direction, glm::vec3(0, 0, 1));
  EXPECT_EQ(sent[1].type, wire::FrameLight::Spot);
  EXPECT_EQ(sent[1].position, glm::vec3(0, 1, 2)) << "subtracted in double";
  EXPECT_EQ(sent[1].radiance, glm::vec3(4, 5, 6));
  EXPECT_EQ(sent[1].range, 7.0f);
  EXPECT_EQ(sent[1].innerCone, 0.25f);
  EXPECT_EQ(sent[1].outerCone, 0.5f);
  EXPECT_EQ(sent[2].type, wire::FrameLight::Point);
  // No more than a message may have.
  EXPECT_EQ(lightsOf(std::vector<LightSample>(300), {}).size(), wire::kMostLights);
}

TEST(Feed, PathsAreTheStages) {
  Stage stage;
  stage.paths = {{"tour", {{0.5, {1, 2, 3}, {4, 5, 6}, 50.0}, {1.5, {}, {7, 8, 9}, 60.0}}}, {"walk", {{}}}};
  const auto paths = pathsOf(stage);
  ASSERT_EQ(paths.size(), 2u);
  EXPECT_EQ(paths[0].name, "tour");
  ASSERT_EQ(paths[0].keys.size(), 2u);
  EXPECT_EQ(paths[0].keys[0].time, 0.5);
  EXPECT_EQ(paths[0].keys[0].eye, glm::dvec3(1, 2, 3));
  EXPECT_EQ(paths[0].keys[1].target, glm::dvec3(7, 8, 9));
  EXPECT_EQ(paths[0].keys[0].fovY, 50.0);
  EXPECT_EQ(paths[1].name, "walk");
}

}  // namespace
}  // namespace tessera
