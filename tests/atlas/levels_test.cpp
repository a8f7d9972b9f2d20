#include "glsl/shared/levels.h"

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

#include "glsl/shared/pressure.h"
#include "tests/atlas/measure_reference.hpp"

namespace tessera {
namespace {

using glsl::PatchMeasure;
using test::angle;
using test::area;
using test::Corners;
using test::Long;
using test::Reference;
using test::referenceMeasure;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr glsl::LevelRange kAll{0, 8, 10};
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

PatchMeasure measure(const Corners& v, unsigned triangles, float pixels) {
  return glsl::measurePatch(v[0], v[1], v[2], v[3], v[4], triangles, pixels);
}

/// The level by trying all of them; `clear` says whether the choice is farther than `margin` from a tie.
glsl::uint bestLevel(Long logArea, Long logAspect, int maximum, Long margin, bool& clear) {
  int best = 0;
  Long distance = 1e9L;
  Long second = 1e9L;
  const auto consider = [&](int candidate, Long d) {
    if (d < distance) {
      second = distance;
      distance = d;
      best = candidate;
    } else {
      second = std::min(second, d);
    }
  };
  for (int a = 0; a <= 2 * maximum; ++a) consider(a, std::abs(logArea - a));
  clear = second - distance > margin;
  const int chosen = best;
  distance = second = 1e9L;
  for (int w = 0; w <= maximum; ++w)
    for (int h = 0; h <= maximum; ++h)
      if (w + h == chosen) consider(w - h, std::abs(logAspect - (w - h)));
  clear = clear && second - distance > margin;
  const int wide = std::abs(best);
  return static_cast<glsl::uint>((chosen + wide) / 2) | static_cast<glsl::uint>((chosen - wide) / 2) << 4 |
         (best < 0 ? glsl::kLevelTransposed : 0u);
}

TEST(Levels, NearestLevelByBruteForce) {
  std::mt19937 random(1);
  int compared = 0;
  for (int i = 0; i < 300000; ++i) {
    const int maximum = 1 + i % static_cast<int>(glsl::kMaxBlockLog2);
    const PatchMeasure m = {std::uniform_real_distribution<float>(-8, 26)(random),
                            std::uniform_real_distribution<float>(-16, 16)(random)};
    const float bias = i % 3 == 0 ? 0.0f : std::uniform_real_distribution<float>(-4, 8)(random);
    bool clear = false;
    const glsl::uint expected = bestLevel(static_cast<Long>(m.logArea) - static_cast<Long>(bias),
                                          static_cast<Long>(m.logAspect), maximum, 1e-5L, clear);
    const glsl::uint got =
        glsl::selectLevel(m, bias, 0.0f, {0, static_cast<glsl::uint>(maximum), 10}, 0, -1.0f);
    ASSERT_GE(glsl::levelWidth(got), glsl::levelHeight(got));
    if (!clear) continue;
    ++compared;
    ASSERT_EQ(got, expected) << m.logArea << " - " << bias << ", " << m.logAspect << ", max " << maximum;
  }
  EXPECT_GT(compared, 299000 * 9 / 10);
}

TEST(Levels, HandWorkedLevels) {
  const auto level = [](float a, float aspect) {
    return glsl::selectLevel({a, aspect}, 0.0f, 0.0f, kAll, 0, -1.0f);
  };
  EXPECT_EQ(level(0.0f, 0.0f), 0u);
  EXPECT_EQ(level(0.49f, 5.0f), 0u);
  EXPECT_EQ(level(1.0f, 0.0f), glsl::packLevel(1, 0, false));
  EXPECT_EQ(level(1.0f, -3.0f), glsl::packLevel(1, 0, true));
  EXPECT_EQ(level(6.0f, 0.0f), glsl::packLevel(3, 3, false));
  EXPECT_EQ(level(7.0f, 2.8f), glsl::packLevel(5, 2, false));
  EXPECT_EQ(level(7.0f, -2.8f), glsl::packLevel(5, 2, true));
  EXPECT_EQ(level(16.0f, 9.0f), glsl::packLevel(8, 8, false));
  EXPECT_EQ(level(14.0f, 9.0f), glsl::packLevel(8, 6, false));
  EXPECT_EQ(level(40.0f, 0.0f), glsl::packLevel(8, 8, false));
  EXPECT_EQ(level(5.0f, 20.0f), glsl::packLevel(5, 0, false));
  // A patch of four largest blocks: the constant bias counts from its area, that of pressure from the block.
  EXPECT_EQ(glsl::selectLevel({18.0f, 0.0f}, 2.0f, 0.0f, kAll, 0, -1.0f), glsl::packLevel(8, 8, false));
  EXPECT_EQ(glsl::selectLevel({18.0f, 0.0f}, 0.0f, 2.0f, kAll, 0, -1.0f), glsl::packLevel(7, 7, false));
  EXPECT_EQ(glsl::selectLevel({18.0f, 0.0f}, 0.0f, glsl::kLargestBias, kAll, 0, -1.0f), 0u);
}

TEST(Levels, HysteresisIsHalfAStepAndMore) {
  const glsl::uint previous = glsl::packLevel(4, 2, false);  // area 6, aspect 2
  const auto next = [&](float a, float aspect, float h) {
    return glsl::selectLevel({a, aspect}, 0.0f, 0.0f, kAll, previous, h);
  };
  EXPECT_EQ(next(6.74f, 2.0f, 0.25f), previous);
  EXPECT_EQ(next(6.76f, 2.0f, 0.25f), glsl::packLevel(5, 2, false));
  EXPECT_EQ(next(6.55f, 2.0f, -1.0f), glsl::packLevel(5, 2, false));
  EXPECT_EQ(next(5.26f, 2.0f, 0.25f), previous);
  EXPECT_EQ(next(5.24f, 2.0f, 0.25f), glsl::packLevel(4, 1, false));
  EXPECT_EQ(next(6.0f, 3.24f, 0.25f), previous);
  EXPECT_EQ(next(6.0f, 3.26f, 0.25f), glsl::packLevel(5, 1, false));
  EXPECT_EQ(next(6.0f, 0.76f, 0.25f), previous);
  EXPECT_EQ(next(6.0f, 0.74f, 0.25f), glsl::packLevel(3, 3, false));
  // Whatever was there before, a level is valid and at most half a step plus the hysteresis from the ideal.
  std::mt19937 random(2);
  for (int i = 0; i < 100000; ++i) {
    const PatchMeasure m = {std::uniform_real_distribution<float>(-3, 20)(random),
                            std::uniform_real_distribution<float>(-9, 9)(random)};
    const glsl::uint level = glsl::selectLevel(m, 0.0f, 0.0f, kAll, random() & 0x1ffu, 0.3f);
    const int w = static_cast<int>(glsl::levelWidth(level));
    const int h = static_cast<int>(glsl::levelHeight(level));
    ASSERT_LE(w, 8);
    ASSERT_LE(std::abs(std::clamp(m.logArea, 0.0f, 16.0f) - static_cast<float>(w + h)), 0.801f);
  }
}

TEST(Levels, MeasuresAgainstLongDouble) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  Long worstArea = 0;
  Long worstAspect = 0;
  for (int i = 0; i < 200000; ++i) {
    const unsigned triangles = 1 + static_cast<unsigned>(i) % 3;
    const float distance = std::exp2(std::uniform_real_distribution<float>(-6, 12)(random));
    const float size = distance * std::exp2(std::uniform_real_distribution<float>(-18, 1)(random));
    const float stretch = std::exp2(std::uniform_real_distribution<float>(-8, 0)(random));
    const glm::vec3 center =
        glm::normalize(glm::vec3(normal(random), normal(random), normal(random))) * distance;
    Corners v;
    for (glm::vec3& corner : v) {
      corner = glm::vec3(normal(random), normal(random) * stretch, normal(random)) * size;
      corner += center;
    }
    const Reference expected = referenceMeasure(v, triangles, 1000);
    const PatchMeasure got = measure(v, triangles, 1000.0f);
    if (!std::isfinite(static_cast<double>(expected.condition)) || expected.condition > 1e5L) continue;
    const Long allowed = 2e-6L + 1e-6L * expected.condition;
    const Long areaError = std::abs(static_cast<Long>(got.logArea) - expected.logArea);
    ASSERT_LE(areaError, allowed) << "patch " << i << ", " << triangles << " triangles, condition "
                                  << static_cast<double>(expected.condition);
    const Long aspectError = std::abs(static_cast<Long>(got.logAspect) - expected.logAspect);
    ASSERT_LE(aspectError, 1e-5L) << "patch " << i;
    if (expected.condition < 100) worstArea = std::max(worstArea, areaError);
    worstAspect = std::max(worstAspect, aspectError);
  }
  RecordProperty("worst_log2_area", fmt::format("{:.3g}", static_cast<double>(worstArea)));
  std::printf("log2 errors: area %.2g (well-conditioned), aspect %.2g\n", static_cast<double>(worstArea),
              static_cast<double>(worstAspect));
}

TEST(Levels, PatchesLaidOutByHand) {
  // Far enough away that one unit is one pixel.
  const float far = 1.0e4f;
  const auto at = [&](float x, float y) { return glm::vec3(x, y, -far); };
  const auto expectMeasure = [&](const Corners& v, unsigned triangles, float texels, float aspect) {
    const PatchMeasure m = measure(v, triangles, far);
    EXPECT_NEAR(m.logArea, std::log2(texels), 1e-4f);
    EXPECT_NEAR(m.logAspect, std::log2(aspect), 1e-4f);
  };
  // A rectangle of 8 x 2: its block is its size.
  expectMeasure({at(0, 0), at(8, 0), at(8, 2), at(0, 2), at(0, 0)}, 2, 16, 4);
  // Turned: taller than wide.
  expectMeasure({at(0, 0), at(2, 0), at(2, 8), at(0, 8), at(0, 0)}, 2, 16, 0.25f);
  // A single fills half its block; the mirrored half says nothing about the shape.
  expectMeasure({at(0, 0), at(8, 0), at(8, 2), at(8, 0), at(0, 0)}, 1, 16, 4);
  // A triple: the two parts of its x edge count together.
  expectMeasure({at(4, 0), at(8, 0), at(8, 2), at(0, 2), at(0, 0)}, 3, 16, 4);
}

TEST(Levels, ArcTangentIsExactToFloats) {
  double worst = 0.0;
  std::mt19937 random(8);
  for (int i = 0; i < 300000; ++i) {
    const float y = std::exp2(std::uniform_real_distribution<float>(-30, 30)(random));
    const float x =
        (i % 2 == 0 ? 1.0f : -1.0f) * std::exp2(std::uniform_real_distribution<float>(-30, 30)(random));
    const float nearby = i % 3 == 0 ? y * std::uniform_real_distribution<float>(-3, 3)(random) : x;
    const Long exact = std::atan2(static_cast<Long>(y), static_cast<Long>(nearby));
    worst = std::max(
        worst,
        std::abs(static_cast<double>(static_cast<Long>(glsl::upperArcTangent(y, nearby)) / exact - 1)));
  }
  std::printf("relative error of the arc tangent: %.2g\n", worst);
  EXPECT_LT(worst, 3e-7);
  EXPECT_EQ(glsl::upperArcTangent(0.0f, 0.0f), 0.0f);
  EXPECT_EQ(glsl::upperArcTangent(0.0f, 1.0f), 0.0f);
  EXPECT_FLOAT_EQ(glsl::upperArcTangent(0.0f, -1.0f), glm::pi<float>());
  EXPECT_FLOAT_EQ(glsl::upperArcTangent(1.0f, 0.0f), glm::half_pi<float>());
}

TEST(Levels, AnglesKeepTheirDigits) {
  // An edge of a tenth of a pixel at 1080p: about 1e-4 rad.
  double worstAtan = 0.0;
  double worstAcos = 0.0;
  std::mt19937 random(4);
  std::normal_distribution<float> normal;
  for (int i = 0; i < 10000; ++i) {
    const glm::vec3 a = glm::vec3(normal(random), normal(random), normal(random)) * 10.0f;
    const glm::vec3 b = a + glm::vec3(normal(random), normal(random), normal(random)) * 1e-3f;
    const Long exact = angle(a, b);
    if (exact < 2e-5L || exact > 2e-4L) continue;
    worstAtan = std::max(
        worstAtan, std::abs(static_cast<double>(static_cast<Long>(glsl::angleBetween(a, b)) / exact - 1)));
    const auto printed = static_cast<Long>(glsl::angleByAcos(a, b));
    worstAcos =
        std::max(worstAcos, std::isnan(printed) ? 1.0 : std::abs(static_cast<double>(printed / exact - 1)));
  }
  std::printf("relative error at about 1e-4 rad: atan2 form %.2g, acos form %.2g\n", worstAtan, worstAcos);
  EXPECT_LT(worstAtan, 1e-6);
  EXPECT_GT(worstAcos, 0.5) << "the acos form is not as bad as is claimed";
  EXPECT_NEAR(glsl::angleBetween({1, 0, 0}, {-2, 0, 0}), glm::pi<float>(), 1e-6f);
  EXPECT_NEAR(glsl::angleBetween({1, 0, 0}, {0, 3, 0}), glm::half_pi<float>(), 1e-6f);
  EXPECT_EQ(glsl::angleBetween({0, 0, 0}, {0, 3, 0}), 0.0f);
  EXPECT_EQ(glsl::angleBetween({1, 2, 3}, {1, 2, 3}), 0.0f);
}

TEST(Levels, AreasOfNeedles) {
  // Sides 1e4, 1e4 and 1e-3: a needle of 1e7 to 1. The exact area is that of the lengths as floats.
  double worstKahan = 0.0;
  double worstHeron = 0.0;
  std::mt19937 random(5);
  for (int i = 0; i < 10000; ++i) {
    const float a = std::uniform_real_distribution<float>(1.0f, 2.0f)(random) * 1e4f;
    const float c = std::uniform_real_distribution<float>(1.0f, 2.0f)(random) * 1e-3f;
    const Long exact = area(static_cast<Long>(a), static_cast<Long>(c), static_cast<Long>(a));
    const float orders[][3] = {{a, a, c}, {a, c, a}, {c, a, a}};
    for (const auto& o : orders) {
      worstKahan = std::max(
          worstKahan,
          std::abs(static_cast<double>(static_cast<Long>(glsl::triangleArea(o[0], o[1], o[2])) / exact - 1)));
      worstHeron = std::max(worstHeron,
                            std::abs(static_cast<double>(
                                static_cast<Long>(glsl::triangleAreaByHeron(o[0], o[1], o[2])) / exact - 1)));
    }
  }
  std::printf("relative error of a needle's area: Kahan %.2g, Heron %.2g\n", worstKahan, worstHeron);
  EXPECT_LT(worstKahan, 1e-6);
  EXPECT_GT(worstHeron, 0.5) << "Heron's form is not as bad as is claimed";
  EXPECT_FLOAT_EQ(glsl::triangleArea(3, 4, 5), 6.0f);
  EXPECT_FLOAT_EQ(glsl::triangleAreaByHeron(3, 4, 5), 6.0f);
  EXPECT_EQ(glsl::triangleArea(1, 2, 3), 0.0f);
  EXPECT_EQ(glsl::triangleArea(1, 1, 3), 0.0f);  // no such triangle
  EXPECT_EQ(glsl::triangleArea(0, 0, 0), 0.0f);
}

TEST(Levels, DegenerateViewsGiveValidLevels) {
  const glm::vec3 a(0, 0, -1);
  const glm::vec3 b(1, 0, -1);
  const glm::vec3 c(1, 1, -1);
  const glm::vec3 d(0, 1, -1);
  const auto levelOf = [](const Corners& v, float pixels) {
    const PatchMeasure m = measure(v, 2, pixels);
    EXPECT_TRUE(std::isfinite(m.logArea));
    EXPECT_TRUE(std::isfinite(m.logAspect));
    EXPECT_LE(std::abs(m.logArea), 100.0f);
    EXPECT_LE(std::abs(m.logAspect), 20.0f);
    const glsl::uint level = glsl::selectLevel(m, 0.0f, 0.0f, kAll, 0, -1.0f);
    EXPECT_LE(glsl::levelWidth(level), 8u);
    EXPECT_LE(glsl::levelHeight(level), glsl::levelWidth(level));
    return level;
  };
  levelOf({a - a, b - a, c - a, d - a, a - a}, 1000.0f);  // the eye on a vertex
  const glm::vec3 middle = (a + b) / 2.0f;
  levelOf({a - middle, b - middle, c - middle, d - middle, a - middle}, 1000.0f);  // on an edge
  const glm::vec3 inside = (a + c) / 2.0f;
  levelOf({a - inside, b - inside, c - inside, d - inside, a - inside}, 1000.0f);  // on the diagonal
  EXPECT_EQ(levelOf({a, a, a, a, a}, 1000.0f), 0u);                                // one point
  EXPECT_EQ(levelOf({b - b, b - b, b - b, b - b, b - b}, 1000.0f), 0u);            // one point, the eye on it
  EXPECT_EQ(levelOf({a, b, c, d, a}, 1e30f), 0u);                                  // overflows to infinity
  EXPECT_EQ(levelOf({a, b, c, d, a}, kNan), 0u);
  EXPECT_EQ(levelOf({a * 1e20f, b * 1e20f, c * 1e20f, d * 1e20f, a}, 1000.0f), 0u);
  for (std::size_t corner = 0; corner < 5; ++corner)
    for (const float bad : {kNan, kInfinity, -kInfinity}) {
      Corners v = {a, b, c, d, a};
      v[corner].y = bad;
      EXPECT_EQ(levelOf(v, 1000.0f), 0u) << "corner " << corner;
    }
  // A needle of 1e7, areas of 1e-6 and 1e12 pixels.
  EXPECT_EQ(levelOf({a, b, b + glm::vec3(0, 1e-7f, 0), a + glm::vec3(0, 1e-7f, 0), a}, 1e4f),
            glsl::packLevel(3, 0, false));  // 7854 x 0.001 pixels
  EXPECT_EQ(
      levelOf({a, a + glm::vec3(1e-6f, 0, 0), a + glm::vec3(1e-6f, 1e-6f, 0), a + glm::vec3(0, 1e-6f, 0), a},
              1e3f),
      0u);
  EXPECT_EQ(levelOf({a, b, c, d, a}, 1e6f), glsl::packLevel(8, 8, false));
  for (const float m : {kNan, kInfinity, -kInfinity}) {
    EXPECT_EQ(glsl::selectLevel({m, 0.0f}, 0.0f, 0.0f, kAll, 0x22u, 0.5f), 0u);
    EXPECT_EQ(glsl::selectLevel({4.0f, m}, 0.0f, 0.0f, kAll, 0x22u, 0.5f), 0u);
    EXPECT_EQ(glsl::selectLevel({4.0f, 0.0f}, m, 0.0f, kAll, 0x22u, 0.5f), 0u);
    EXPECT_EQ(glsl::selectLevel({4.0f, 0.0f}, 0.0f, m, kAll, 0x22u, 0.5f), 0u);
    EXPECT_EQ(glsl::idealTexels({m, 0.0f}, 0.0f, kAll), 1u);
  }
}

TEST(Levels, BiasOfPressure) {
  EXPECT_FLOAT_EQ(glsl::pressureBias(8000, 0, 0, kAll, 1000.0f, 0.0f), 3.0f);
  EXPECT_FLOAT_EQ(glsl::pressureBias(8000, 0, 100, kAll, 1100.0f, 0.0f), 3.0f);  // I = 8100, d = 100
  EXPECT_EQ(glsl::pressureBias(500, 0, 0, kAll, 1000.0f, 0.0f), 0.0f);           // room to spare
  EXPECT_EQ(glsl::pressureBias(0, 0, 0, kAll, 1000.0f, 0.0f), 0.0f);
  EXPECT_EQ(glsl::pressureBias(0, 0, 100, kAll, 50.0f, 0.0f), 0.0f);  // I = d > S: nothing can shrink
  EXPECT_EQ(glsl::pressureBias(8000, 0, 1000, kAll, 1000.0f, 0.0f), glsl::kLargestBias);  // S = d
  EXPECT_EQ(glsl::pressureBias(8000, 0, 2000, kAll, 1000.0f, 0.0f), glsl::kLargestBias);  // S < d
  EXPECT_EQ(glsl::pressureBias(8000, 0, 0, kAll, kNan, 0.0f), glsl::kLargestBias);
  EXPECT_FLOAT_EQ(glsl::pressureBias(0, 4, 0, kAll, 1024.0f, 0.0f), 24.0f);  // 2^34 texels
  EXPECT_EQ(glsl::pressureBias(~0u, ~0u, 0, kAll, 1.0f, 0.0f), glsl::kLargestBias);
  // Three of 16 x 16, and so 768 texels that cannot shrink.
  EXPECT_FLOAT_EQ(glsl::pressureBias(1024, 0, 3, {4, 8, 10}, 1024.0f, 0.0f), 2.0f);
  // 2^12 blocks of 2^20 texels: more than 32 bits count.
  EXPECT_EQ(glsl::pressureBias(1u << 20, 0, 1u << 12, {10, 10, 10}, 1e9f, 0.0f), glsl::kLargestBias);
  EXPECT_FLOAT_EQ(glsl::biasedTexels(5, 3, 0.0f), 3.0f * 4294967296.0f);
  EXPECT_FLOAT_EQ(glsl::biasedTexels(800, 0, 3.0f), 100.0f);
  EXPECT_FLOAT_EQ(glsl::biasedTexels(800, 0, -1.0f), 1600.0f);
  // The bias brings ideal areas down to the target.
  std::mt19937 random(6);
  std::vector<PatchMeasure> patches(20000);
  for (PatchMeasure& m : patches) m = {std::uniform_real_distribution<float>(2, 12)(random), 0.0f};
  const auto sum = [&](float bias, std::uint64_t& ones) {
    std::uint64_t total = 0;
    ones = 0;
    for (const PatchMeasure& m : patches) {
      const glsl::uint texels = glsl::idealTexels(m, bias, kAll);
      total += texels;
      ones += texels == 1 ? 1 : 0;
    }
    return total;
  };
  std::uint64_t ones = 0;
  const std::uint64_t ideal = sum(0.0f, ones);
  const float target = 1e6f;
  const float bias = glsl::pressureBias(static_cast<glsl::uint>(ideal - ones), 0,
                                        static_cast<glsl::uint>(ones), kAll, target, 0.0f);
  EXPECT_GT(bias, 3.0f);
  EXPECT_NEAR(static_cast<double>(sum(bias, ones)), 1e6, 0.02e6);
}

TEST(Levels, IdealTexels) {
  EXPECT_EQ(glsl::idealTexels({6.0f, 0.0f}, 0.0f, kAll), 64u);
  EXPECT_EQ(glsl::idealTexels({6.0f, 0.0f}, 1.0f, kAll), 32u);
  EXPECT_EQ(glsl::idealTexels({99.0f, 0.0f}, 0.0f, kAll), 65536u);
  EXPECT_EQ(glsl::idealTexels({99.0f, 0.0f}, 0.0f, {0, 10, 10}), 1u << 20);
  EXPECT_EQ(glsl::idealTexels({0.49f, 0.0f}, 0.0f, kAll), 1u);
  EXPECT_EQ(glsl::idealTexels({-50.0f, 0.0f}, 0.0f, kAll), 1u);
}

TEST(LevelRange, EveryLevelLiesInItAndNoNearerOneDoes) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> area(-4.0f, 24.0f);
  std::uniform_real_distribution<float> aspect(-20.0f, 20.0f);
  for (glsl::uint smallest = 0; smallest <= 8; ++smallest)
    for (glsl::uint largest = smallest; largest <= 8; ++largest)
      for (const glsl::uint widest : {1u, 2u, 3u, 10u})
        for (int i = 0; i < 50; ++i) {
          const glsl::LevelRange range{smallest, largest, widest};
          const glsl::PatchMeasure measure{area(random), aspect(random)};
          const glsl::uint level = glsl::selectLevel(measure, 0.0f, 0.0f, range, 0, -1.0f);
          const auto w = static_cast<int>(glsl::levelWidth(level));
          const auto h = static_cast<int>(glsl::levelHeight(level));
          ASSERT_GE(h, static_cast<int>(smallest));
          ASSERT_LE(w, static_cast<int>(largest));
          ASSERT_LE(w - h, static_cast<int>(widest));
          // The nearest of all levels of the range: first by area, then by aspect.
          const auto distance = [&](int ww, int hh, int sign) {
            const float clamped = std::clamp(measure.logArea, 2.0f * static_cast<float>(smallest),
                                             2.0f * static_cast<float>(largest));
            return std::pair(std::abs(clamped - static_cast<float>(ww + hh)),
                             std::abs(measure.logAspect - static_cast<float>(sign * (ww - hh))));
          };
          const auto chosen = distance(w, h, glsl::levelTransposed(level) ? -1 : 1);
          for (int ww = static_cast<int>(smallest); ww <= static_cast<int>(largest); ++ww)
            for (int hh = std::max(static_cast<int>(smallest), ww - static_cast<int>(widest)); hh <= ww; ++hh)
              for (const int sign : {-1, 1}) {
                const auto other = distance(ww, hh, sign);
                ASSERT_FALSE(other.first < chosen.first - 1e-4f ||
                             (ww + hh == w + h && other.second < chosen.second - 1e-4f))
                    << measure.logArea << ", " << measure.logAspect << ": " << w << " x " << h << ", not "
                    << ww << " x " << hh;
              }
          // What is kept by hysteresis lies in the range, too.
          const glsl::uint kept = glsl::selectLevel(measure, 0.0f, 0.0f, range, random() & 0x1ffu, 2.0f);
          ASSERT_GE(glsl::levelHeight(kept), smallest);
          ASSERT_LE(glsl::levelWidth(kept), largest);
          ASSERT_LE(glsl::levelWidth(kept) - glsl::levelHeight(kept), widest);
        }
}

