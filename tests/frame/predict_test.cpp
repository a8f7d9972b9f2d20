// Predicted views against poses worked by hand.
#include "engine/frame/predict.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace tessera {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// At `eye`, turned by `degrees` to the left of -z.
View turned(double degrees, const glm::dvec3& eye = glm::dvec3(0.0)) {
  View view;
  view.eye = eye;
  const double a = glm::radians(degrees);
  view.forward = {-std::sin(a), 0.0, -std::cos(a)};
  return view;
}

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double bound = 1e-12) {
  EXPECT_NEAR(a.x, b.x, bound);
  EXPECT_NEAR(a.y, b.y, bound);
  EXPECT_NEAR(a.z, b.z, bound);
}

void expectAxes(const View& view) {
  EXPECT_NEAR(glm::length(view.forward), 1.0, 1e-14);
  EXPECT_NEAR(glm::length(view.up), 1.0, 1e-14);
  EXPECT_NEAR(glm::dot(view.forward, view.up), 0.0, 1e-14);
}

bool same(const View& a, const View& b) {
  return a.eye == b.eye && a.forward == b.forward && a.up == b.up && a.fovY == b.fovY && a.zNear == b.zNear &&
         a.width == b.width && a.height == b.height;
}

/// `v` about the unit `axis` by Rodrigues' formula.
glm::dvec3 about(const glm::dvec3& axis, double degrees, const glm::dvec3& v) {
  const double a = glm::radians(degrees);
  return v * std::cos(a) + glm::cross(axis, v) * std::sin(a) +
         axis * (glm::dot(axis, v) * (1.0 - std::cos(a)));
}

TEST(Moved, GoesOnAtTheSpeedBetweenTwoPoses) {
  const View a = turned(10.0, {1.0, 2.0, 3.0});
  const View b = turned(14.0, {1.5, 2.0, 2.0});
  const View c = moved(a, b, 3.0);
  expectNear(c.eye, {2.5, 2.0, 0.0});
  expectNear(c.forward, turned(22.0).forward);
  expectNear(c.up, {0.0, 1.0, 0.0});
  const View middle = moved(a, b, 0.5);
  expectNear(middle.eye, {1.25, 2.0, 2.5});
  expectNear(middle.forward, turned(12.0).forward);
  expectNear(moved(a, b, -1.0).forward, turned(6.0).forward);
  EXPECT_TRUE(same(moved(a, b, 1.0), b));
}

TEST(Moved, TurnsTheShortWayRound) {
  // From 170 to 190 degrees, which is -170: through the back.
  expectNear(moved(turned(170.0), turned(-170.0), 2.0).forward, turned(210.0).forward);
  expectNear(moved(turned(-170.0), turned(170.0), 2.5).forward, turned(140.0).forward);
  // Nearly half a turn, to either side.
  expectNear(moved(turned(0.0), turned(170.0), 0.5).forward, turned(85.0).forward);
  expectNear(moved(turned(0.0), turned(-170.0), 0.5).forward, turned(-85.0).forward);
}

TEST(Moved, TurnsAboutAnyAxisAndRolls) {
  const glm::dvec3 axis = glm::normalize(glm::dvec3(1.0, -2.0, 0.5));
  const View a = turned(33.0);
  View b = a;
  b.forward = about(axis, 12.0, a.forward);
  b.up = about(axis, 12.0, a.up);
  const View c = moved(a, b, 4.0);
  expectNear(c.forward, about(axis, 48.0, a.forward));
  expectNear(c.up, about(axis, 48.0, a.up));
  View rolled = a;
  rolled.up = about(a.forward, 20.0, a.up);
  const View further = moved(a, rolled, 1.5);
  expectNear(further.forward, a.forward);
  expectNear(further.up, about(a.forward, 30.0, a.up));
}

