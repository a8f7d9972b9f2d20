#include "glsl/shared/oversample.h"

#include <cstdio>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "glsl/shared/tessellation.h"
#include "tests/tessellation/reference.hpp"

namespace tessera {
namespace {

using glsl::OverCell;
using glsl::OverPlace;
using glsl::OverPoint;
using glsl::OverShape;
using glsl::uint;
using glsl::uvec2;
using test::Bary;
using test::fetch;
using test::kRange;
using test::linear;
using test::Long;
using test::Texels;

using Set = std::set<std::pair<uint, uint>>;

/// The corners of every cell that the inside of the right-angled triangle reaches into.
Set tapsOf(uint columns, uint rows) {
  Set taps;
  if (rows == 1) {
    for (uint x = 0; x < columns; ++x) taps.insert({x, 0});
    return taps;
  }
  for (uint y = 0; y + 1 < rows; ++y)
    for (uint x = 0; x + 1 < columns; ++x)
      if (x * (rows - 1) + y * (columns - 1) < (columns - 1) * (rows - 1))
        for (uint corner = 0; corner < 4; ++corner) taps.insert({x + corner % 2, y + corner / 2});
  return taps;
}

/// A shape with one half of this size.
OverShape oneBlock(uint columns, uint rows) { return {0, 0, columns, rows, 0}; }

TEST(Oversample, ThreadsHitEachTapOnceForAllBlocks) {
  uint idle = 0;
  uint threads = 0;
  for (uint columns = 2; columns <= 64; ++columns)
    for (uint rows = 1; rows <= 64; ++rows) {
      const Set taps = tapsOf(columns, rows);
      const OverShape shape = oneBlock(columns, rows);
      Set hit;
      for (uint thread = 0; thread < glsl::overCount(shape); ++thread) {
        const OverCell cell = glsl::overCellOf(thread, shape);
        ++threads;
        if (!cell.used) {
          ++idle;
          continue;
        }
        ASSERT_EQ(cell.side, 1u);
        ASSERT_TRUE(hit.insert({cell.at.x, cell.at.y}).second)
            << columns << " x " << rows << ": thread " << thread << " repeats " << cell.at.x << ", "
            << cell.at.y;
        ASSERT_LT(cell.at.x, glsl::overRow(columns, rows, cell.at.y));
      }
      ASSERT_EQ(hit, taps) << columns << " x " << rows;
    }
  std::printf("of %u threads %u have nothing to do\n", threads, idle);
  EXPECT_LT(idle, threads / 50);
}

TEST(Oversample, LongBlocksHaveClosedFormsToo) {
  for (const auto& [columns, rows] :
       {std::pair(3169u, 1u), std::pair(1500u, 2u), std::pair(900u, 3u), std::pair(2u, 129u),
        std::pair(3u, 129u), std::pair(600u, 7u), std::pair(4095u, 40u)}) {
    const Set taps = tapsOf(columns, rows);
    Set hit;
    const OverShape shape = oneBlock(columns, rows);
    for (uint thread = 0; thread < glsl::overCount(shape); ++thread) {
      const OverCell cell = glsl::overCellOf(thread, shape);
      if (cell.used) {
        ASSERT_TRUE(hit.insert({cell.at.x, cell.at.y}).second) << columns << " x " << rows;
      }
    }
    ASSERT_EQ(hit, taps) << columns << " x " << rows;
  }
}

TEST(Oversample, BothHalvesAreCounted) {
  const OverShape shape{1, 9, 17, 5, 20000};
  Set hit[2];
  for (uint thread = 0; thread < glsl::overCount(shape); ++thread) {
    const OverCell cell = glsl::overCellOf(thread, shape);
    if (cell.used) {
      ASSERT_TRUE(hit[cell.side].insert({cell.at.x, cell.at.y}).second);
    }
  }
  EXPECT_EQ(hit[0], tapsOf(9, 5));
  EXPECT_EQ(hit[1], tapsOf(17, 5));
}

TEST(Oversample, InsideIsCountedAsByPick) {
  // Lattice points of a right-angled triangle: half of the rectangle's, and those on the third side twice.
  for (uint columns = 2; columns <= 64; ++columns)
    for (uint rows = 2; rows <= 64; ++rows) {
      uint inside = 0;
      for (uint y = 0; y < rows; ++y)
        for (uint x = 0; x < columns; ++x) inside += glsl::overInside({x, y}, columns, rows) ? 1 : 0;
      ASSERT_EQ(inside, (columns * rows + std::gcd(columns - 1, rows - 1) + 1) / 2)
          << columns << " x " << rows;
      uint texels = 0;
      for (uint y = 0; y < rows; ++y) texels += glsl::overRow(columns, rows, y);
      ASSERT_EQ(glsl::overBlockInside(columns, rows), inside) << columns << " x " << rows;
      ASSERT_EQ(glsl::overBlockOutside(columns, rows), texels - inside) << columns << " x " << rows;
    }
  EXPECT_EQ(glsl::overBlockInside(8, 1), 8u) << "all of a flat triangle's";
  EXPECT_EQ(glsl::overBlockOutside(8, 1), 0u);
  EXPECT_EQ(glsl::overBlockInside(0, 9) + glsl::overBlockOutside(0, 9), 0u) << "no such half";
  EXPECT_TRUE(glsl::overInside({7, 0}, 8, 1));
}

TEST(Oversample, TwoBlocksShareARectangle) {
  double texels = 0.0;
  double area = 0.0;
  for (uint columns = 2; columns <= 64; ++columns)
    for (uint rows = 1; rows <= 64; ++rows) {
      const uvec2 size = glsl::overPairSize(columns, rows);
      std::vector<bool> taken(static_cast<std::size_t>(size.x) * size.y, false);
      for (const bool turned : {false, true}) {
        const uvec2 corner = glsl::overCorner({5, 6}, columns, rows, turned);
        for (const auto& [x, y] : tapsOf(columns, rows)) {
          const uvec2 texel = glsl::overAtlasTexel({x, y}, corner, turned);
          ASSERT_GE(texel.x, 5u);
          ASSERT_GE(texel.y, 6u);
          ASSERT_LT(texel.x, 5 + size.x) << columns << " x " << rows;
          ASSERT_LT(texel.y, 6 + size.y) << columns << " x " << rows;
          const std::size_t index = static_cast<std::size_t>(texel.y - 6) * size.x + (texel.x - 5);
          ASSERT_FALSE(taken[index]) << columns << " x " << rows << ": " << x << ", " << y;
          taken[index] = true;
          const glm::vec2 center =
              glsl::overAtlasAt({static_cast<float>(x), static_cast<float>(y)}, corner, turned);
          ASSERT_EQ(center, glm::vec2(texel) + 0.5f);
          texels += 1;
        }
      }
      area += size.x * size.y;
    }
  std::printf("%.1f %% of the rectangles' texels are samples, all blocks up to 64 x 64\n",
              texels / area * 100);
  EXPECT_GT(texels / area, 0.95);
}

TEST(Oversample, ClassesRoundUpByAnEighthAtMost) {
  uint last = 0;
  std::set<uint> classes;
  for (uint steps = 1; steps <= 4096; ++steps) {
    const uint number = glsl::overClass(steps);
    const uint rounded = glsl::overClassSteps(number);
    ASSERT_LT(number, glsl::kOverColumnClasses);
    ASSERT_GE(rounded, steps);
    ASSERT_LE(rounded - steps, steps / 8);
    ASSERT_GE(rounded, last);
    ASSERT_EQ(glsl::overClass(rounded), number);
    if (steps <= 16) {
      ASSERT_EQ(rounded, steps);
    }
    last = rounded;
    classes.insert(number);
    if (steps == 128) {
      EXPECT_EQ(number + 2, glsl::kOverRowClasses);
    }
  }
  EXPECT_EQ(classes.size(), glsl::kOverColumnClasses);
  for (uint bin = 0; bin < glsl::kOverBins; ++bin) {
    const uvec2 block = glsl::overBinBlock(bin);
    ASSERT_EQ(glsl::overBin(block.x, block.y), bin);
  }
}

/// Edge lengths of a triangle with this base, height and foot, the corner opposite the base being `apex`.
glm::vec3 edgesOf(float base, float height, float foot, int apex) {
  glm::vec3 edges(0.0f);
  edges[apex] = base;
  edges[(apex + 2) % 3] = std::hypot(foot * base, height);
  edges[(apex + 1) % 3] = std::hypot((1.0f - foot) * base, height);
  return edges;
}

Bary toLong(glm::vec3 v) { return {static_cast<Long>(v.x), static_cast<Long>(v.y), static_cast<Long>(v.z)}; }

TEST(Oversample, EveryTapIsATexelOfTheTriangleAndLinearFunctionsAreReproduced) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  Long worst = 0;
  for (int i = 0; i < 3000; ++i) {
    const float base = std::exp2(unit(random) * 9.0f - 1.0f);
    const float height = base * std::exp2(-unit(random) * 8.0f);
    float foot = unit(random);
    if (i % 5 == 0) foot = i % 2 == 0 ? 0.0f : 1.0f;
    const int apex = i % 3;
    // An edge longer than the base would make that the base.
    if (std::hypot(foot * base, height) > base || std::hypot((1 - foot) * base, height) > base) continue;
    const OverShape shape = glsl::overShapeOf(edgesOf(base, height, foot, apex), height);
    if (glsl::overCount(shape) > 4 * glsl::kTessMostSamples) continue;
    ASSERT_EQ(shape.apex, static_cast<uint>(apex)) << base << " " << height << " " << foot;
    // Texels are at most one apart, at whatever angle, but for a flat triangle's height.
    const uint columns = std::max(shape.columns0, 1u) - 1 + std::max(shape.columns1, 1u) - 1;
    ASSERT_GE(static_cast<float>(columns), base * 0.9999f);
    Texels texels[2];
    for (uint thread = 0; thread < glsl::overCount(shape); ++thread) {
      const OverCell cell = glsl::overCellOf(thread, shape);
      if (!cell.used) continue;
      const Bary at = toLong(glsl::overEven(cell, shape));
      ASSERT_NEAR(static_cast<double>(at[0] + at[1] + at[2]), 1.0, 1e-5);
      const bool inside = at[0] >= -1e-5L && at[1] >= -1e-5L && at[2] >= -1e-5L;
      ASSERT_EQ(inside, glsl::overInside(cell.at, glsl::overColumns(shape, cell.side), shape.rows));
      texels[cell.side][{cell.at.x, cell.at.y}] = linear(at);
    }
    for (int point = 0; point < 200; ++point) {
      const glm::vec3 b = test::randomBary(random);
      const OverPoint found = glsl::overDecode(b, shape);
      Long value = 0;
      ASSERT_TRUE(fetch(texels[found.side], found.at, value))
          << base << " " << height << " " << foot << ": " << found.side << " " << found.at.x << " "
          << found.at.y;
      const Long error = std::abs(value - linear(toLong(b))) / kRange;
      if (shape.rows == 1) {
        // One row for less than half a texel of height: off by what changes over that height.
        Bary atFoot{};
        atFoot[(shape.apex + 1) % 3] = 1 - static_cast<Long>(glsl::overFoot(shape));
        atFoot[(shape.apex + 2) % 3] = static_cast<Long>(glsl::overFoot(shape));
        Bary atApex{};
        atApex[shape.apex] = 1;
        ASSERT_LE(error * kRange, std::abs(linear(atApex) - linear(atFoot)) + 1e-5L);
        continue;
      }
      ASSERT_LE(error, 1e-5L) << base << " " << height << " " << foot << ": " << shape.columns0 << " "
                              << shape.columns1 << " " << shape.rows;
      worst = std::max(worst, error);
    }
  }
  std::printf("off by %.2g of the range\n", static_cast<double>(worst));
}

// What display interpolates over the triangle, against decoding a point.
TEST(Oversample, BlockCoordinatesAreLinearBetweenCorners) {
  std::mt19937 random(21);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  double worst = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const float base = std::exp2(1.0f + 9.0f * unit(random));
    const float height = base * 0.8f * std::exp2(-6.0f * unit(random));
    const OverShape shape =
        glsl::overShapeOf(edgesOf(base, height, unit(random), static_cast<int>(random() % 3)), height);
    const uint near = shape.columns0 > 0 ? 0 : 1;
    const uint far = shape.columns1 > 0 ? 1 : 0;
    for (int point = 0; point < 20; ++point) {
      const glm::vec3 b = test::randomBary(random);
      glm::dvec3 at(0.0);
      for (uint c = 0; c < 3; ++c) {
        const glm::vec2 y = glsl::overCornerAt(c, far, shape);
        ASSERT_EQ(y.y, glsl::overCornerAt(c, near, shape).y);
        at +=
            static_cast<double>(b[static_cast<int>(c)]) * glm::dvec3(glsl::overCornerAt(c, near, shape).x, y);
      }
      const OverPoint found = glsl::overDecode(b, shape);
      const bool onFar = at.y >= 0.0;
      if (std::abs(at.y) <= 1e-2) continue;  // on the height itself either side will do
      ASSERT_EQ(found.side, onFar ? far : near) << shape.columns0 << " " << shape.columns1;
      worst = std::max({worst, std::abs((onFar ? at.y : at.x) - static_cast<double>(found.at.x)),
                        std::abs(at.z - static_cast<double>(found.at.y))});
    }
  }
  std::printf("off by %.2g texels\n", worst);
  EXPECT_LE(worst, 1e-3);
}