TEST(Levels, SmallerForWantOfMemory) {
  const auto chain = [](glsl::uint w, glsl::uint h, const glsl::LevelRange& range) {
    std::string steps;
    glsl::uint level = glsl::packLevel(w, h, true);
    for (glsl::uint next = glsl::smallerLevel(level, range); next != level;
         next = glsl::smallerLevel(level, range)) {
      level = next;
      EXPECT_EQ(glsl::levelTransposed(level), w != h && glsl::levelWidth(level) != glsl::levelHeight(level));
      steps += std::to_string(glsl::levelWidth(level)) + std::to_string(glsl::levelHeight(level)) + " ";
    }
    return steps;
  };
  EXPECT_EQ(chain(3, 3, kAll), "22 11 10 ");
  EXPECT_EQ(chain(4, 1, kAll), "30 20 10 ");
  EXPECT_EQ(chain(1, 0, kAll), "");
  EXPECT_EQ(chain(5, 3, {2, 8, 10}), "42 32 22 ");
  EXPECT_EQ(chain(3, 3, {3, 3, 10}), "");
  const glsl::uint reduced = glsl::packLevel(3, 1, true) | glsl::kLevelReduced;
  EXPECT_TRUE(glsl::waitsForMemory(reduced, glsl::packLevel(4, 1, true)));
  EXPECT_TRUE(glsl::waitsForMemory(reduced, glsl::packLevel(3, 2, true)));
  EXPECT_FALSE(glsl::waitsForMemory(reduced, glsl::packLevel(4, 0, true))) << "another shape";
  EXPECT_FALSE(glsl::waitsForMemory(reduced, glsl::packLevel(2, 1, true))) << "wants less than it has";
  EXPECT_FALSE(glsl::waitsForMemory(glsl::packLevel(3, 1, true), glsl::packLevel(4, 1, true)));
}