TEST(Moved, IsStableWherePosesAreEqualOrNearlySo) {
  const View a = turned(77.7, {5.0, 6.0, 7.0});
  EXPECT_TRUE(same(moved(a, a, 1.0), a));
  const View still = moved(a, a, 1000.0);
  expectNear(still.forward, a.forward, 1e-15);
  expectNear(still.up, a.up, 1e-15);
  EXPECT_EQ(still.eye, a.eye);
  for (const double degrees : {1e-7, 1e-9, 1e-11, 1e-14}) {
    const View b = turned(77.7 + degrees, a.eye);
    const View c = moved(a, b, 5.0);
    expectAxes(c);
    // As far as the last digits of the poses tell the angle between them.
    expectNear(c.forward, turned(77.7 + 5.0 * degrees).forward, 2e-15);
  }
  // A thousandth of a degree is as exact as a large turn.
  expectNear(moved(a, turned(77.701), 100.0).forward, turned(77.8).forward, 1e-13);
}

TEST(Moved, HalfTurnsAndNumbersOutOfRangeStayPoses) {
  const View half = moved(turned(0.0), turned(180.0), 1.5);
  expectAxes(half);
  EXPECT_NEAR(half.forward.z, 0.0, 1e-12) << "a quarter turn on from the back";
  const View far = turned(0.0, {1e308, 0.0, 0.0});
  EXPECT_TRUE(same(moved(turned(0.0, {-1e308, 0.0, 0.0}), far, 3.0), far));
  const View b = turned(1.0);
  EXPECT_TRUE(same(moved(turned(0.0), b, kInfinity), b));
  EXPECT_TRUE(same(moved(turned(0.0), b, kNan), b));
}

TEST(Moved, WhatIsNotThePoseIsThatOfTheLast) {
  View a = turned(0.0);
  View b = turned(1.0);
  a.fovY = 1.2;
  b.fovY = 1.1;
  b.width = 640;
  const View c = moved(a, b, 2.0);
  EXPECT_EQ(c.fovY, 1.1);
  EXPECT_EQ(c.width, 640);
}

TEST(PoseTrack, LeadsOnByTheTimesOfThePoses) {
  PoseTrack track;
  EXPECT_FALSE(track.at(0.0));
  EXPECT_TRUE(track.add({1.0, turned(0.0, {0.0, 0.0, 0.0})}));
  EXPECT_TRUE(same(*track.at(5.0), turned(0.0)));
  // 3 metres and 6 degrees in 0.3 seconds, then 1 and 1 in 0.05.
  EXPECT_TRUE(track.add({1.3, turned(6.0, {3.0, 0.0, 0.0})}));
  expectNear(track.at(1.4)->eye, {4.0, 0.0, 0.0});
  expectNear(track.at(1.4)->forward, turned(8.0).forward);
  EXPECT_TRUE(track.add({1.35, turned(7.0, {4.0, 0.0, 0.0})}));
  expectNear(track.at(1.4)->eye, {5.0, 0.0, 0.0});
  expectNear(track.at(1.4)->forward, turned(8.0).forward);
  EXPECT_TRUE(same(*track.at(1.35), track.last()->view)) << "now is the pose itself";
}

TEST(PoseTrack, TimesThatStandStillOrGoBackTellNoSpeed) {
  PoseTrack track;
  track.add({1.0, turned(0.0)});
  // At the same time: it is where the camera is, and nothing is known of speed.
  EXPECT_TRUE(track.add({1.0, turned(5.0)}));
  EXPECT_TRUE(same(*track.at(2.0), turned(5.0)));
  EXPECT_TRUE(track.add({1.0 + 0.5 * PoseTrack::kShortestStep, turned(6.0)}));
  EXPECT_TRUE(same(*track.at(2.0), turned(6.0)));
  EXPECT_TRUE(track.add({1.5, turned(16.0)}));
  const double speed = 10.0 / (0.5 - 0.5 * PoseTrack::kShortestStep);  // degrees a second
  expectNear(track.at(1.6)->forward, turned(16.0 + 0.1 * speed).forward);
  // A correction of the last pose keeps the one before it.
  EXPECT_TRUE(track.add({1.5, turned(11.0)}));
  expectNear(track.at(1.6)->forward, turned(11.0 + 0.05 * speed).forward);
  EXPECT_FALSE(track.add({1.4, turned(50.0)}));
  EXPECT_FALSE(track.add({kNan, turned(50.0)}));
  EXPECT_FALSE(track.add({kInfinity, turned(50.0)}));
  expectNear(track.at(1.5)->forward, turned(11.0).forward);
}

