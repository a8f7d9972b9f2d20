#include "glsl/shared/perspective_map.h"

#include <cstdio>
#include <limits>

#include <gtest/gtest.h>

#include "tests/tessellation/reference.hpp"

namespace tessera {
namespace {

using test::Bary;
using test::Long;

glm::vec3 randomWeights(std::mt19937& random, float octaves) {
  std::uniform_real_distribution<float> exponent(-octaves, 0.0f);
  const float scale = std::exp2(std::uniform_real_distribution<float>(-20, 20)(random));
  return glm::vec3(std::exp2(exponent(random)), std::exp2(exponent(random)), std::exp2(exponent(random))) *
         scale;
}

/// p_i / w_i, made to sum to 1.
Bary surface(glm::vec3 p, glm::vec3 w) {
  Bary at{};
  Long sum = 0;
  for (int i = 0; i < 3; ++i)
    sum += at[static_cast<std::size_t>(i)] = static_cast<Long>(p[i]) / static_cast<Long>(w[i]);
  for (Long& one : at) one /= sum;
  return at;
}

TEST(PerspectiveMap, RoundTripIsTheIdentity) {
  std::mt19937 random(1);
  // log2 of w ratios: 1, 1e4, 1e6, 1e12.
  for (const float octaves : {0.0f, 13.3f, 19.9f, 39.0f}) {
    double worst = 0.0;
    double worstSurface = 0.0;
    for (int i = 0; i < 100000; ++i) {
      const glm::vec3 raw = randomWeights(random, octaves);
      const glm::vec3 w = glsl::perspectiveWeights(raw);
      const glm::vec3 p = test::randomBary(random);
      const glm::vec3 b = glsl::surfaceFromEven(p, w);
      const glm::vec3 back = glsl::evenFromSurface(b, w);
      const Bary expected = surface(p, raw);
      for (int axis = 0; axis < 3; ++axis) {
        worst = std::max(worst, static_cast<double>(std::abs(back[axis] - p[axis])));
        worstSurface =
            std::max(worstSurface, std::abs(static_cast<double>(static_cast<Long>(b[axis]) -
                                                                expected[static_cast<std::size_t>(axis)])));
      }
    }
    std::printf("w ratios to %.1e: round trip off by %.2g, the surface point by %.2g\n",
                std::exp2(static_cast<double>(octaves)), worst, worstSurface);
    EXPECT_LT(worst, 1e-6);
    EXPECT_LT(worstSurface, 1e-6);
  }
}

TEST(PerspectiveMap, HandWorked) {
  // Half-way on screen between depths 1 and 3 is a quarter of the way on the surface.
  const glm::vec3 b = glsl::surfaceFromEven({0.5f, 0.5f, 0.0f}, glsl::perspectiveWeights({1, 3, 1}));
  EXPECT_FLOAT_EQ(b.x, 0.75f);
  EXPECT_FLOAT_EQ(b.y, 0.25f);
  const glm::vec3 p = glsl::evenFromSurface({0.75f, 0.25f, 0.0f}, glsl::perspectiveWeights({1, 3, 1}));
  EXPECT_FLOAT_EQ(p.x, 0.5f);
  EXPECT_EQ(glsl::surfaceFromEven({0.2f, 0.3f, 0.5f}, glsl::perspectiveWeights({7, 7, 7})).x, 0.2f);
}

TEST(PerspectiveMap, WeightsThatAreNoneMeanNoCorrection) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float bad :
       {0.0f, -1.0f, -0.0f, std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity, 1e-30f, 1e30f})
    for (int axis = 0; axis < 3; ++axis) {
      glm::vec3 w(1.0f, 2.0f, 3.0f);
      w[axis] = bad;
      EXPECT_EQ(glsl::perspectiveWeights(w), glm::vec3(1.0f)) << bad;
    }
  EXPECT_EQ(glsl::perspectiveWeights({1e-10f, 1.0f, 1e10f}), glm::vec3(1.0f)) << "a ratio of 1e20";
  EXPECT_EQ(glsl::perspectiveWeights({1.0f, 2.0f, 4.0f}), glm::vec3(0.25f, 0.5f, 1.0f));
}

TEST(PerspectiveMap, SamplesOutsideAreExtrapolatedUpToTheHorizon) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(-1.0f, 2.0f);
  int extrapolated = 0;
  int clamped = 0;
  for (int i = 0; i < 100000; ++i) {
    const glm::vec3 raw = randomWeights(random, i % 2 == 0 ? 1.0f : 13.3f);
    const glm::vec3 w = glsl::perspectiveWeights(raw);
    glm::vec3 p(unit(random), unit(random), 0.0f);
    p.z = 1.0f - p.x - p.y;
    const glm::vec3 b = glsl::surfaceFromEvenOutside(p, w);
    ASSERT_NEAR(b.x + b.y + b.z, 1.0f, 2e-5f * (std::abs(b.x) + std::abs(b.y) + std::abs(b.z)));
    const Long left = static_cast<Long>(p.x) / static_cast<Long>(w.x) +
                      static_cast<Long>(p.y) / static_cast<Long>(w.y) +
                      static_cast<Long>(p.z) / static_cast<Long>(w.z);
    if (std::min({b.x, b.y, b.z}) >= 0.0f && std::min({p.x, p.y, p.z}) < 0.0f) {
      ++clamped;
      continue;
    }
    ++extrapolated;
    // In front of the eye, and on the line that leads through p.
    ASSERT_GT(left, 0);
    const Bary expected = surface(p, w);
    for (int axis = 0; axis < 3; ++axis) {
      const double e = static_cast<double>(expected[static_cast<std::size_t>(axis)]);
      ASSERT_NEAR(static_cast<double>(b[axis]), e, 1e-4 * std::max(1.0, std::abs(e)));
    }
  }
  EXPECT_GT(extrapolated, 20000);
  EXPECT_GT(clamped, 5000);
  // Inside, it is the map itself.
  for (int i = 0; i < 1000; ++i) {
    const glm::vec3 w = glsl::perspectiveWeights(randomWeights(random, 13.3f));
    const glm::vec3 p = test::randomBary(random);
    ASSERT_EQ(glsl::surfaceFromEvenOutside(p, w), glsl::surfaceFromEven(p, w));
  }
}

}  // namespace
}  // namespace tessera