TEST(Oversample, FlatTrianglesAreExactAlongTheBase) {
  // A function of the place along the base only is what one row must reproduce.
  std::mt19937 random(6);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 2000; ++i) {
    const float base = std::exp2(unit(random) * 8.0f);
    const float foot = i % 7 == 0 ? 0.0f : (i % 7 == 1 ? 1.0f : unit(random));
    const int apex = i % 3;
    const OverShape shape = glsl::overShapeOf(edgesOf(base, i % 2 == 0 ? 0.0f : 0.3f, foot, apex), 0.3f);
    ASSERT_EQ(shape.rows, 1u);
    // Where the height is a third of a texel, the two shorter edges may add up to more than the base; the
    // foot is that of the shape.
    const Long at = static_cast<Long>(glsl::overFoot(shape));
    const auto along = [&](const Bary& b) {
      return b[static_cast<std::size_t>(shape.apex + 2) % 3] + at * b[static_cast<std::size_t>(shape.apex)];
    };
    Texels texels;
    for (uint thread = 0; thread < glsl::overCount(shape); ++thread) {
      const OverCell cell = glsl::overCellOf(thread, shape);
      const glm::vec3 even = glsl::overEven(cell, shape);
      ASSERT_GE(std::min({even.x, even.y, even.z}), -1e-6f);
      // In the middle of the height there: twice as high, it would lie on one of the two upper edges.
      const auto top = static_cast<int>(shape.apex);
      glm::vec3 upper = even;
      upper[top] = 2.0f * even[top];
      upper[(top + 1) % 3] -= (1.0f - static_cast<float>(at)) * even[top];
      upper[(top + 2) % 3] -= static_cast<float>(at) * even[top];
      ASSERT_NEAR(std::min(upper[(top + 1) % 3], upper[(top + 2) % 3]), 0.0f, 1e-5f);
      texels[{cell.at.x, cell.at.y}] = along(toLong(even));
    }
    for (int point = 0; point < 50; ++point) {
      const glm::vec3 b = test::randomBary(random);
      Long value = 0;
      ASSERT_TRUE(fetch(texels, glsl::overDecode(b, shape).at, value));
      ASSERT_NEAR(static_cast<double>(value), static_cast<double>(along(toLong(b))), 1e-5);
    }
  }
}