std::vector<TimedView> recording() {
  return {{2.0, turned(0.0, {0.0, 0.0, 0.0})},
          {3.0, turned(10.0, {1.0, 0.0, 0.0})},
          {3.5, turned(10.0, {1.0, 4.0, 0.0})}};
}

TEST(SampleRecorded, IsThePoseAtItsTimeAndBetweenThemOtherwise) {
  const auto path = recording();
  for (const TimedView& pose : path) {
    EXPECT_TRUE(same(sampleRecorded(path, pose.time), pose.view)) << pose.time;
    // A time that was summed up is not exact.
    EXPECT_TRUE(same(sampleRecorded(path, std::nextafter(pose.time, 0.0)), pose.view)) << pose.time;
    EXPECT_TRUE(same(sampleRecorded(path, std::nextafter(pose.time, 9.0)), pose.view)) << pose.time;
  }
  EXPECT_TRUE(same(sampleRecorded(path, 1.0), path.front().view));
  EXPECT_TRUE(same(sampleRecorded(path, 9.0), path.back().view));
  const View quarter = sampleRecorded(path, 2.25);
  expectNear(quarter.eye, {0.25, 0.0, 0.0});
  expectNear(quarter.forward, turned(2.5).forward);
  expectNear(sampleRecorded(path, 3.125).eye, {1.0, 1.0, 0.0});
}

TEST(PredictedViews, AreThePresentAndTheSteps) {
  const auto path = recording();
  PoseTrack track;
  PvsOptions options{.prediction = Prediction::Linear, .latency = 0.5, .steps = 2, .margin = 0.0};
  EXPECT_TRUE(predictedViews(track, path, options).empty());
  track.add(path[0]);
  track.add(path[1]);
  const auto linear = predictedViews(track, path, options);
  ASSERT_EQ(linear.size(), 3u);
  EXPECT_EQ(linear[0].time, 3.0);
  EXPECT_EQ(linear[1].time, 3.25);
  EXPECT_EQ(linear[2].time, 3.5);
  EXPECT_TRUE(same(linear[0].view, path[1].view));
  expectNear(linear[1].view.eye, {1.25, 0.0, 0.0});
  expectNear(linear[2].view.forward, turned(15.0).forward);
  options.prediction = Prediction::Reference;
  const auto reference = predictedViews(track, path, options);
  ASSERT_EQ(reference.size(), 3u);
  expectNear(reference[1].view.eye, {1.0, 2.0, 0.0});
  EXPECT_TRUE(same(reference[2].view, path[2].view));
  options.prediction = Prediction::None;
  EXPECT_EQ(predictedViews(track, path, options).size(), 1u);
  options.prediction = Prediction::Linear;
  options.latency = 0.0;
  EXPECT_EQ(predictedViews(track, path, options).size(), 1u);
}