TEST(Pressure, RoomToSpareLowersTheBiasToItsFloor) {
  EXPECT_FLOAT_EQ(glsl::pressureBias(500, 0, 0, kAll, 1000.0f, -2.0f), -1.0f);
  EXPECT_FLOAT_EQ(glsl::pressureBias(100, 0, 0, kAll, 1000.0f, -2.0f), -2.0f);
  EXPECT_FLOAT_EQ(glsl::pressureBias(8000, 0, 0, kAll, 1000.0f, -2.0f), 3.0f);
  EXPECT_EQ(glsl::pressureBias(0, 0, 100, kAll, 1000.0f, -2.0f), 0.0f);  // nothing that could grow
}

class PressureSteps : public ::testing::Test {
 protected:
  // highWater, softWater, targetStart, targetLargest, targetSmallest, targetCut, targetGrowth, quietFrames
  glsl::PressureConfig config{900.0f, 800.0f, 600.0f, 700.0f, 100.0f, 0.5f, 1.5f, 3, 1, 1};
  glsl::PressureState state = glsl::pressureAtStart(config);
  glsl::PressureInput calm{};
  void open(const glsl::PressureInput& last) { state = glsl::stepPressure(state, config, last); }
  void step(bool failed, float load, bool held = false, bool asked = false) {
    glsl::PressureInput last = calm;
    last.failed = failed;
    last.load = load;
    last.limits = true;
    last.held = held;
    last.asked = asked;
    open(last);
  }
  void live(float texels, bool limits = true) {
    glsl::PressureInput last = calm;
    last.live = texels;
    last.limits = limits;
    open(last);
  }
};

