#include "engine/measure/colormap.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tessera {
namespace {

double lightness(const Rgb8& c) {
  const auto linear = [](std::uint8_t v) { return std::pow(v / 255.0, 2.2); };
  return 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
}

TEST(Colormap, EndsAndStops) {
  const auto stops = colormapStops();
  ASSERT_GE(stops.size(), 2U);
  EXPECT_EQ(colormap(0.0F), stops.front());
  EXPECT_EQ(colormap(1.0F), stops.back());
  for (std::size_t i = 0; i < stops.size(); ++i)
    EXPECT_EQ(colormap(static_cast<float>(i) / static_cast<float>(stops.size() - 1)), stops[i])
        << "stop " << i;
}

TEST(Colormap, ValuesOutsideTakeTheEnds) {
  EXPECT_EQ(colormap(-3.0F), colormapStops().front());
  EXPECT_EQ(colormap(std::numeric_limits<float>::infinity()), colormapStops().back());
}

TEST(Colormap, LightnessRises) {
  for (int i = 1; i <= 50; ++i)
    EXPECT_GT(lightness(colormap(static_cast<float>(i) / 50.0F)),
              lightness(colormap(static_cast<float>(i - 1) / 50.0F)))
        << "at " << i << " of 50";
}

TEST(Colormap, NotANumberIsSeen) {
  const Rgb8 cyan{0, 255, 255};
  EXPECT_EQ(colormap(std::numeric_limits<float>::quiet_NaN()), cyan);
}

TEST(ErrorMap, ScalesToFull) {
  const MetricMap error{3, 1, {0.0F, 0.25F, 0.5F}, 0.25};
  const Image image = errorMap(error, 0.5F);
  ASSERT_EQ(image.width, 3);
  ASSERT_EQ(image.height, 1);
  ASSERT_EQ(image.pixels.size(), 12U);
  const float expected[] = {0.0F, 0.5F, 1.0F};
  for (int x = 0; x < 3; ++x) {
    const Rgb8 colour = colormap(expected[x]);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(image.at(x, 0)[c], colour[c]) << "pixel " << x;
    EXPECT_EQ(image.at(x, 0)[3], 255);
  }
}

TEST(ErrorMap, DissimilarityOfSimilarity) {
  const MetricMap error = dissimilarity({3, 1, {1.0F, 0.0F, -1.0F}, 0.0});
  EXPECT_FLOAT_EQ(error.map[0], 0.0F);
  EXPECT_FLOAT_EQ(error.map[1], 0.5F);
  EXPECT_FLOAT_EQ(error.map[2], 1.0F);
  EXPECT_DOUBLE_EQ(error.mean, 0.5);
}

}  // namespace
}  // namespace tessera