TEST(Widened, KeepsThePixelsAndAddsWholeOnes) {
  View view;
  view.width = 200;
  view.height = 200;
  view.fovY = glm::radians(90.0);
  // A pixel is 0.01 at distance 1; tan 60 degrees is 1.7320..., so 73.2 pixels more, and 74 whole ones.
  const auto wide = widened(view, glm::radians(15.0));
  ASSERT_TRUE(wide) << wide.error().message;
  EXPECT_EQ(wide->width, 348);
  EXPECT_EQ(wide->height, 348);
  EXPECT_NEAR(std::tan(0.5 * wide->fovY), 1.74, 1e-12);
  View flat = view;
  flat.width = 640;
  flat.height = 123;
  flat.fovY = 0.9;
  flat.eye = {3.0, 4.0, 5.0};
  const double margin = glm::radians(2.5);
  const auto wider = widened(flat, margin);
  ASSERT_TRUE(wider) << wider.error().message;
  const int dx = (wider->width - flat.width) / 2;
  const int dy = (wider->height - flat.height) / 2;
  EXPECT_EQ(2 * dx + flat.width, wider->width);
  EXPECT_EQ(2 * dy + flat.height, wider->height);
  for (const glm::dvec2& place : {glm::dvec2(0.0), {640.0, 123.0}, {17.0, 99.0}})
    expectNear(pixelToRay(flat) * glm::dvec3(1.0, place),
               pixelToRay(*wider) * glm::dvec3(1.0, place + glm::dvec2(dx, dy)));
  // At least the margin to each side, and less than a pixel more than it.
  const double pixel = 2.0 * std::tan(0.45) / 123.0;
  for (const auto& [before, after] : {std::pair(640, wider->width), std::pair(123, wider->height)}) {
    const double asked = std::tan(std::atan(0.5 * before * pixel) + margin);
    EXPECT_GE(0.5 * after * pixel, asked - 1e-12);
    EXPECT_LT(0.5 * after * pixel, asked + pixel);
  }
  const auto none = widened(flat, 0.0);
  ASSERT_TRUE(none);
  EXPECT_TRUE(same(*none, flat));
}

TEST(Widened, RefusesWhatNoIdBufferHolds) {
  View view;
  view.width = view.height = 100;
  view.fovY = glm::radians(90.0);
  EXPECT_TRUE(widened(view, glm::radians(39.9)));
  const auto past = widened(view, glm::radians(41.0));
  ASSERT_FALSE(past);
  EXPECT_NE(past.error().message.find("86"), std::string::npos) << past.error().message;
  view.width = view.height = 12000;
  const auto large = widened(view, glm::radians(30.0));
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().message.find("12000"), std::string::npos) << large.error().message;
  const std::vector<TimedView> views = {{0.0, turned(0.0)}, {1.0, view}};
  EXPECT_FALSE(widened(views, glm::radians(30.0)));
}

TEST(PvsOptions, AreChecked) {
  EXPECT_TRUE(check(PvsOptions{}));
  const auto refused = [](const PvsOptions& options, const char* named) {
    const auto checked = check(options);
    ASSERT_FALSE(checked) << named;
    EXPECT_NE(checked.error().message.find(named), std::string::npos) << checked.error().message;
  };
  refused({.latency = -0.001}, "latency of -0.001");
  refused({.latency = 10.5}, "latency of 10.5");
  refused({.latency = kNan}, "latency of nan");
  refused({.steps = 0}, "0 steps");
  refused({.steps = 65}, "65 steps");
  refused({.margin = -0.1}, "margin of -5.7");
  refused({.margin = kNan}, "margin of nan");
  refused({.margin = 1.0}, "margin of 57.2");
}

TEST(PredictedViews, OfWhoStandsStillAreThereToTheBit) {
  // A turn whose axes are no round numbers.
  const View view = lookAt({0.1, 1.7, -0.3}, {2.3, 0.9, 4.1}, 57.0, 640, 360, 0.05);
  PoseTrack track;
  ASSERT_TRUE(track.add({0.0, view}));
  ASSERT_TRUE(track.add({0.3, view}));
  for (const TimedView& predicted : predictedViews(track, {}, {.latency = 0.1, .steps = 7}))
    EXPECT_TRUE(predicted.view == view) << predicted.time;
}

}  // namespace
}  // namespace tessera
