// Charts of Texel Shading: numbers of tiles, levels that lie in each other, and where patches lie in their
// charts.
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "atlas/texel/charts.hpp"

namespace tessera {
namespace {

using glsl::TexelChart;

std::vector<TexelChart> charts(glsl::uint largest) {
  std::vector<TexelChart> all;
  for (glsl::uint x = 0; x <= largest; ++x)
    for (glsl::uint y = 0; y <= largest; ++y) all.push_back({1, x | y << 8u});
  return all;
}

TEST(TexelCharts, EachTileHasANumberOfItsOwn) {
  for (const TexelChart& chart : charts(5)) {
    std::set<glsl::uint> numbers;
    std::size_t tiles = 0;
    for (glsl::uint level = 0; level < glsl::recordLevel(chart); ++level)
      for (glsl::uint y = 0; y < glsl::tilesAlong(glsl::chartY(chart), level); ++y)
        for (glsl::uint x = 0; x < glsl::tilesAlong(glsl::chartX(chart), level); ++x, ++tiles) {
          const glsl::uint tile = glsl::packTile(x, y, level, chart);
          EXPECT_EQ(glsl::tileX(tile), x);
          EXPECT_EQ(glsl::tileY(tile), y);
          EXPECT_EQ(glsl::tileLevel(tile), level);
          EXPECT_EQ(glsl::tileChartX(tile), glsl::chartX(chart));
          EXPECT_EQ(glsl::tileChartY(tile), glsl::chartY(chart));
          numbers.insert(glsl::tileNumber(chart, tile));
        }
    EXPECT_EQ(numbers.size(), tiles) << chart.size;
    EXPECT_EQ(*numbers.begin(), 1u);
    EXPECT_EQ(*numbers.rbegin(), tiles) << chart.size;
    EXPECT_EQ(glsl::tilesBefore(chart, glsl::recordLevel(chart)), tiles) << chart.size;
  }
  // The largest chart, by sums.
  for (const TexelChart& chart : charts(glsl::kTexelLargestLog2)) {
    std::uint64_t before = 0;
    for (glsl::uint level = 0; level <= glsl::recordLevel(chart); ++level) {
      EXPECT_EQ(glsl::tilesBefore(chart, level), before) << chart.size << " level " << level;
      before += std::uint64_t{glsl::tilesAlong(glsl::chartX(chart), level)} *
                glsl::tilesAlong(glsl::chartY(chart), level);
    }
  }
}

TEST(TexelCharts, ATileLiesInTheOneThatIsCoarser) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(0.0f, 1.0f);
  for (const TexelChart& chart : charts(glsl::kTexelLargestLog2))
    for (int i = 0; i < 200; ++i) {
      const glm::vec2 at = i == 0   ? glm::vec2(0.0f)
                           : i == 1 ? glm::vec2(1.0f)
                                    : glm::vec2(place(random), place(random));
      for (glsl::uint level = 0; level + 1 < glsl::recordLevel(chart); ++level) {
        const glsl::uint tile = glsl::tileAt(chart, level, at);
        ASSERT_EQ(glsl::coarserTile(chart, tile), glsl::tileAt(chart, level + 1, at))
            << chart.size << " level " << level << " at " << at.x << " " << at.y;
        // And the place lies among the tile's cells.
        const float x = at.x * static_cast<float>(glsl::cellsAlong(glsl::chartX(chart), level)) -
                        static_cast<float>(glsl::kTexelCells * glsl::tileX(tile));
        ASSERT_GE(x, 0.0f);
        ASSERT_LE(x, static_cast<float>(glsl::kTexelCells));
      }
    }
}

TEST(TexelCharts, LevelsFollowThePixelsAndAreAlwaysOfTheChart) {
  const TexelChart chart{1, 4 | 2 << 8u};  // 112 x 28 cells
  const auto level = [&](float dx, float dy, float bias = 0.0f) {
    return glsl::texelLevel(chart, {dx / 112.0f, 0.0f}, {0.0f, dy / 28.0f}, bias);
  };
  EXPECT_EQ(level(1.0f, 1.0f), 0u);
  EXPECT_EQ(level(2.0f, 1.0f), 1u);
  EXPECT_EQ(level(1.0f, 2.0f), 1u) << "the longer one counts";
  EXPECT_EQ(level(1.4f, 1.4f), 0u);
  EXPECT_EQ(level(1.42f, 1.0f), 1u);
  EXPECT_EQ(level(8.0f, 8.0f), 3u);
  EXPECT_EQ(level(8.0f, 8.0f, 2.0f), 4u);
  EXPECT_EQ(level(8.0f, 8.0f, -2.0f), 2u);
  EXPECT_EQ(level(0.01f, 0.01f), 0u);
  EXPECT_EQ(level(1e9f, 1.0f), glsl::recordLevel(chart));
  const float bad[] = {0.0f,
                       -1.0f,
                       1e-38f,
                       1e38f,
                       std::numeric_limits<float>::infinity(),
                       std::numeric_limits<float>::quiet_NaN()};
  for (const float a : bad)
    for (const float b : bad)
      EXPECT_LE(glsl::texelLevel(chart, {a, b}, {b, a}, 0.0f), glsl::recordLevel(chart)) << a << " " << b;
}

TEST(TexelCharts, PlacesOutsideOfAPatchAreTakenIntoIt) {
  for (const glsl::uint flags : {0u, glsl::kChartSingle})
    for (float x = -2.0f; x <= 3.0f; x += 0.25f)
      for (float y = -2.0f; y <= 3.0f; y += 0.25f) {
        const glm::vec2 at = glsl::placeInChart({1, 3 | 3 << 8u | flags}, {x, y});
        EXPECT_TRUE(at.x >= 0.0f && at.x <= 1.0f && at.y >= 0.0f && at.y <= 1.0f) << x << " " << y;
        if (flags != 0) {
          EXPECT_LE(at.y, at.x) << x << " " << y;
        }
        const bool inside = x >= 0.0f && x <= 1.0f && y >= 0.0f && y <= 1.0f && (flags == 0 || y <= x);
        EXPECT_EQ(at == glm::vec2(x, y), inside) << x << " " << y;
      }
}

TEST(TexelCharts, PlacesInsideAPatchAreItsTriangles) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> share(0.0f, 1.0f);
  for (glsl::uint triangles = 1; triangles <= 3; ++triangles) {
    double area = 0.0;
    for (glsl::uint part = 0; part < triangles; ++part) {
      const glm::vec2 a = glsl::chartCorner(triangles, 0);
      const glm::vec2 b = glsl::chartCorner(triangles, part + 1);
      const glm::vec2 c = glsl::chartCorner(triangles, part + 2);
      area += 0.5 * static_cast<double>((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
      for (int i = 0; i < 200; ++i) {
        glm::vec3 w(share(random) + 0.01f, share(random) + 0.01f, share(random) + 0.01f);
        w /= w.x + w.y + w.z;
        const glm::vec2 at = w.x * a + w.y * b + w.z * c;
        EXPECT_EQ(glsl::chartPart(triangles, at), part);
        const glm::vec3 back = glsl::chartBarycentrics(a, b, c, at);
        EXPECT_NEAR(back.x, w.x, 1e-5);
        EXPECT_NEAR(back.y, w.y, 1e-5);
        EXPECT_NEAR(back.z, w.z, 1e-5);
      }
    }
    EXPECT_DOUBLE_EQ(area, triangles == 1 ? 0.5 : 1.0) << triangles;
  }
}

TEST(TexelCharts, WhatAFetchReadsIsShaded) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> share(0.0f, 1.0f);
  for (const TexelChart& chart : charts(3))
    for (glsl::uint level = 0; level < glsl::recordLevel(chart); ++level) {
      const glsl::uint cellsX = glsl::cellsAlong(glsl::chartX(chart), level);
      const glsl::uint cellsY = glsl::cellsAlong(glsl::chartY(chart), level);
      for (glsl::uint triangles = 1; triangles <= 3; ++triangles) {
        std::size_t needed = 0;
        for (glsl::uint y = 0; y <= cellsY + 1; ++y)
          for (glsl::uint x = 0; x <= cellsX + 1; ++x)
            needed += glsl::texelNeeded(triangles, x, y, cellsX, cellsY) ? 1 : 0;
        const std::size_t all = std::size_t{cellsX + 1} * (cellsY + 1);
        if (triangles > 1) {
          EXPECT_EQ(needed, all);
        } else {
          EXPECT_LE(needed, all / 2 + 2 * (cellsX + cellsY + 1));
        }
        for (int i = 0; i < 300; ++i) {
          glm::vec2 at(share(random), share(random));
          if (triangles == 1 && at.y > at.x) std::swap(at.x, at.y);
          if (triangles == 1 && i % 3 == 0) at.y = at.x;  // on the diagonal
          const auto x = static_cast<glsl::uint>(at.x * static_cast<float>(cellsX));
          const auto y = static_cast<glsl::uint>(at.y * static_cast<float>(cellsY));
          for (const glsl::uint dx : {0u, 1u})
            for (const glsl::uint dy : {0u, 1u})
              ASSERT_TRUE(x + dx > cellsX || y + dy > cellsY ||
                          glsl::texelNeeded(triangles, x + dx, y + dy, cellsX, cellsY))
                  << cellsX << " x " << cellsY << " at " << at.x << " " << at.y;
        }
      }
    }
}

TEST(TexelCharts, ChartsHaveTheShapeOfTheirPatchesAndTheirOwnNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto laid = layOutCharts(std::vector<ChartShape>{{{1.0, 1.0}},
                                                         {{1.0, 4.0}},
                                                         {{8.0, 1.0}},
                                                         {{1.0, 0.0}},
                                                         {{0.0, 0.0}},
                                                         {{nan, 2.0}},
                                                         {{0.25, 0.25}, true}});
  ASSERT_TRUE(laid);
  const auto log2 = [&](std::size_t i) {
    return glm::ivec2(glsl::chartX((*laid)[i]), glsl::chartY((*laid)[i]));
  };
  const int most = glsl::kTexelLargestLog2;
  EXPECT_EQ(log2(0), glm::ivec2(most)) << "with numbers to spare every chart is as fine as it can be";
  EXPECT_EQ(log2(1), glm::ivec2(most - 2, most));
  EXPECT_EQ(log2(2), glm::ivec2(most, most - 3));
  EXPECT_EQ(log2(3), glm::ivec2(most, 0));
  EXPECT_EQ(log2(4), glm::ivec2(0, 0));
  EXPECT_EQ(log2(5), glm::ivec2(0, most));
  for (std::size_t i = 0; i < laid->size(); ++i)
    EXPECT_EQ(((*laid)[i].size & glsl::kChartSingle) != 0, i == 6) << i;
  glsl::uint next = 1;
  for (const TexelChart& chart : *laid) {
    EXPECT_EQ(chart.base, next);
    next += glsl::tilesBefore(chart, glsl::recordLevel(chart));
  }
}

TEST(TexelCharts, ManyPatchesShareTheNumbersByTheirSize) {
  std::vector<ChartShape> shapes(200000, {glm::dvec2(0.01)});
  for (std::size_t i = 0; i < shapes.size(); i += 100) shapes[i].extent = glm::dvec2(1.0);
  const auto laid = layOutCharts(shapes);
  ASSERT_TRUE(laid);
  const TexelChart& last = laid->back();
  const std::uint64_t end = std::uint64_t{last.base} + glsl::tilesBefore(last, glsl::recordLevel(last));
  EXPECT_LE(end, std::numeric_limits<std::uint32_t>::max());
  EXPECT_GT(end, std::numeric_limits<std::uint32_t>::max() / 8u) << "numbers that nothing uses";
  for (std::size_t i = 1; i < laid->size(); ++i) ASSERT_GT((*laid)[i].base, (*laid)[i - 1].base);
  EXPECT_EQ(glsl::chartX((*laid)[0]), glsl::kTexelLargestLog2);
  EXPECT_LT(glsl::chartX((*laid)[1]), glsl::kTexelLargestLog2);
  // Where even that is too many.
  EXPECT_TRUE(layOutCharts(std::vector<ChartShape>()));
}

/// Follows the bias over frames whose tiles are `tilesOf` it, and returns how many of the last half had too
/// many.
template <class TilesOf>
int framesWithTooMany(glsl::TexelPressure& pressure, int frames, float lowest, const TilesOf& tilesOf) {
  int tooMany = 0;
  for (int frame = 0; frame < frames; ++frame) {
    const auto marked = static_cast<glsl::uint>(tilesOf(pressure.bias));
    if (2 * frame > frames && marked > 1000) ++tooMany;
    pressure = glsl::nextTexelPressure(pressure, marked, 1000, lowest);
  }
  return tooMany;
}

TEST(TexelCharts, TheBiasSettlesWhereTilesFit) {
  const glsl::TexelPressure start{0.0f, 0, glsl::kTexelQuiet, 0};
  // Tiles fall to half with each step of log2 area, as those of large patches do.
  for (const double wanted : {50.0, 999.0, 1001.0, 3000.0, 1e6}) {
    const auto smooth = [&](float bias) { return wanted * std::exp2(-static_cast<double>(bias)); };
    glsl::TexelPressure pressure = start;
    EXPECT_EQ(framesWithTooMany(pressure, 1000, 0.0f, smooth), 0) << wanted;
    EXPECT_LE(smooth(pressure.bias), 1000.0);
    if (wanted < 1000.0) {
      EXPECT_EQ(pressure.bias, 0.0f);
    } else {
      EXPECT_GT(smooth(pressure.bias), 890.0) << wanted;
    }
    // The camera turns to less: detail comes back, but not below what is wanted.
    framesWithTooMany(pressure, 2000, 0.0f, [](float) { return 10.0; });
    EXPECT_EQ(pressure.bias, 0.0f);
    framesWithTooMany(pressure, 2000, -2.0f, [](float) { return 10.0; });
    EXPECT_EQ(pressure.bias, -2.0f);
  }
  // Small patches lose all of their tiles at once: what nearly always fits is better than what fits half the
  // time.
  glsl::TexelPressure pressure = start;
  EXPECT_LE(framesWithTooMany(pressure, 10000, 0.0f, [](float bias) { return bias < 5.0f ? 1200.0 : 100.0; }),
            5);
  EXPECT_GT(pressure.bias, 4.0f);
}

}  // namespace
}  // namespace tessera
