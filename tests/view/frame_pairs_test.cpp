#include "engine/view/frame_pairs.hpp"

#include <gtest/gtest.h>

#include "tests/view/one_patch.hpp"

namespace tessera {
namespace {

using test::OnePatch;
using view::FramePairs;

struct Pairs : ::testing::Test {
  OnePatch source;
  FramePairs pairs{OnePatch::setup()};
  view::ShadedFrame frame;

  void announce(std::uint32_t number, std::uint32_t x) {
    pairs.header(OnePatch::header(number), {}, {});
    auto done = pairs.geometry(source.geometry(number, x));
    ASSERT_TRUE(done) << done.error().message;
  }
  void picture(std::uint32_t number) {
    ASSERT_TRUE(pairs.picture(OnePatch::picture(number, static_cast<std::uint8_t>(number))));
  }
  bool next() {
    auto whole = pairs.next(frame);
    EXPECT_TRUE(whole) << whole.error().message;
    return whole && *whole;
  }
  std::uint32_t origin() const { return frame.patches.at(0).origin; }
};

TEST_F(Pairs, GeometryWaitsForItsAtlas) {
  announce(1, 0);
  EXPECT_FALSE(next());
  picture(1);
  ASSERT_TRUE(next());
  EXPECT_EQ(frame.header.frame, 1u);
  EXPECT_EQ(frame.atlas.bytes[0], 1);
  EXPECT_EQ(origin(), 0u);
  EXPECT_FALSE(next()) << "given twice";
}

TEST_F(Pairs, AnAtlasWaitsForItsGeometry) {
  picture(1);
  EXPECT_FALSE(next());
  announce(1, 0);
  EXPECT_TRUE(next());
}

TEST_F(Pairs, ALostAtlasLosesNoGeometry) {
  announce(1, 0);
  picture(1);
  ASSERT_TRUE(next());
  announce(2, 16);
  announce(3, 32);
  announce(4, 48);
  picture(3);  // 2 never came, 4 is on its way
  ASSERT_TRUE(next());
  EXPECT_EQ(frame.header.frame, 3u);
  EXPECT_EQ(origin(), 32u) << "places must be those of the atlas that is shown";
  picture(2);  // late
  EXPECT_FALSE(next());
  picture(4);
  ASSERT_TRUE(next());
  EXPECT_EQ(origin(), 48u);
}

TEST_F(Pairs, TheNewestOfSeveralIsShown) {
  for (std::uint32_t i = 1; i <= 3; ++i) {
    announce(i, 16 * (i - 1));
    picture(i);
  }
  ASSERT_TRUE(next());
  EXPECT_EQ(frame.header.frame, 3u);
  EXPECT_EQ(frame.atlas.bytes[0], 3);
  EXPECT_FALSE(next());
}

TEST_F(Pairs, WhatWaitsIsBounded) {
  pairs = FramePairs(OnePatch::setup(), {.messages = 2, .bytes = 1 << 20, .pictures = 1});
  for (std::uint32_t i = 1; i <= 5; ++i) announce(i, 16 * (i % 2));
  EXPECT_EQ(pairs.applied(), 3u);
  picture(2);  // its geometry is past
  EXPECT_FALSE(next());
  picture(4);
  picture(5);
  ASSERT_TRUE(next());
  EXPECT_EQ(frame.header.frame, 5u);
}

TEST_F(Pairs, RefusesAnAtlasOfAnotherSize) {
  view::Picture picture;
  picture.frame = 1;
  picture.planes = YuvImage(32, 64, Chroma::Yuv444);
  const auto done = pairs.picture(std::move(picture));
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("32x64"), std::string::npos) << done.error().message;
}

TEST_F(Pairs, BrokenGeometryNamesItsFrame) {
  pairs.header(OnePatch::header(7), {}, {});
  ASSERT_TRUE(pairs.geometry({7, {1, 2, 3}}));
  picture(7);
  const auto whole = pairs.next(frame);
  ASSERT_FALSE(whole);
  EXPECT_NE(whole.error().message.find("frame 7"), std::string::npos) << whole.error().message;
}

}  // namespace
}  // namespace tessera
