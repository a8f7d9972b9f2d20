#include "glsl/shared/footprint.h"

#include <cstdio>
#include <limits>

#include <gtest/gtest.h>

#include "tests/tessellation/reference.hpp"

namespace tessera {
namespace {

using glm::vec3;
using glsl::Footprint;
using glsl::FootprintView;
using glsl::SampleMeasure;
using glsl::SampleOptions;
using test::Long;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
/// 1000 pixels a unit at depth 1, a view of 45 degrees to each side and a quarter more.
constexpr FootprintView kView{{1000.0f, 1000.0f}, {1.25f, 1.25f}, 0.1f};
constexpr SampleOptions kOptions{1.0f, 1.0f, 1.0f, 3.0f, false};

SampleMeasure measure(vec3 a, vec3 b, vec3 c, SampleOptions options = kOptions) {
  return glsl::measureSamples(glsl::footprintOf(a, b, c, kView), options);
}

/// Whatever it is, it can be spawned and stored.
void expectValid(const SampleMeasure& m, const SampleOptions& options) {
  ASSERT_LE(m.kind, glsl::kSampledSplit);
  ASSERT_GE(m.slanted, 0.99f);
  ASSERT_LE(m.slanted, glsl::kMostSlanted);
  if (m.kind == glsl::kSampledL) {
    ASSERT_GE(m.level, 1u);
    ASSERT_LE(m.level, 64u);
  }
  if (m.kind == glsl::kSampledOver) {
    ASSERT_LE(m.shape.apex, 2u);
    ASSERT_GE(m.shape.rows, 1u);
    ASSERT_GT(m.shape.columns0 + m.shape.columns1, 1u);
    ASSERT_NE(m.shape.columns0, 1u);
    ASSERT_NE(m.shape.columns1, 1u);
    ASSERT_LE(std::max(m.shape.columns0, m.shape.columns1), glsl::kOverMostColumns);
    ASSERT_LE(glsl::overCount(m.shape), glsl::kTessMostSamples);
    for (glsl::uint thread = 0; thread < glsl::overCount(m.shape); thread += 7) {
      const vec3 p = glsl::overEven(glsl::overCellOf(thread, m.shape), m.shape);
      ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    }
  }
  if (m.kind == glsl::kSampledSplit) {
    ASSERT_FALSE(options.mustFit);
    ASSERT_GE(m.split, 2u);
    ASSERT_LE(m.split, 64u);
  }
}

TEST(Footprint, MeasuresByHand) {
  // At depth 10 a pixel is 0.01.
  const auto at = [](float x, float y) { return vec3(x * 0.01f, y * 0.01f, -10.0f); };
  const auto kind = [&](float x, float y, float apex) { return measure(at(0, 0), at(x, 0), at(apex, y)); };
  EXPECT_EQ(kind(0.9f, 0.5f, 0.4f).kind, glsl::kSampledOnce);
  SampleMeasure m = kind(1.5f, 1.2f, 0.7f);
  EXPECT_EQ(m.kind, glsl::kSampledL);
  EXPECT_EQ(m.level, 2u);
  m = kind(3.5f, 3.0f, 1.5f);
  EXPECT_EQ(m.level, 4u);
  m = kind(63.5f, 50.0f, 30.0f);
  EXPECT_EQ(m.kind, glsl::kSampledL);
  EXPECT_EQ(m.level, 64u);
  m = kind(64.5f, 50.0f, 30.0f);
  EXPECT_EQ(m.kind, glsl::kSampledSplit);
  EXPECT_EQ(m.split, 2u);
  m = kind(300.0f, 250.0f, 120.0f);
  EXPECT_EQ(m.kind, glsl::kSampledSplit);
  EXPECT_EQ(m.split, 5u);
  m = kind(40.0f, 3.5f, 15.0f);
  EXPECT_EQ(m.kind, glsl::kSampledOver);
  EXPECT_NEAR(m.slanted, 40.0f / 3.5f, 1e-3f);
  EXPECT_EQ(m.shape.apex, 2u);
  EXPECT_EQ(m.shape.rows, 5u);
  EXPECT_EQ(m.shape.columns0, 1u + 15u);
  EXPECT_EQ(m.shape.columns1, 1u + 26u);  // 25 steps are rounded up to 26
  // A bias is a factor on the texels of a pixel.
  SampleOptions half = kOptions;
  half.texelsPerPixel = 0.5f;
  EXPECT_EQ(measure(at(0, 0), at(63.5f, 0), at(30, 50), half).level, 32u);
  SampleOptions sparse = kOptions;
  sparse.levelPerTexel = 0.76f;
  EXPECT_EQ(measure(at(0, 0), at(50, 0), at(25, 43.3f), sparse).level, 38u);
  EXPECT_NEAR(glsl::tessUniformCount(38) / (0.5f * 50 * 43.3f), 1.0f, 0.1f);
  EXPECT_EQ(measure(at(0, 0), at(80, 0), at(40, 60), sparse).kind, glsl::kSampledL);
  EXPECT_EQ(measure(at(0, 0), at(90, 0), at(40, 60), sparse).kind, glsl::kSampledSplit);
  // Mirrored, and seen from behind: only lengths count.
  EXPECT_EQ(measure(at(15, 3.5f), at(40, 0), at(0, 0)).shape.rows, 5u);
  EXPECT_EQ(measure(at(0, 0), at(15, 3.5f), at(40, 0)).shape.apex, 1u);
}

TEST(Footprint, EachMethodAlone) {
  const auto at = [](float x, float y) { return vec3(x * 0.01f, y * 0.01f, -10.0f); };
  SampleOptions all = kOptions;
  all.slantedAbove = 0.0f;
  EXPECT_EQ(measure(at(0, 0), at(20, 0), at(10, 17), all).kind, glsl::kSampledOver);
  SampleOptions none = kOptions;
  none.slantedAbove = 2e30f;
  EXPECT_EQ(measure(at(0, 0), at(20, 0), at(10, 0), none).kind, glsl::kSampledL);
}

TEST(Footprint, LengthsAgainstLongDouble) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  int screen = 0;
  int curved = 0;
  for (int i = 0; i < 100000; ++i) {
    const float depth = std::exp2(unit(random) * 6.0f + 3.0f);
    const float size = depth * std::exp2(unit(random) * 5.0f - 5.0f);
    const vec3 middle = vec3(unit(random), unit(random), -1.0f) * depth;
    vec3 v[3];
    for (vec3& corner : v) corner = middle + vec3(unit(random), unit(random), unit(random)) * size;
    const Footprint f = glsl::footprintOf(v[0], v[1], v[2], kView);
    bool inside = true;
    for (const vec3& corner : v)
      inside = inside && -corner.z >= 0.1f &&
               std::max(std::abs(corner.x), std::abs(corner.y)) <= 1.25f * -corner.z;
    ASSERT_EQ(f.curved, !inside);
    for (int edge = 0; edge < 3; ++edge) {
      const vec3& a = v[(edge + 1) % 3];
      const vec3& b = v[(edge + 2) % 3];
      const auto l = [](float x) { return static_cast<Long>(x); };
      Long expected = 0;
      if (inside) {
        const Long dx = l(a.x) / -l(a.z) - l(b.x) / -l(b.z);
        const Long dy = l(a.y) / -l(a.z) - l(b.y) / -l(b.z);
        expected = 1000 * std::sqrt(dx * dx + dy * dy);
        ++screen;
      } else {
        const Long cx = l(a.y) * l(b.z) - l(a.z) * l(b.y);
        const Long cy = l(a.z) * l(b.x) - l(a.x) * l(b.z);
        const Long cz = l(a.x) * l(b.y) - l(a.y) * l(b.x);
        expected = 1000 * std::atan2(std::sqrt(cx * cx + cy * cy + cz * cz),
                                     l(a.x) * l(b.x) + l(a.y) * l(b.y) + l(a.z) * l(b.z));
        ++curved;
      }
      ASSERT_NEAR(static_cast<double>(f.edges[edge]), static_cast<double>(expected),
                  1e-3 + 1e-5 * static_cast<double>(expected));
    }
  }
  EXPECT_GT(screen, 100000);
  EXPECT_GT(curved, 20000);
}

TEST(Footprint, TrianglesAtTheNearPlaneAskForWhatAnEyeCanSee) {
  // A floor from far ahead to behind the eye: its edges are half a turn at most.
  const SampleMeasure floor = measure({-1, -1, -100}, {1, -1, -100}, {0, -1, 5});
  EXPECT_EQ(floor.kind, glsl::kSampledSplit);
  EXPECT_LE(floor.split, 50u);
  // A corner that all but touches the eye.
  for (const float z : {-0.09f, -1e-3f, -1e-6f, 0.0f, 1e-6f, 1e-3f}) {
    const Footprint f = glsl::footprintOf({0.01f, 0.01f, z}, {1, 0, -10}, {0, 1, -10}, kView);
    EXPECT_LE(std::max({f.edges.x, f.edges.y, f.edges.z}), 3142.0f) << z;
    EXPECT_TRUE(f.curved) << z;
    const vec3 w = glsl::footprintWeights({0.01f, 0.01f, z}, {1, 0, -10}, {0, 1, -10}, f.curved);
    EXPECT_GT(std::min({w.x, w.y, w.z}), 0.0f) << z;
  }
  // Wholly behind the eye, as another view of the visible set may see it: the size that it has from there.
  const SampleMeasure behind = measure({0, 0, 10}, {0.2f, 0, 10}, {0.1f, 0.17f, 10});
  EXPECT_EQ(behind.kind, glsl::kSampledL);
  EXPECT_NEAR(static_cast<float>(behind.level), 20.0f, 1.0f);
  // The eye on a corner: no distances, so no correction.
  EXPECT_EQ(glsl::footprintWeights({0, 0, 0}, {1, 0, -1}, {0, 1, -1}, true), vec3(1.0f));
}

TEST(Footprint, ScreenAndAnglesMeet) {
  // Near the middle of the view both measures agree.
  const vec3 a(0, 0, -10);
  const vec3 b(0.1f, 0, -10);
  const vec3 c(0.05f, 0.08f, -10.01f);
  FootprintView narrow = kView;
  narrow.limits = {0.001f, 0.001f};
  const Footprint screen = glsl::footprintOf(a, b, c, kView);
  const Footprint angles = glsl::footprintOf(a, b, c, narrow);
  EXPECT_FALSE(screen.curved);
  EXPECT_TRUE(angles.curved);
  for (int edge = 0; edge < 3; ++edge) EXPECT_NEAR(screen.edges[edge], angles.edges[edge], 0.01f);
}

TEST(Footprint, HostileTrianglesGetValidSamples) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  int kinds[4] = {};
  for (int i = 0; i < 300000; ++i) {
    vec3 v[3];
    for (vec3& corner : v)
      corner = vec3(unit(random), unit(random), unit(random)) * std::exp2(unit(random) * 20.0f);
    const unsigned what = random() % 10;
    if (what == 0) v[1] = v[0] + (v[2] - v[0]) * 0.3f;                          // flat
    if (what == 1) v[1] = v[0];                                                 // an edge without length
    if (what == 2) v[2] = v[1] = v[0];                                          // a point
    if (what == 3) v[1] = v[0] + vec3(1e-7f, 0, 0) * glm::length(v[2] - v[0]);  // a needle of 1e7
    if (what == 4) v[random() % 3].z = -1e-6f;                                  // on the eye's plane
    if (what == 5) v[random() % 3] = vec3(0.0f);                                // the eye on a corner
    if (what == 6) {
      const float bad[] = {kNan, kInfinity, -kInfinity, 1e38f, -1e38f, 1e-40f};
      v[random() % 3][static_cast<int>(random() % 3)] = bad[random() % 6];
    }
    if (what == 7) v[0].z = -1.0f, v[1].z = -1e4f, v[2].z = -1e6f;
    SampleOptions options = kOptions;
    options.texelsPerPixel = std::exp2(unit(random) * 4.0f);
    options.levelPerTexel = std::exp2(unit(random));
    options.mustFit = random() % 2 == 0;
    if (random() % 4 == 0) options.slantedAbove = random() % 2 == 0 ? 0.0f : 2e30f;
    const Footprint f = glsl::footprintOf(v[0], v[1], v[2], kView);
    const SampleMeasure m = glsl::measureSamples(f, options);
    expectValid(m, options);
    if (HasFatalFailure()) {
      ADD_FAILURE() << "triangle " << i << ": edges " << f.edges.x << " " << f.edges.y << " " << f.edges.z;
      return;
    }
    ++kinds[m.kind];
    const vec3 w = glsl::footprintWeights(v[0], v[1], v[2], f.curved);
    for (int axis = 0; axis < 3; ++axis) ASSERT_TRUE(w[axis] > 0.0f && w[axis] <= 1.0f) << i;
  }
  for (const int kind : kinds) EXPECT_GT(kind, 1000);
}