TEST(Oversample, SlantedTrianglesHaveTheirRightAngleWhereTheyHadIt) {
  // Legs 40 and 4: the foot lies within a row's length of the corner, so one block is enough.
  const OverShape shape = glsl::overShapeOf({std::hypot(40.0f, 4.0f), 40.0f, 4.0f}, 3.98f);
  EXPECT_EQ(shape.apex, 0u);
  EXPECT_EQ(shape.rows, 5u);
  EXPECT_TRUE(shape.columns0 == 0 || shape.columns1 == 0);
  // 30 and 10 on either side of a height of 4.
  const OverShape two = glsl::overShapeOf(edgesOf(40.0f, 4.0f, 0.25f, 2), 4.0f);
  EXPECT_EQ(two.apex, 2u);
  EXPECT_EQ(two.columns0, 11u);
  EXPECT_EQ(two.columns1, 31u);
  EXPECT_NEAR(glsl::overFoot(two), 0.25f, 1e-4f);
}

TEST(Oversample, SixteenBytesAPrimitive) {
  std::mt19937 random(7);
  for (int i = 0; i < 10000; ++i) {
    OverPlace place{};
    const auto below = [&](uint end) { return static_cast<uint>(random() % end); };
    place.shape = {below(3), below(4096), below(4096), 1 + below(129), below(65536)};
    place.corner0 = {below(65536), below(65536)};
    place.corner1 = {below(65536), below(65536)};
    place.turned0 = random() % 2u == 0;
    place.turned1 = random() % 2u == 0;
    const OverPlace back = glsl::unpackOver(glsl::packOver(place));
    ASSERT_EQ(back.shape.apex, place.shape.apex);
    ASSERT_EQ(back.shape.columns0, place.shape.columns0);
    ASSERT_EQ(back.shape.columns1, place.shape.columns1);
    ASSERT_EQ(back.shape.rows, place.shape.rows);
    ASSERT_EQ(back.shape.foot, place.shape.foot);
    ASSERT_EQ(back.corner0, place.corner0);
    ASSERT_EQ(back.corner1, place.corner1);
    ASSERT_EQ(back.turned0, place.turned0);
    ASSERT_EQ(back.turned1, place.turned1);
  }
}

