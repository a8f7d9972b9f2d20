// Coverage and overestimation of a wall of columns, each a patch of four by forty pixels, as worked by hand.
#include <gtest/gtest.h>

#include "apps/tessera/pvs/measure.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera::app {
namespace {

using PvsMeasure = test::GlTest;

constexpr double kColumn = 0.2;  // metres wide, at distance 1

std::unique_ptr<Engine> wall() {
  Scene scene = test::emptyScene();
  const auto material = test::addMaterial(scene, test::unlit());
  for (int i = -20; i < 20; ++i)
    test::place(scene, test::addGrid(scene, {static_cast<float>(kColumn * i), -5, -1},
                                     {static_cast<float>(kColumn), 0, 0}, {0, 10, 0}, 1, 1, material));
  test::finish(scene);
  EngineOptions options;
  options.atlas.memory.width = options.atlas.memory.height = 256;
  options.splitEdges = 0.0;
  auto engine = Engine::create(test::context(), std::move(scene), {}, options);
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return nullptr;
  }
  (*engine)->update(0.0);
  return std::move(*engine);
}

/// A camera of 40 x 40 pixels that sees 90 degrees, so many columns to the right at each of 10 poses a
/// second.
std::vector<TimedView> path(const std::vector<double>& columns) {
  std::vector<TimedView> views;
  for (const double column : columns) {
    TimedView timed{0.1 * static_cast<double>(views.size()), {}};
    timed.view.eye.x = kColumn * column;
    timed.view.fovY = glm::radians(90.0);
    timed.view.width = timed.view.height = 40;
    views.push_back(timed);
  }
  return views;
}

PvsFrame only(Engine& engine, const std::vector<double>& columns, const PvsOptions& options) {
  const PvsSampling sampling{.frames = 1, .rate = 10.0, .latency = 0.2};
  const auto scene = measurePvs(engine, path(columns), sampling, {&options, 1}, [] {});
  if (!scene) {
    ADD_FAILURE() << scene.error().message;
    return {};
  }
  EXPECT_EQ(scene->shownViews, 3);
  EXPECT_EQ(scene->runs.size(), 1u);
  EXPECT_EQ(scene->runs[0].frames.size(), 1u);
  return scene->runs[0].frames.at(0);
}

PvsOptions way(Prediction prediction, double margin = 0.0) {
  return {.prediction = prediction, .latency = 0.2, .steps = 2, .margin = margin};
}

TEST_F(PvsMeasure, WithoutPredictionNewColumnsAreMissed) {
  auto engine = wall();
  ASSERT_TRUE(engine);
  // Ten columns a view. The second shows one that the first does not, the third two: 3 of 30.
  const PvsFrame none = only(*engine, {-1, 0, 1, 2}, way(Prediction::None));
  EXPECT_DOUBLE_EQ(none.coverage, 0.9);
  EXPECT_DOUBLE_EQ(none.missedPixels, 160.0);
  EXPECT_DOUBLE_EQ(none.overestimation, 0.0);
  EXPECT_EQ(none.elements, 10.0);
  EXPECT_EQ(none.neededElements, 12.0);
}

TEST_F(PvsMeasure, LinearPredictionIsExactAtConstantSpeed) {
  auto engine = wall();
  ASSERT_TRUE(engine);
  for (const Prediction prediction : {Prediction::Linear, Prediction::Reference}) {
    const PvsFrame frame = only(*engine, {-1, 0, 1, 2}, way(prediction));
    EXPECT_DOUBLE_EQ(frame.coverage, 1.0);
    EXPECT_DOUBLE_EQ(frame.overestimation, 0.0);
    EXPECT_EQ(frame.elements, 12.0);
  }
}

TEST_F(PvsMeasure, WhatAStopLeavesUnseenIsOverestimated) {
  auto engine = wall();
  ASSERT_TRUE(engine);
  // Predicted are 1 and 2 columns further, and neither is seen: 3 of the 30 columns of the set's views.
  const PvsFrame linear = only(*engine, {-1, 0, 0, 0}, way(Prediction::Linear));
  EXPECT_DOUBLE_EQ(linear.coverage, 1.0);
  EXPECT_DOUBLE_EQ(linear.overestimation, 0.1);
  const PvsFrame reference = only(*engine, {-1, 0, 0, 0}, way(Prediction::Reference));
  EXPECT_DOUBLE_EQ(reference.overestimation, 0.0);
}

TEST_F(PvsMeasure, AMarginSeesFurtherToEachSide) {
  auto engine = wall();
  ASSERT_TRUE(engine);
  // tan = 1.2 is a column, four pixels of 0.05, more to each side. Of the needed views only the third's
  // second new column is missed, 1 of 30; the column on the left, 4 x 48 pixels, is for nothing.
  const double margin = std::atan(1.2) - std::atan(1.0);
  const PvsFrame none = only(*engine, {-1, 0, 1, 2}, way(Prediction::None, margin));
  EXPECT_DOUBLE_EQ(none.coverage, 29.0 / 30.0);
  EXPECT_DOUBLE_EQ(none.overestimation, 4.0 * 48.0 / 1600.0);
  EXPECT_EQ(none.elements, 12.0);
}

TEST_F(PvsMeasure, SaysWhenThePathIsTooShort) {
  auto engine = wall();
  ASSERT_TRUE(engine);
  const PvsOptions options = way(Prediction::Linear);
  const PvsSampling sampling{.frames = 1, .rate = 10.0, .latency = 0.2};
  const auto scene = measurePvs(*engine, path({0, 1, 2}), sampling, {&options, 1}, [] {});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("3 poses"), std::string::npos) << scene.error().message;
}

TEST(PresentPoses, AreSpreadOverThePath) {
  using Indices = std::vector<std::size_t>;
  EXPECT_EQ(presentPoses(10, 3, 100), (Indices{1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(presentPoses(10, 3, 3), (Indices{1, 4, 7}));
  EXPECT_EQ(presentPoses(10, 3, 1), (Indices{4}));
  EXPECT_EQ(presentPoses(4, 3, 5), (Indices{1}));
  EXPECT_TRUE(presentPoses(3, 3, 5).empty());
  EXPECT_TRUE(presentPoses(0, 1, 5).empty());
}

}  // namespace
}  // namespace tessera::app