TEST_F(PressureSteps, ExhaustionAndTheMarkResetAndCut) {
  step(false, 900.0f);
  EXPECT_EQ(state.reset, 0u) << "at the mark is not past it";
  EXPECT_EQ(state.target, 600.0f);
  step(false, 901.0f);
  EXPECT_EQ(state.reset, 1u);
  EXPECT_EQ(state.target, 300.0f);
  step(true, 0.0f);
  EXPECT_EQ(state.reset, 0u) << "the second reset in a row waits for two frames";
  EXPECT_EQ(state.target, 150.0f) << "memory packed afresh was too small";
  step(true, 0.0f);
  EXPECT_EQ(state.reset, 1u);
  EXPECT_EQ(state.target, 150.0f);
  for (int i = 0; i < 3; ++i) {
    step(false, 0.0f);
    EXPECT_EQ(state.target, 150.0f);
  }
  step(false, 0.0f);
  EXPECT_EQ(state.target, 225.0f);
  for (int i = 0; i < 5; ++i) step(false, 0.0f);
  EXPECT_EQ(state.target, 700.0f);
}

TEST_F(PressureSteps, AHeldResetComesWhenItMay) {
  for (int i = 0; i < 5; ++i) {
    step(false, 950.0f, true);
    EXPECT_EQ(state.reset, 0u);
    EXPECT_EQ(state.pending, 1u);
  }
  EXPECT_EQ(state.target, 300.0f) << "one cut for one episode";
  step(false, 950.0f);
  EXPECT_EQ(state.reset, 1u);
  EXPECT_EQ(state.pending, 0u);
  step(false, 0.0f, true, true);
  EXPECT_EQ(state.reset, 0u);
  EXPECT_EQ(state.pending, 1u);
  step(false, 0.0f, false, true);
  EXPECT_EQ(state.reset, 1u);
}

