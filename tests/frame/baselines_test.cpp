// What the atlas is compared with: Lanczos-3 upsampling and mesh warping of forward's picture.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "engine/frame/engine.hpp"
#include "engine/measure/metrics.hpp"
#include "glsl/shared/tone.h"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using Baselines = test::GlTest;

constexpr int kWidth = 320;
constexpr int kHeight = 180;

std::unique_ptr<Engine> make(Scene scene, bool baselines = true) {
  EngineOptions options;
  options.request = {
      .rect = true, .forward = true, .upsample = baselines, .warp = baselines, .lens = baselines};
  options.atlas.memory.width = options.atlas.memory.height = 1024;
  options.splitEdges = 0.0;
  auto engine = Engine::create(test::context(), std::move(scene), {}, options);
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return nullptr;
  }
  (*engine)->update(0.0);
  return std::move(*engine);
}

Material unlit() {
  Material material;
  material.unlit = true;
  return material;
}

/// A tilted board of checkers that leaves background all around it.
Scene boardScene() {
  Scene scene = test::emptyScene();
  Material material = unlit();
  material.baseColor.image = test::addCheckers(scene, 256, 16);
  const auto index = test::addMaterial(scene, material);
  test::place(scene,
              test::addGrid(scene, {-1.2f, -0.5f, -2}, {2.2f, 0.2f, -1}, {0.1f, 1.1f, 0}, 4, 4, index));
  test::finish(scene);
  return scene;
}

/// A plane ahead that fills every view of these tests and more; its colours are linear over it, or one.
Scene wallScene(glm::vec3 tilt, bool colored) {
  Scene scene = test::emptyScene();
  const auto index = test::addMaterial(scene, unlit());
  test::place(scene, test::addGrid(scene, glm::vec3(-2.4f, -1.6f, -1.2f) - tilt * 0.5f,
                                   glm::vec3(4.8f, 0, 0) + tilt, {0, 3.2f, 0}, 8, 8, index, colored));
  test::finish(scene);
  return scene;
}

View frontView(int width = kWidth, int height = kHeight) {
  return lookAt({0, 0, 0}, {0, 0, -1}, 60.0, width, height, 0.05);
}

std::array<int, 3> backgroundBytes() {
  const glm::vec3 b = EngineOptions().background;
  std::array<int, 3> bytes{};
  for (int c = 0; c < 3; ++c)
    bytes[static_cast<std::size_t>(c)] = static_cast<int>(std::lround(255.0f * glsl::encodeSrgb(b[c])));
  return bytes;
}

bool near(const std::uint8_t* pixel, const std::array<int, 3>& color, int tolerance = 0) {
  for (std::size_t c = 0; c < 3; ++c)
    if (std::abs(int{pixel[c]} - color[c]) > tolerance) return false;
  return true;
}

int largestDifference(const Image& a, const Image& b, int margin = 0) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  int largest = 0;
  for (int y = margin; y < a.height - margin; ++y)
    for (int x = margin; x < a.width - margin; ++x)
      for (int c = 0; c < 4; ++c)
        largest = std::max(largest, std::abs(int{a.at(x, y)[c]} - int{b.at(x, y)[c]}));
  return largest;
}

double lanczos3(double x) {
  if (x == 0.0) return 1.0;
  if (std::abs(x) >= 3.0) return 0.0;
  const double p = std::numbers::pi * x;
  return 3.0 * std::sin(p) * std::sin(p / 3.0) / (p * p);
}

/// The sum over all 36 pixels at once, in double: red, green, blue times coverage, coverage.
std::array<double, 4> upsampledAt(const Image& image, int x, int y, int width, int height) {
  const double atX = (x + 0.5) * image.width / width - 0.5;
  const double atY = (y + 0.5) * image.height / height - 0.5;
  std::array<double, 4> sum{};
  double weights = 0.0;
  for (int j = static_cast<int>(std::floor(atY)) - 3; j <= std::floor(atY) + 4; ++j)
    for (int i = static_cast<int>(std::floor(atX)) - 3; i <= std::floor(atX) + 4; ++i) {
      const double weight = lanczos3(i - atX) * lanczos3(j - atY);
      const std::uint8_t* p = image.at(std::clamp(i, 0, image.width - 1), std::clamp(j, 0, image.height - 1));
      weights += weight;
      if (p[3] == 0) continue;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * p[c];
      sum[3] += weight;
    }
  for (double& value : sum) value /= weights;
  return sum;
}

