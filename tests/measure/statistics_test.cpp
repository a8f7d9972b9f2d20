#include "engine/measure/statistics.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(Statistics, HandWorked) {
  const std::vector<double> samples{5, 1, 4, 2, 3};
  const Statistics s = summarize(samples);
  EXPECT_EQ(s.count, 5U);
  EXPECT_DOUBLE_EQ(s.min, 1.0);
  EXPECT_DOUBLE_EQ(s.max, 5.0);
  EXPECT_DOUBLE_EQ(s.mean, 3.0);
  EXPECT_DOUBLE_EQ(s.median, 3.0);
  EXPECT_DOUBLE_EQ(s.p95, 4.8);     // position 0.95 * 4 = 3.8: 4 + 0.8
  EXPECT_DOUBLE_EQ(s.spread, 2.0);  // 4 - 2
}

TEST(Statistics, EvenCountTakesTheMiddle) {
  const std::vector<double> samples{10, 40, 20, 30};
  const Statistics s = summarize(samples);
  EXPECT_DOUBLE_EQ(s.median, 25.0);
  EXPECT_DOUBLE_EQ(s.spread, 15.0);  // positions 0.75 and 2.25: 17.5 and 32.5
}

TEST(Statistics, OneSampleIsEveryQuantile) {
  const std::vector<double> samples{7.5};
  const Statistics s = summarize(samples);
  EXPECT_EQ(s.min, 7.5);
  EXPECT_EQ(s.max, 7.5);
  EXPECT_EQ(s.median, 7.5);
  EXPECT_EQ(s.p95, 7.5);
  EXPECT_EQ(s.spread, 0.0);
}

TEST(Statistics, NoSamplesAreNotZero) {
  const Statistics s = summarize({});
  EXPECT_EQ(s.count, 0U);
  for (const double value : {s.min, s.max, s.mean, s.median, s.p95, s.spread}) EXPECT_TRUE(std::isnan(value));
  EXPECT_TRUE(std::isnan(quantileOfSorted({}, 0.5)));
}

TEST(Statistics, LostSamplesAreLeftOut) {
  const double lost = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  const std::vector<double> samples{lost, 3, infinite, 1, -infinite, 2, lost};
  const Statistics s = summarize(samples);
  EXPECT_EQ(s.count, 3U);
  EXPECT_DOUBLE_EQ(s.median, 2.0);
  EXPECT_DOUBLE_EQ(s.max, 3.0);
}

TEST(Statistics, QuantileEndsAreTheExtremes) {
  const std::vector<double> sorted{-2, 0, 9};
  EXPECT_EQ(quantileOfSorted(sorted, 0.0), -2.0);
  EXPECT_EQ(quantileOfSorted(sorted, 1.0), 9.0);
}

}  // namespace
}  // namespace tessera
