// Node animation against hand-worked values.
#include <cmath>

#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

#include "engine/scene/scene.hpp"

namespace tessera {
namespace {

/// A root with one child; the channel drives the root.
Scene sceneWith(AnimationChannel channel, double duration) {
  Scene scene;
  scene.nodes.resize(2);
  scene.nodes[1].parent = 0;
  scene.nodes[1].translation = {1.0, 0.0, 0.0};
  scene.animations.push_back({"test", duration, {std::move(channel)}});
  return scene;
}

AnimationChannel translation(Interpolation interpolation, std::vector<float> times,
                             std::vector<glm::vec4> values) {
  return {0, AnimatedProperty::Translation, interpolation, std::move(times), std::move(values)};
}

AnimationChannel rotation(Interpolation interpolation, std::vector<float> times,
                          std::vector<glm::vec4> values) {
  return {0, AnimatedProperty::Rotation, interpolation, std::move(times), std::move(values)};
}

glm::dvec3 placeAt(const Scene& scene, double time, std::size_t node = 0) {
  SceneState state;
  evaluate(scene, time, state);
  return glm::dvec3(state.world[node][3]);
}

void expectNear(const glm::dvec3& actual, const glm::dvec3& expected, double tolerance = 1e-12) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "component " << i;
}

const float kHalf = std::sqrt(0.5f);

TEST(Animation, LinearIsStraightAndHeldOutsideItsKeys) {
  const Scene scene = sceneWith(
      translation(Interpolation::Linear, {1.0f, 2.0f, 4.0f}, {{0, 0, 0, 0}, {2, 4, 6, 0}, {2, 0, 6, 0}}),
      5.0);
  expectNear(placeAt(scene, 0.0), {0, 0, 0});
  expectNear(placeAt(scene, 1.0), {0, 0, 0});
  expectNear(placeAt(scene, 1.25), {0.5, 1, 1.5});
  expectNear(placeAt(scene, 2.0), {2, 4, 6});
  expectNear(placeAt(scene, 3.5), {2, 1, 6});
  expectNear(placeAt(scene, 4.75), {2, 0, 6});
}

TEST(Animation, LoopsOverItsDurationInBothDirections) {
  const Scene scene =
      sceneWith(translation(Interpolation::Linear, {0.0f, 4.0f}, {{0, 0, 0, 0}, {8, 0, 0, 0}}), 4.0);
  expectNear(placeAt(scene, 4.0), {0, 0, 0});
  expectNear(placeAt(scene, 5.0), {2, 0, 0});
  expectNear(placeAt(scene, -1.0), {6, 0, 0});
  expectNear(placeAt(scene, 4001.0), {2, 0, 0});
}

TEST(Animation, EachAnimationLoopsOverItsOwnDuration) {
  Scene scene =
      sceneWith(translation(Interpolation::Linear, {0.0f, 4.0f}, {{0, 0, 0, 0}, {8, 0, 0, 0}}), 4.0);
  AnimationChannel scale{
      1, AnimatedProperty::Scale, Interpolation::Linear, {0.0f, 1.0f}, {{1, 1, 1, 0}, {3, 3, 3, 0}}};
  scene.animations.push_back({"other", 1.0, {scale}});
  SceneState state;
  evaluate(scene, 2.5, state);
  EXPECT_NEAR(state.world[0][3].x, 5.0, 1e-12);
  EXPECT_NEAR(state.world[1][0].x, 2.0, 1e-12);
}

TEST(Animation, StepHoldsUntilTheNextKey) {
  const Scene scene = sceneWith(
      translation(Interpolation::Step, {0.0f, 1.0f, 2.0f}, {{1, 0, 0, 0}, {2, 0, 0, 0}, {3, 0, 0, 0}}), 3.0);
  expectNear(placeAt(scene, 0.999), {1, 0, 0});
  expectNear(placeAt(scene, 1.0), {2, 0, 0});
  expectNear(placeAt(scene, 1.999), {2, 0, 0});
  expectNear(placeAt(scene, 2.5), {3, 0, 0});
}

// Interval 2 s, values 0 and 1, tangents 3 out and -1 in. At s = 1/4: h00 = 0.84375, h10 = 0.140625, h01 =
// 0.15625, h11 = -0.046875, so p = 2 * 0.140625 * 3 + 0.15625 + 2 * -0.046875 * -1 = 1.09375.
TEST(Animation, CubicScalesItsTangentsWithTheInterval) {
  const Scene scene = sceneWith(
      translation(Interpolation::Cubic, {1.0f, 3.0f},
                  {{9, 9, 9, 9}, {0, 0, 0, 0}, {3, 0, 0, 0}, {-1, 0, 0, 0}, {1, 0, 0, 0}, {9, 9, 9, 9}}),
      4.0);
  expectNear(placeAt(scene, 1.5), {1.09375, 0, 0});
  expectNear(placeAt(scene, 0.5), {0, 0, 0});
  expectNear(placeAt(scene, 1.0), {0, 0, 0});
  expectNear(placeAt(scene, 3.5), {1, 0, 0});
}

// 0 to 90 degrees about z: a third of the way is 30 degrees. A straight line between the quaternions, even
// made unit length, would give 29.4.
TEST(Animation, RotationsTurnEvenly) {
  const Scene scene =
      sceneWith(rotation(Interpolation::Linear, {0.0f, 3.0f}, {{0, 0, 0, 1}, {0, 0, kHalf, kHalf}}), 4.0);
  expectNear(placeAt(scene, 1.0, 1), {std::sqrt(3.0) / 2.0, 0.5, 0.0}, 1e-7);
}

TEST(Animation, RotationsTakeTheShorterWay) {
  const Scene scene =
      sceneWith(rotation(Interpolation::Linear, {0.0f, 2.0f}, {{0, 0, 0, 1}, {0, 0, -kHalf, -kHalf}}), 4.0);
  expectNear(placeAt(scene, 1.0, 1), {kHalf, kHalf, 0.0}, 1e-7);
}

TEST(Animation, TheLengthOfARotationDoesNotMatter) {
  const Scene scene = sceneWith(
      rotation(Interpolation::Linear, {0.0f, 2.0f}, {{0, 0, 0, 1}, {0, 0, 5 * kHalf, 5 * kHalf}}), 4.0);
  expectNear(placeAt(scene, 1.0, 1), {kHalf, kHalf, 0.0}, 1e-7);
}

TEST(Animation, EqualOppositeAndUnnormalisedRotationsStayRotations) {
  const std::vector<std::array<glm::vec4, 2>> pairs = {
      {glm::vec4(0, 0, 0, 1), glm::vec4(0, 0, 0, 1)},
      {glm::vec4(0, 0, 0, 1), glm::vec4(0, 0, 0, -1)},
      {glm::vec4(0, 0, 0, 1), glm::vec4(0, 1e-20f, 0, 1)},
      {glm::vec4(0, 0, 0, 1), glm::vec4(0, 0, 1, 0)},
      {glm::vec4(0, 0, 0.01f, 0), glm::vec4(7, 0, 0, 7)},
      {glm::vec4(0, 0, 0, 0), glm::vec4(0, 0, 0, 0)},
      {glm::vec4(0, 0, 0, 1.0001f), glm::vec4(0, 0, 0, 1.0002f)},
  };
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Scene scene =
        sceneWith(rotation(Interpolation::Linear, {0.0f, 1.0f}, {pairs[i][0], pairs[i][1]}), 2.0);
    for (const double time : {0.0, 0.3, 0.5, 0.999, 1.5}) {
      SceneState state;
      evaluate(scene, time, state);
      const glm::dmat3 m(state.world[0]);
      EXPECT_NEAR(glm::determinant(m), 1.0, 1e-9) << "pair " << i << " at " << time;
      EXPECT_NEAR(glm::length(m[0]), 1.0, 1e-9) << "pair " << i << " at " << time;
    }
  }
}