/// The share of samples outside of the triangle, and of texels that are samples, over triangles with bases of
/// 2 to `most` texels and slantedness 2 to 32, both log-uniform.
TEST(Oversample, SamplesOutsideOnPlausibleTriangles) {
  for (const float most : {16.0f, 64.0f, 256.0f}) {
    std::mt19937 random(8);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    double all = 0.0;
    double outside = 0.0;
    double idle = 0.0;
    double area = 0.0;
    double rectangles = 0.0;
    double exact = 0.0;
    for (int i = 0; i < 20000; ++i) {
      const float base = 2.0f * std::pow(most / 2.0f, unit(random));
      const float height = base / (2.0f * std::pow(16.0f, unit(random)));
      // Half of them right-angled, as meshes made of rectangles have them.
      const float ratio = height / base;
      const float foot =
          i % 2 == 0 ? unit(random) : 0.5f - 0.5f * std::sqrt(std::max(1.0f - 4.0f * ratio * ratio, 0.0f));
      const OverShape shape = glsl::overShapeOf(edgesOf(base, height, foot, i % 3), height);
      if (glsl::overCount(shape) > glsl::kTessMostSamples) continue;
      area += 0.5 * static_cast<double>(base) * static_cast<double>(height);
      for (uint thread = 0; thread < glsl::overCount(shape); ++thread) {
        const OverCell cell = glsl::overCellOf(thread, shape);
        if (!cell.used)
          idle += 1;
        else if (glsl::overInside(cell.at, glsl::overColumns(shape, cell.side), shape.rows))
          all += 1;
        else
          all += 1, outside += 1;
      }
      for (uint side = 0; side < 2; ++side)
        if (const uint columns = glsl::overColumns(shape, side); columns > 0) {
          const uvec2 size = glsl::overPairSize(columns, shape.rows);
          rectangles += 0.5 * size.x * size.y;
        }
      exact += 1;
    }
    std::printf(
        "bases up to %g: %.1f %% of the samples lie outside, %.2f samples for a texel of area, %.1f %% idle "
        "threads, "
        "%.1f %% of the rectangles' texels are samples\n",
        static_cast<double>(most), outside / all * 100, all / area, idle / all * 100, all / rectangles * 100);
    EXPECT_GT(exact, 10000);
    EXPECT_GT(outside / all, 0.05);
    EXPECT_LT(outside / all, 0.35);
    EXPECT_GT(all / rectangles, 0.9);
  }
}

}  // namespace
}  // namespace tessera