TEST_F(Baselines, UpsamplingIsLanczos3OfTheCoveredPixels) {
  auto engine = make(boardScene());
  ASSERT_TRUE(engine);
  // Twice, and by ratios that no pixel pattern repeats.
  for (const glm::ivec2 size : {glm::ivec2(kWidth, kHeight), glm::ivec2(kWidth / 2 + 37, kHeight / 2 + 11)}) {
    // The board leaves the picture to the left and below: edges have a part in it.
    engine->forward(lookAt({0.6, 0.35, -0.8}, {0.75, 0.9, -3.0}, 60.0, kWidth / 2, kHeight / 2, 0.05));
    const Image small = engine->readColor();
    const auto done = engine->upsample(size.x, size.y);
    ASSERT_TRUE(done) << done.error().message;
    const Image large = engine->readColor();
    ASSERT_EQ(large.width, size.x);
    ASSERT_EQ(large.height, size.y);
    int covered = 0;
    int undecided = 0;
    double worst = 0.0;
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const auto expected = upsampledAt(small, x, y, size.x, size.y);
        const std::uint8_t* p = large.at(x, y);
        // Half floats cannot tell on which side of a half this is.
        if (std::abs(expected[3] - 0.5) < 2e-3) {
          ++undecided;
          continue;
        }
        if (expected[3] < 0.5) {
          ASSERT_EQ(p[3], 0) << x << ", " << y;
          ASSERT_TRUE(near(p, backgroundBytes())) << x << ", " << y;
          continue;
        }
        ++covered;
        ASSERT_EQ(p[3], 255) << x << ", " << y;
        for (std::size_t c = 0; c < 3; ++c)
          worst = std::max(worst, std::abs(p[c] - std::clamp(expected[c] / expected[3], 0.0, 255.0)));
      }
    EXPECT_LE(worst, 1.0);
    int atLeft = 0;
    int atBottom = 0;
    for (int y = 0; y < size.y; ++y) atLeft += large.at(0, y)[3] > 0 ? 1 : 0;
    for (int x = 0; x < size.x; ++x) atBottom += large.at(x, size.y - 1)[3] > 0 ? 1 : 0;
    EXPECT_GT(atLeft, size.y / 6) << "the board does not touch the edge";
    EXPECT_GT(atBottom, size.x / 6) << "the board does not touch the edge";
    EXPECT_GT(covered, size.x * size.y / 6);
    EXPECT_LT(covered, size.x * size.y * 3 / 4);
    EXPECT_LE(undecided, size.x * size.y / 200);
  }
}

TEST_F(Baselines, UpsamplingKeepsAConstantAndLetsNoBackgroundIn) {
  auto wall = make(wallScene({0, 0, 0}, false));
  ASSERT_TRUE(wall);
  wall->forward(frontView(kWidth / 2, kHeight / 2));
  const Image small = wall->readColor();
  ASSERT_TRUE(wall->upsample(kWidth, kHeight));
  const Image large = wall->readColor();
  for (std::size_t i = 0; i < large.pixels.size(); ++i) ASSERT_EQ(large.pixels[i], small.pixels[i % 4]) << i;

  // White on dark: each pixel is the one or the other.
  Scene scene = test::emptyScene();
  const auto index = test::addMaterial(scene, unlit());
  for (int i = 0; i < 9; ++i)
    test::place(scene, test::addGrid(scene, {-0.9f + 0.2f * static_cast<float>(i), -0.4f, -2}, {0.013f, 0, 0},
                                     {0.1f, 0.7f, 0}, 1, 1, index));
  test::finish(scene);
  auto bars = make(std::move(scene));
  ASSERT_TRUE(bars);
  bars->forward(frontView(kWidth / 2, kHeight / 2));
  ASSERT_TRUE(bars->upsample(kWidth, kHeight));
  const Image picture = bars->readColor();
  int white = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
    const std::uint8_t* p = picture.pixels.data() + i;
    const bool covered = p[3] == 255;
    white += covered ? 1 : 0;
    ASSERT_TRUE(near(p, covered ? std::array<int, 3>{255, 255, 255} : backgroundBytes()))
        << i / 4 << ": " << int{p[0]} << " " << int{p[1]} << " " << int{p[2]} << " " << int{p[3]};
  }
  EXPECT_GT(white, 500);
}