TEST(Animation, CubicRotationIsMadeUnitLengthAndMayVanish) {
  // Tangents zero: halfway is the mean of the two, here (0, 0, 1, 1) / 2, which is 90 degrees once it is unit
  // length.
  const Scene turning = sceneWith(
      rotation(Interpolation::Cubic, {0.0f, 1.0f},
               {glm::vec4(0), {0, 0, 0, 1}, glm::vec4(0), glm::vec4(0), {0, 0, 1, 0}, glm::vec4(0)}),
      2.0);
  expectNear(placeAt(turning, 0.5, 1), {0, 1, 0}, 1e-12);
  const Scene vanishing = sceneWith(
      rotation(Interpolation::Cubic, {0.0f, 1.0f},
               {glm::vec4(0), {0, 0, 0, 1}, glm::vec4(0), glm::vec4(0), {0, 0, 0, -1}, glm::vec4(0)}),
      2.0);
  expectNear(placeAt(vanishing, 0.5, 1), {1, 0, 0}, 1e-12);
}

TEST(Animation, ParentsComeFirstAndScaleMayMirror) {
  Scene scene;
  scene.nodes.resize(3);
  scene.nodes[0].translation = {10, 0, 0};
  scene.nodes[0].scale = {-2, 1, 1};
  scene.nodes[1].parent = 0;
  scene.nodes[1].rotation = glm::dquat(std::sqrt(0.5), 0, 0, std::sqrt(0.5));  // 90 degrees about z
  scene.nodes[2].parent = 1;
  scene.nodes[2].hasMatrix = true;
  scene.nodes[2].matrix[3] = {1, 3, 0, 1};
  SceneState state;
  evaluate(scene, 0.0, state);
  // (1, 3) turned by 90 degrees is (-3, 1); scaled (6, 1); moved (16, 1).
  expectNear(glm::dvec3(state.world[2][3]), {16, 1, 0});
  EXPECT_TRUE(mirrors(state.world[2]));
}

TEST(Animation, FarPlacesKeepTheirDigits) {
  Scene scene =
      sceneWith(translation(Interpolation::Linear, {0.0f, 1.0f}, {{0, 0, 0, 0}, {1, 0, 0, 0}}), 2.0);
  scene.nodes[0].parent = kNone;
  scene.nodes[1].translation = {1e7, 0, 0};
  expectNear(placeAt(scene, 0.125, 1), {1e7 + 0.125, 0, 0}, 1e-8);
}

TEST(Animation, SceneIsAnimatedOnlyWhereSomethingSeenMoves) {
  Scene scene = sceneWith(translation(Interpolation::Linear, {0.0f}, {{0, 0, 0, 0}}), 0.0);
  EXPECT_FALSE(scene.animated());
  EXPECT_EQ(movingNodes(scene), std::vector<bool>({true, true}));
  scene.nodes[1].light = 0;
  EXPECT_TRUE(scene.animated());
  scene.animations[0].channels[0].node = 1;
  EXPECT_EQ(movingNodes(scene), std::vector<bool>({false, true}));
  scene.nodes[1].light = kNone;
  scene.nodes[0].mesh = 0;
  EXPECT_FALSE(scene.animated());
}

}  // namespace
}  // namespace tessera