TEST(Footprint, LengthsThatAreNoneGiveOneTexel) {
  for (const float bad : {kNan, kInfinity, -kInfinity})
    for (int edge = 0; edge < 3; ++edge) {
      Footprint f{vec3(20.0f), false};
      f.edges[edge] = bad;
      EXPECT_EQ(glsl::measureSamples(f, kOptions).kind, glsl::kSampledOnce);
    }
  EXPECT_EQ(glsl::measureSamples({vec3(0.0f), false}, kOptions).kind, glsl::kSampledOnce);
  SampleOptions none = kOptions;
  none.texelsPerPixel = kNan;
  EXPECT_EQ(glsl::measureSamples({vec3(20.0f), false}, none).kind, glsl::kSampledOnce);
}

TEST(Footprint, WhatMustFitFits) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  SampleOptions options = kOptions;
  options.mustFit = true;
  options.slantedAbove = 0.0f;
  double wasted = 0.0;
  int large = 0;
  for (int i = 0; i < 100000; ++i) {
    const float base = std::exp2(unit(random) * 20.0f);
    const float foot = unit(random);
    const float height =
        std::min(base * std::exp2(-unit(random) * 12.0f), base * 0.8f * std::min(foot + 0.3f, 1.3f - foot));
    const vec3 edges(base, std::hypot((1 - foot) * base, height), std::hypot(foot * base, height));
    const SampleMeasure m = glsl::measureSamples({edges, false}, options);
    expectValid(m, options);
    if (HasFatalFailure()) return;
    if (m.kind != glsl::kSampledOver) continue;
    SampleOptions split = options;
    split.mustFit = false;
    const SampleMeasure whole = glsl::measureSamples({edges, false}, split);
    if (whole.kind != glsl::kSampledSplit) continue;
    ++large;
    wasted += 1.0 - glsl::overCount(m.shape) / 3169.0;
    // The pieces of that many segments to an edge, if they are like the whole, need no further split.
    if (whole.split < 64) {
      const SampleMeasure piece =
          glsl::measureSamples({edges / static_cast<float>(whole.split), false}, split);
      ASSERT_NE(piece.kind, glsl::kSampledSplit) << base << " " << height << " " << foot;
    }
  }
  std::printf("what does not fit uses %.0f %% of the samples that would\n", (1.0 - wasted / large) * 100);
  EXPECT_GT(large, 10000);
  EXPECT_LT(wasted / large, 0.4);
}

}  // namespace
}  // namespace tessera