TEST_F(Baselines, WarpingToTheSameViewIsTheIdentity) {
  auto engine = make(boardScene());
  ASSERT_TRUE(engine);
  const View view = frontView();
  engine->forward(view);
  const Image before = engine->readColor();
  const auto done = engine->warp(view, view);
  ASSERT_TRUE(done) << done.error().message;
  const Image after = engine->readColor();
  EXPECT_LE(largestDifference(before, after), 1);
  EXPECT_GE(psnr(before, after).value(), 60.0);
  // And what is warped can be warped again: its depth came along.
  ASSERT_TRUE(engine->warp(view, view));
  EXPECT_LE(largestDifference(before, engine->readColor()), 2);
}

TEST_F(Baselines, APlaneIsWarpedExactly) {
  for (const glm::vec3 tilt : {glm::vec3(0, 0, 0), glm::vec3(0, 0, 0.6f)}) {
    auto engine = make(wallScene(tilt, true));
    ASSERT_TRUE(engine);
    const std::array<View, 2> eyes = stereoViews(frontView(), 0.2);
    // The other eye also looks elsewhere: the mesh is geometry, not a shift.
    View turned = eyes[1];
    turned.forward = glm::normalize(glm::dvec3(-0.05, 0.03, -1.0));
    turned.up = glm::normalize(glm::cross(glm::cross(turned.forward, turned.up), turned.forward));
    for (const View& to : {eyes[1], turned}) {
      engine->forward(to);
      const Image truth = engine->readColor();
      engine->forward(eyes[0]);
      const Image from = engine->readColor();
      ASSERT_TRUE(engine->warp(eyes[0], to));
      const Image warped = engine->readColor();
      // Only what the first eye saw: a shift of 0.2 m at 0.9 m or more, and a turn of 0.06 rad.
      constexpr int kUnseen = 48;
      EXPECT_LE(largestDifference(truth, warped, kUnseen), 1);
      EXPECT_GT(largestDifference(truth, from, kUnseen), 4) << "both views are alike";
      // The edge goes on over what the first eye did not see.
      for (std::size_t i = 3; i < warped.pixels.size(); i += 4) ASSERT_EQ(warped.pixels[i], 255);
    }
  }
}

/// A red board 1 m ahead of a green wall at 4 m.
Scene boardBeforeWall(bool wall) {
  Scene scene = test::emptyScene();
  Material red = unlit();
  red.baseColorFactor = {1, 0, 0, 1};
  Material green = unlit();
  green.baseColorFactor = {0, 1, 0, 1};
  const auto board = test::addMaterial(scene, red);
  const auto back = test::addMaterial(scene, green);
  test::place(scene, test::addGrid(scene, {-0.2f, -0.2f, -1}, {0.4f, 0, 0}, {0, 0.4f, 0}, 1, 1, board));
  if (wall) test::place(scene, test::addGrid(scene, {-8, -6, -4}, {16, 0, 0}, {0, 12, 0}, 8, 8, back));
  test::finish(scene);
  return scene;
}

TEST_F(Baselines, DisocclusionIsDrawnOutNotLeftOpen) {
  auto engine = make(boardBeforeWall(true));
  ASSERT_TRUE(engine);
  const std::array<View, 2> eyes = stereoViews(frontView(), 0.2);
  engine->forward(eyes[1]);
  const Image truth = engine->readColor();
  engine->forward(eyes[0]);
  ASSERT_TRUE(engine->warp(eyes[0], eyes[1]));
  const Image warped = engine->readColor();
  const double pixels = 0.5 * kHeight / std::tan(0.5 * frontView().fovY);  // a metre at one metre
  const double disparity = pixels * 0.2 * (1.0 - 0.25);                    // between board and wall
  const int row = kHeight / 2;
  int drawnOut = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const std::uint8_t* p = warped.at(x, y);
      ASSERT_EQ(p[3], 255) << "hole at " << x << ", " << y;
      const bool red = truth.at(x, y)[0] > 128;
      // The board itself is where it belongs, but for its outline.
      const auto isRed = [&](int dx, int dy) { return truth.at(x + dx, y + dy)[0] > 128; };
      const bool inside = x > 0 && x + 1 < kWidth && y > 0 && y + 1 < kHeight;
      if (red && inside && isRed(-1, 0) && isRed(1, 0) && isRed(0, -1) && isRed(0, 1)) {
        ASSERT_GT(p[0], 250) << x << ", " << y;
      }
      // Between the two colours: a triangle from the board to the wall.
      const bool mixed = p[0] > 8 && p[1] > 8;
      if (y == row && mixed && !red) ++drawnOut;
      // Red and green of a triangle add up, wherever in it a pixel lies.
      ASSERT_NEAR(int{p[0]} + int{p[1]}, 255, 2) << x << ", " << y;
    }
  // The right eye sees past the board's right side: as many pixels as the disparities differ by.
  EXPECT_NEAR(drawnOut, disparity, 3.0);
  EXPECT_LT(mssim(truth, warped).value().mean, 0.999);
}