TEST_F(PressureSteps, WhatAHeldResetWillMendCutsOnce) {
  config.targetSmallest = 1.0f;
  for (const bool waits : {false, true}) {
    glsl::PressureInput kind = calm;
    kind.waiting = waits;
    kind.load = waits ? 0.0f : 950.0f;
    kind.held = true;
    state = glsl::pressureAtStart(config);
    step(true, 0.0f, true);
    EXPECT_EQ(state.target, 300.0f);
    for (glsl::uint i = 0; i < 10 * glsl::kCutInterval; ++i) {
      open(kind);
      ASSERT_EQ(state.target, 300.0f) << "frame " << i;
      ASSERT_EQ(state.pending, 1u);
      ASSERT_EQ(state.quiet, 0u);
    }
    // Patches that fail anew are another matter, though not each frame.
    for (glsl::uint i = 0; i < glsl::kCutInterval; ++i) step(true, 0.0f, true);
    EXPECT_EQ(state.target, 150.0f);
    // So it is without a hold.
    kind.held = false;
    open(kind);
    EXPECT_EQ(state.reset, 1u);
    open(kind);
    EXPECT_EQ(state.target, 75.0f) << "packed afresh, and still too small";
    for (glsl::uint i = 0; i <= glsl::kCutInterval; ++i) open(kind);
    EXPECT_LE(state.target, 37.5f) << "and cut again while it is";
  }
}

