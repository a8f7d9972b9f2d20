#include "engine/measure/pvs_coverage.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(PvsCoverage, AsWorkedByHand) {
  // Of five elements 0 is needed and in the set, 1 needed and missed, 2 needless, 3 in the set but covered
  // where it was sampled, 4 is nowhere.
  const ElementPixels shown{{600, 200, 0, 0, 0}, 4};
  const ElementPixels sampled{{300, 0, 30, 0, 0}, 2};
  const PvsCoverage c = coverageOf(shown, sampled, {true, false, true, true, false});
  EXPECT_DOUBLE_EQ(c.needed, 200.0);
  EXPECT_DOUBLE_EQ(c.missed, 50.0);
  EXPECT_DOUBLE_EQ(c.needless, 15.0);
  EXPECT_DOUBLE_EQ(c.coverage(), 0.75);
  EXPECT_DOUBLE_EQ(c.overestimation(), 0.075);
  EXPECT_EQ(c.neededElements, 2u);
  EXPECT_EQ(c.missedElements, 1u);
  EXPECT_EQ(c.setElements, 3u);
  EXPECT_EQ(c.needlessElements, 2u);
}

TEST(PvsCoverage, WhereNothingIsSeen) {
  const ElementPixels nothing{{0, 0}, 1};
  const PvsCoverage empty = coverageOf(nothing, nothing, {false, false});
  EXPECT_EQ(empty.coverage(), 1.0);
  EXPECT_EQ(empty.overestimation(), 0.0);
  const PvsCoverage needless = coverageOf(nothing, {{7, 0}, 1}, {true, false});
  EXPECT_EQ(needless.coverage(), 1.0);
  EXPECT_TRUE(std::isinf(needless.overestimation()));
  const PvsCoverage noViews = coverageOf({{0, 0}, 0}, {{0, 0}, 0}, {false, false});
  EXPECT_EQ(noViews.needed, 0.0);
}

}  // namespace
}  // namespace tessera
