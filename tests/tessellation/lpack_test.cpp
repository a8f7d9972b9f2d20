#include "glsl/shared/lpack.h"

#include <cstdio>
#include <set>

#include <gtest/gtest.h>

#include "tests/tessellation/reference.hpp"

namespace tessera {
namespace {

using glsl::LTexels;
using glsl::TessPlace;
using glsl::uint;
using glsl::uvec2;
using test::Bary;
using test::fetch;
using test::kRange;
using test::linear;
using test::Long;
using test::Texels;

/// The place of every sample of the level's pattern, from where it lies.
std::vector<std::pair<TessPlace, Bary>> samplesOf(uint level) {
  std::vector<std::pair<TessPlace, Bary>> all;
  for (const Bary& at : test::pattern({level, level, level}, level))
    all.push_back({glsl::tessPlaceAt(test::toFloat(at), glsl::tessUniform(level)), at});
  return all;
}

Texels texelsOf(uint level) {
  Texels texels;
  for (const auto& [place, at] : samplesOf(level)) {
    const LTexels written = glsl::lTexelsOf(place, level);
    texels[{written.first.x, written.first.y}] = linear(at);
    texels[{written.second.x, written.second.y}] = linear(at);
  }
  return texels;
}

TEST(LPack, TexelsAreOneToOneForAllLevels) {
  for (uint level = 1; level <= glsl::kTessLargest; ++level) {
    std::map<std::pair<uint, uint>, TessPlace> owner;
    for (const auto& [place, at] : samplesOf(level)) {
      const LTexels texels = glsl::lTexelsOf(place, level);
      std::vector<uvec2> distinct{texels.first};
      if (texels.second != texels.first) distinct.push_back(texels.second);
      for (const uvec2 texel : distinct) {
        ASSERT_TRUE(glsl::lContains(texel, level)) << level << ": " << texel.x << ", " << texel.y;
        ASSERT_TRUE(owner.insert({{texel.x, texel.y}, place}).second)
            << level << ": " << texel.x << ", " << texel.y << " has two samples";
      }
    }
    ASSERT_EQ(owner.size(), glsl::lTexels(level)) << level;
    // From the texel back to the sample, for every texel of the L; and as many texels as are counted.
    uint count = 0;
    for (uint y = 0; y <= level + 1; ++y)
      for (uint x = 0; x <= level + 1; ++x) {
        if (!glsl::lContains({x, y}, level)) continue;
        ++count;
        const TessPlace place = glsl::lPlaceOf({x, y}, level);
        const TessPlace& expected = owner.at({x, y});
        ASSERT_EQ(place.ring, expected.ring) << level << ": " << x << ", " << y;
        ASSERT_EQ(place.side, expected.side) << level << ": " << x << ", " << y;
        ASSERT_EQ(place.step, expected.step) << level << ": " << x << ", " << y;
      }
    ASSERT_EQ(count, glsl::lTexels(level)) << level;
  }
  EXPECT_EQ(glsl::lTexels(64), 3201u);
  EXPECT_EQ(glsl::lTexels(1), 4u);
  EXPECT_EQ(glsl::lTexels(2), 8u);
}

TEST(LPack, TwoLsShareARectangle) {
  for (uint level = 0; level <= glsl::kTessLargest; ++level) {
    const uvec2 size = glsl::lPairSize(level);
    std::set<std::pair<uint, uint>> taken;
    for (const bool turned : {false, true})
      for (uint y = 0; y <= level; ++y)
        for (uint x = 0; x <= level; ++x) {
          if (!glsl::lContains({x, y}, level)) continue;
          const uvec2 texel = glsl::lAtlasTexel({x, y}, {100, 200}, level, turned);
          ASSERT_GE(texel.x, 100u);
          ASSERT_GE(texel.y, 200u);
          ASSERT_LT(texel.x, 100 + size.x) << level;
          ASSERT_LT(texel.y, 200 + size.y) << level;
          ASSERT_TRUE(taken.insert({texel.x, texel.y}).second) << level << ": " << x << ", " << y;
          const auto fx = static_cast<float>(x);
          const auto fy = static_cast<float>(y);
          const glm::vec2 center = glsl::lAtlasAt({fx, fy}, {100, 200}, level, turned);
          ASSERT_EQ(center, glm::vec2(texel) + 0.5f);
        }
    const uint gaps = size.x * size.y - static_cast<uint>(taken.size());
    ASSERT_EQ(gaps, level == 0 || level % 2 == 1 ? 0u : level + 2) << level;
  }
  // Samples of both Ls, each counted once: the numbers in lpack.h.
  const auto efficiency = [](uint level) {
    const uvec2 size = glsl::lPairSize(level);
    return 2.0 * glsl::tessUniformCount(level) / (size.x * size.y);
  };
  EXPECT_NEAR(efficiency(2), 0.70, 0.005);
  EXPECT_NEAR(efficiency(64), 0.98, 0.005);
  EXPECT_EQ(efficiency(0), 1.0);
}

TEST(LPack, EveryTapIsATexelOfTheTriangleAndLinearFunctionsAreReproduced) {
  std::mt19937 random(3);
  Long worstExact = 0;
  Long worstPlain = 0;
  for (uint level = 1; level <= glsl::kTessLargest; ++level) {
    const Texels texels = texelsOf(level);
    for (int i = 0; i < 6000; ++i) {
      const glm::vec3 b = test::randomBary(random);
      const Bary at{static_cast<Long>(b.x), static_cast<Long>(b.y), static_cast<Long>(b.z)};
      Long value = 0;
      const glm::vec2 exact = glsl::lDecodeExact(b, level);
      ASSERT_TRUE(fetch(texels, exact, value))
          << level << ": " << b.x << " " << b.y << " " << b.z << " -> " << exact.x << " " << exact.y;
      const Long error = std::abs(value - linear(at));
      ASSERT_LE(error, 1e-5L * kRange)
          << level << ": " << b.x << " " << b.y << " " << b.z << " -> " << exact.x << " " << exact.y;
      worstExact = std::max(worstExact, error / kRange);
      const glm::vec2 plain = glsl::lDecodePlain(b, level);
      ASSERT_TRUE(fetch(texels, plain, value)) << level << ": " << b.x << " " << b.y << " " << b.z;
      if (level % 2 == 0) worstPlain = std::max(worstPlain, std::abs(value - linear(at)) * level / kRange);
    }
  }
  std::printf("exact decode: off by %.2g of the range; plain, even levels: by %.3f of the range a step\n",
              static_cast<double>(worstExact), static_cast<double>(worstPlain));
  EXPECT_LT(worstPlain, 0.16L);
  EXPECT_GT(worstPlain, 0.05L) << "the plain decode is not as coarse as is claimed";
}

// Levels that no tessellator has are spawned from their texels.
TEST(LPack, LevelsBeyondTheTessellatorsAreReproducedToo) {
  std::mt19937 random(9);
  for (uint level = 1; level <= 254; level += level < 60 ? 7 : 1) {
    Texels texels;
    for (uint y = 0; y <= level; ++y)
      for (uint x = 0; x <= level; ++x) {
        if (!glsl::lContains({x, y}, level)) continue;
        const glm::vec3 b = glsl::tessBary(glsl::lPlaceOf({x, y}, level), glsl::tessUniform(level));
        ASSERT_GE(std::min({b.x, b.y, b.z}), 0.0f);
        texels[{static_cast<int>(x), static_cast<int>(y)}] =
            linear({static_cast<Long>(b.x), static_cast<Long>(b.y), static_cast<Long>(b.z)});
      }
    ASSERT_EQ(texels.size(), glsl::lTexels(level));
    for (int i = 0; i < 300; ++i) {
      const glm::vec3 b = test::randomBary(random);
      Long value = 0;
      ASSERT_TRUE(fetch(texels, glsl::lDecodeExact(b, level), value)) << level;
      const Long expected = linear({static_cast<Long>(b.x), static_cast<Long>(b.y), static_cast<Long>(b.z)});
      ASSERT_LE(std::abs(value - expected), 1e-5L * kRange)
          << level << ": " << b.x << " " << b.y << " " << b.z;
    }
  }
}

TEST(LPack, SamplesDecodeToTheirTexels) {
  for (uint level = 1; level <= glsl::kTessLargest; ++level) {
    const Texels texels = texelsOf(level);
    for (const auto& [place, at] : samplesOf(level)) {
      for (const bool exact : {true, false}) {
        const glm::vec2 found = exact ? glsl::lDecodeExact(test::toFloat(at), level)
                                      : glsl::lDecodePlain(test::toFloat(at), level);
        Long value = 0;
        ASSERT_TRUE(fetch(texels, found, value));
        // The plain decode is exact at samples too.
        ASSERT_NEAR(static_cast<double>(value), static_cast<double>(linear(at)), 5e-5)
            << level << ": " << found.x << " " << found.y << (exact ? " exact" : " plain");
      }
    }
  }
}

TEST(LPack, PointsOutsideAndNonsenseStayInTheL) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> wide(-2.0f, 3.0f);
  for (int i = 0; i < 20000; ++i) {
    const uint level = 1 + random() % 64u;
    const glm::vec3 b(wide(random), wide(random), wide(random));
    for (const glm::vec2 at : {glsl::lDecodeExact(b, level), glsl::lDecodePlain(b, level)}) {
      ASSERT_GE(at.x, 0.0f);
      ASSERT_GE(at.y, 0.0f);
      ASSERT_LE(at.x, static_cast<float>(level));
      ASSERT_LE(at.y, static_cast<float>(level));
    }
  }
  EXPECT_EQ(glsl::lDecodeExact({-1.0f, 0.0f, 0.0f}, 5), glm::vec2(0.0f));
  EXPECT_EQ(glsl::lDecodePlain({0.2f, 0.3f, 0.5f}, 0), glm::vec2(0.0f));
  EXPECT_EQ(glsl::lDecodeExact({0.2f, 0.3f, 0.5f}, 0), glm::vec2(0.0f));
}

TEST(LPack, FourBytesAPrimitive) {
  for (uint level = 0; level < glsl::kLLevels; ++level)
    for (const uint slot : {0u, 1u, 4711u, glsl::kLMostSlots - 1}) {
      const glsl::LPlace place = glsl::unpackL(glsl::packL({level, slot}));
      ASSERT_EQ(place.level, level);
      ASSERT_EQ(place.slot, slot);
    }
  EXPECT_LE(glsl::unpackL(0xffffffffu).level, 64u);
}

/// What even levels alone would cost: the numbers in lpack.h.
TEST(LPack, AllLevelsWasteLessThanEvenOnes) {
  struct Cost {
    double samples = 0.0;
    double duplicates = 0.0;
  };
  const auto cost = [](double least, double most, bool evenOnly) {
    double ideal = 0.0;
    double samples = 0.0;
    double texels = 0.0;
    const int steps = 20000;
    for (int i = 0; i < steps; ++i) {
      const double size = least * std::pow(most / least, (i + 0.5) / steps);
      const uint level =
          evenOnly ? 2 * static_cast<uint>(std::ceil(size / 2)) : static_cast<uint>(std::ceil(size));
      // tessUniformCount without its whole numbers.
      ideal += 0.75 * size * size + 1.5 * size + 0.875;
      samples += glsl::tessUniformCount(level);
      texels += glsl::lTexels(level);
    }
    return Cost{samples / ideal - 1.0, texels / samples - 1.0};
  };
  for (const auto& [least, most] : {std::pair(1.0, 8.0), std::pair(8.0, 64.0), std::pair(1.0, 64.0)}) {
    const Cost even = cost(least, most, true);
    const Cost all = cost(least, most, false);
    std::printf(
        "sizes %g to %g: even levels %.1f %% more samples and %.1f %% twice, all levels %.1f %% and %.1f "
        "%%\n",
        least, most, even.samples * 100, even.duplicates * 100, all.samples * 100, all.duplicates * 100);
    EXPECT_LT((1 + all.samples) * (1 + all.duplicates), (1 + even.samples) * (1 + even.duplicates));
  }
}

}  // namespace
}  // namespace tessera