TEST_F(PressureSteps, ACameraThatJumpsResets) {
  // Beside 500 texels there is room for 524.
  const auto jump = [&](float fresh, float load = 500.0f, bool held = false) {
    glsl::PressureInput last = calm;
    last.load = load;
    last.room = 1024.0f - load;
    last.fresh = fresh;
    last.held = held;
    open(last);
    return state.reset;
  };
  EXPECT_EQ(jump(524.0f), 0u) << "fits";
  EXPECT_EQ(jump(525.0f, 500.0f, true), 0u) << "held back";
  EXPECT_EQ(state.pending, 0u) << "a jump is of its moment";
  EXPECT_EQ(jump(525.0f), 1u);
  EXPECT_EQ(state.sinceReset, 0u);
  EXPECT_EQ(state.wait, 1u);
  EXPECT_EQ(state.target, 600.0f) << "memory was not too small";
  EXPECT_EQ(jump(525.0f), 1u) << "as often as the camera does";
  EXPECT_EQ(jump(2000.0f, 0.0f), 0u) << "there is nothing to free";
  // A quarter of S, which is 600.
  EXPECT_EQ(jump(150.0f, 890.0f), 0u);
  EXPECT_EQ(jump(151.0f, 890.0f), 1u);
  state.target = 700.0f;
  EXPECT_EQ(jump(700.0f), 1u);
  EXPECT_EQ(state.target, 600.0f) << "starts afresh";
  config.resets = 0;
  EXPECT_EQ(jump(2000.0f), 0u);
}

