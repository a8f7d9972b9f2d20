#include "glsl/shared/tessellation.h"

#include <gtest/gtest.h>

#include "tests/tessellation/reference.hpp"

namespace tessera {
namespace {

using glsl::TessLevels;
using glsl::TessPlace;
using glsl::uint;
using test::Bary;

TessLevels levelsOf(const std::array<unsigned, 3>& outer, unsigned inner) {
  return {outer[0], outer[1], outer[2], inner};
}

/// Each sample of the pattern, off by what fixed-point hardware rounds away, has a number of its own, and the
/// number leads back to it.
void expectOneToOne(const std::array<unsigned, 3>& outer, unsigned inner, std::mt19937& random) {
  const TessLevels levels = levelsOf(outer, inner);
  const std::vector<Bary> samples = test::pattern(outer, inner);
  ASSERT_EQ(glsl::tessCount(levels), samples.size());
  std::vector<bool> seen(samples.size(), false);
  std::uniform_real_distribution<float> noise(-5e-4f, 5e-4f);
  for (const Bary& sample : samples) {
    glm::vec3 at = test::toFloat(sample);
    // Drivers are off by 2.5e-4, but zero is zero.
    for (int axis = 0; axis < 3; ++axis)
      if (at[axis] != 0.0f) at[axis] += noise(random);
    const TessPlace place = glsl::tessPlaceAt(at, levels);
    const uint thread = glsl::tessThread(place, levels);
    ASSERT_LT(thread, samples.size()) << at.x << " " << at.y << " " << at.z;
    ASSERT_FALSE(seen[thread]) << thread << " twice, at " << at.x << " " << at.y << " " << at.z;
    seen[thread] = true;
    const TessPlace back = glsl::tessPlaceOf(thread, levels);
    ASSERT_EQ(back.ring, place.ring) << thread;
    ASSERT_EQ(back.side, place.side) << thread;
    ASSERT_EQ(back.step, place.step) << thread;
    const glm::vec3 exact = glsl::tessBary(back, levels);
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_NEAR(exact[axis], static_cast<float>(sample[static_cast<std::size_t>(axis)]), 2e-7f) << thread;
  }
}

TEST(Tessellation, ThreadsAreOneToOneForAllLevels) {
  std::mt19937 random(1);
  for (unsigned inner = 1; inner <= glsl::kTessLargest; ++inner)
    for (unsigned outer = 1; outer <= glsl::kTessLargest; ++outer) {
      SCOPED_TRACE(testing::Message() << "outer " << outer << ", inner " << inner);
      expectOneToOne({outer, outer, outer}, inner, random);
      if (HasFatalFailure()) return;
    }
}

TEST(Tessellation, ThreadsAreOneToOneForUnequalOuterLevels) {
  std::mt19937 random(2);
  for (int i = 0; i < 4000; ++i) {
    const auto level = [&] { return static_cast<unsigned>(1 + random() % 64); };
    const std::array<unsigned, 3> outer{level(), level(), level()};
    const unsigned inner = level();
    SCOPED_TRACE(testing::Message() << outer[0] << " " << outer[1] << " " << outer[2] << ", inner " << inner);
    expectOneToOne(outer, inner, random);
    if (HasFatalFailure()) return;
  }
}

TEST(Tessellation, CountsByHand) {
  EXPECT_EQ(glsl::tessUniformCount(0), 1u);
  EXPECT_EQ(glsl::tessUniformCount(1), 3u);
  EXPECT_EQ(glsl::tessUniformCount(2), 7u);
  EXPECT_EQ(glsl::tessUniformCount(3), 12u);
  EXPECT_EQ(glsl::tessUniformCount(64), glsl::kTessMostSamples);
  EXPECT_EQ(glsl::tessCount({1, 1, 1, 1}), 3u);
  EXPECT_EQ(glsl::tessCount({2, 1, 1, 1}), 5u) << "inner 1 counts as 2";
  // Hladky 2019, eq. 1.
  for (uint l = 1; l <= glsl::kTessLargest; ++l)
    EXPECT_EQ(glsl::tessUniformCount(l), 3 * (l / 2 + 1) * (l / 2 + l % 2) + (l + 1) % 2) << l;
}

TEST(Tessellation, AnyCountIsMetExactly) {
  for (uint count = 0; count <= 4000; ++count) {
    const TessLevels levels = glsl::tessLevelsFor(count);
    ASSERT_EQ(glsl::tessCount(levels), std::clamp(count, 3u, 3169u)) << count;
    for (uint side = 0; side < 3; ++side) {
      ASSERT_GE(glsl::tessOuter(levels, side), 1u) << count;
      ASSERT_LE(glsl::tessOuter(levels, side), 64u) << count;
    }
    ASSERT_GE(levels.inner, 1u) << count;
    ASSERT_LE(levels.inner, 64u) << count;
    // A smaller inner level would not reach the count.
    if (levels.inner > 2 && count <= 3169) {
      ASSERT_LT(glsl::tessInterior(levels.inner - 1) + glsl::kTessOuterMost, count);
    }
  }
}

}  // namespace
}  // namespace tessera