TEST_F(Baselines, BackgroundIsWarpedAtInfinity) {
  auto engine = make(boardBeforeWall(false));
  ASSERT_TRUE(engine);
  const std::array<View, 2> eyes = stereoViews(frontView(), 0.1);
  engine->forward(eyes[1]);
  const Image truth = engine->readColor();
  engine->forward(eyes[0]);
  ASSERT_TRUE(engine->warp(eyes[0], eyes[1]));
  const Image warped = engine->readColor();
  int background = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const std::uint8_t* p = warped.at(x, y);
      if (p[3] > 0) continue;  // the board, or drawn out of it
      // The outline lies somewhere between two pixels.
      const auto covers = [&](int dx, int dy) { return truth.at(x + dx, y + dy)[3] == 255; };
      const bool inside = x > 0 && x + 1 < kWidth && y > 0 && y + 1 < kHeight;
      ASSERT_FALSE(inside && covers(0, 0) && covers(-1, 0) && covers(1, 0) && covers(0, -1) && covers(0, 1))
          << "hole at " << x << ", " << y;
      ASSERT_TRUE(near(p, backgroundBytes())) << x << ", " << y;
      ++background;
    }
  EXPECT_GT(background, kWidth * kHeight / 2);
}

TEST_F(Baselines, TheLensSeesWhatTheyMade) {
  auto engine = make(boardScene());
  ASSERT_TRUE(engine);
  engine->forward(frontView());
  ASSERT_TRUE(engine->distort({}));
  const Image expected = engine->readColor();
  engine->forward(frontView());
  ASSERT_TRUE(engine->warp(frontView(), frontView()));
  ASSERT_TRUE(engine->distort({}));
  EXPECT_LE(largestDifference(expected, engine->readColor()), 2);
  engine->forward(frontView(kWidth / 2, kHeight / 2));
  ASSERT_TRUE(engine->upsample(kWidth, kHeight));
  ASSERT_TRUE(engine->distort({}));
  const Image upsampled = engine->readColor();
  EXPECT_EQ(upsampled.width, kWidth);
  EXPECT_GT(psnr(expected, upsampled).value(), 15.0);
}

TEST_F(Baselines, WhatCannotBeMadeIsRefused) {
  auto without = make(boardScene(), false);
  ASSERT_TRUE(without);
  without->forward(frontView());
  EXPECT_NE(without->upsample(kWidth, kHeight).error().message.find("upsampling"), std::string::npos);
  EXPECT_NE(without->warp(frontView(), frontView()).error().message.find("warping"), std::string::npos);
  auto engine = make(boardScene());
  ASSERT_TRUE(engine);
  EXPECT_FALSE(engine->upsample(kWidth, kHeight));
  EXPECT_FALSE(engine->warp(frontView(), frontView()));
  engine->forward(frontView());
  const Image picture = engine->readColor();
  EXPECT_NE(engine->upsample(kWidth - 1, kHeight).error().message.find("319 x 180"), std::string::npos);
  EXPECT_NE(engine->warp(frontView(64, 64), frontView()).error().message.find("64 x 64"), std::string::npos);
  EXPECT_EQ(engine->readColor().pixels, picture.pixels);
}

TEST_F(Baselines, AnAtlasCanBeMadeAnew) {
  auto engine = make(boardScene());
  ASSERT_TRUE(engine);
  engine->rect(frontView());
  const Image first = engine->readColor();
  RectMemoryOptions small;
  small.width = 512;
  small.height = 256;
  ASSERT_TRUE(engine->remakeAtlas(small));
  EXPECT_EQ(engine->atlas()->memory().textureWidth(), 512);
  engine->rect(frontView());
  EXPECT_EQ(engine->atlas()->memory().readStatistics().frames, 1u);
  RectMemoryOptions wrong = small;
  wrong.width = 500;
  EXPECT_FALSE(engine->remakeAtlas(wrong));
  EXPECT_EQ(engine->atlas()->memory().textureWidth(), 512) << "the old one is gone";
  small.width = small.height = 1024;
  ASSERT_TRUE(engine->remakeAtlas(small));
  engine->rect(frontView());
  // Blocks lie elsewhere, so texture coordinates round otherwise.
  EXPECT_LE(largestDifference(first, engine->readColor()), 1);
}

}  // namespace
}  // namespace tessera