TEST_F(PressureSteps, ExhaustionWithoutResetsCutsAgainAndAgain) {
  config.resets = 0;
  for (int i = 0; i < 100; ++i) {
    step(true, 950.0f);
    ASSERT_EQ(state.reset, 0u);
    ASSERT_EQ(state.pending, 0u);
  }
  EXPECT_EQ(state.target, 100.0f) << "the smallest";
  step(false, 0.0f, false, true);
  EXPECT_EQ(state.reset, 1u) << "the caller may always";
}

TEST_F(PressureSteps, AConstantTargetStays) {
  config.adapts = 0;
  step(true, 950.0f);
  EXPECT_EQ(state.reset, 1u);
  for (int i = 0; i < 20; ++i) live(i % 2 == 0 ? 0.0f : 900.0f);
  EXPECT_EQ(state.target, 600.0f);
}

TEST_F(PressureSteps, SFindsTheSizeThatMemoryHolds) {
  live(801.0f);
  EXPECT_EQ(state.target, 400.0f);
  EXPECT_EQ(state.reset, 0u);
  for (int i = 0; i < 10; ++i) live(790.0f);
  EXPECT_EQ(state.target, 400.0f) << "at rest just below the soft mark";
  for (int i = 0; i < 10; ++i) live(100.0f, false);
  EXPECT_EQ(state.target, 400.0f) << "what does not limit does not grow";
  live(100.0f);
  EXPECT_EQ(state.target, 600.0f);
  for (int i = 0; i < 30; ++i) live(900.0f);
  EXPECT_EQ(state.target, 100.0f) << "the smallest";
}

}  // namespace
}  // namespace tessera
