// Colours to luma and chroma and back, against BT.709 in long double, written out anew.
#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "engine/image/yuv.hpp"

namespace tessera {
namespace {

using Real = long double;

struct Yuv {
  Real y, cb, cr;
};

// The matrix as the standard gives it: weights of luma, and differences scaled to +-1/2.
Yuv exactYuv(Real r, Real g, Real b) {
  const Real kr = 0.2126L;
  const Real kb = 0.0722L;
  const Real y = kr * r + (1 - kr - kb) * g + kb * b;
  return {y, (b - y) / (2 * (1 - kb)) + 128, (r - y) / (2 * (1 - kr)) + 128};
}

struct Rgb {
  Real r, g, b;
};

Rgb exactRgb(Real y, Real cb, Real cr) {
  const Real kr = 0.2126L;
  const Real kb = 0.0722L;
  const Real r = y + 2 * (1 - kr) * (cr - 128);
  const Real b = y + 2 * (1 - kb) * (cb - 128);
  return {r, (y - kr * r - kb * b) / (1 - kr - kb), b};
}

/// Whether `value` is what `exact`, cut to 0..255, rounds to. Long double has 64 bits, so halves are told
/// apart up to 1e-15 or so; at a half both neighbours would be right, and the upper is wanted.
bool isRounded(int value, Real exact) {
  const Real cut = std::fmin(255.0L, std::fmax(0.0L, exact));
  return value == static_cast<int>(std::floor(cut + 0.5L + 1e-12L));
}

/// All colours of one red, as an image.
Image plane(int red) {
  Image image{256, 256, std::vector<std::uint8_t>(std::size_t{256} * 256 * 4)};
  for (int g = 0; g < 256; ++g)
    for (int b = 0; b < 256; ++b) {
      std::uint8_t* to = image.at(b, g);
      to[0] = static_cast<std::uint8_t>(red);
      to[1] = static_cast<std::uint8_t>(g);
      to[2] = static_cast<std::uint8_t>(b);
      to[3] = static_cast<std::uint8_t>(g ^ b);
    }
  return image;
}

TEST(Yuv, EveryColourIsRoundedCorrectlyAndComesBackWithinAStep) {
  std::size_t wrong = 0;
  std::size_t off = 0;
  std::size_t backWrong = 0;
  int largest = 0;
  for (int red = 0; red < 256; ++red) {
    const Image image = plane(red);
    const auto yuv = toYuv(image, Chroma::Yuv444);
    ASSERT_TRUE(yuv) << yuv.error().message;
    const YuvView view = yuv->view();
    const auto back = toRgb(view);
    ASSERT_TRUE(back) << back.error().message;
    for (int g = 0; g < 256; ++g)
      for (int b = 0; b < 256; ++b) {
        const Yuv exact = exactYuv(red, g, b);
        const int y = view.at(0, b, g);
        const int cb = view.at(1, b, g);
        const int cr = view.at(2, b, g);
        wrong += isRounded(y, exact.y) && isRounded(cb, exact.cb) && isRounded(cr, exact.cr) ? 0 : 1;
        const Rgb again = exactRgb(y, cb, cr);
        const std::uint8_t* to = back->at(b, g);
        backWrong += isRounded(to[0], again.r) && isRounded(to[1], again.g) && isRounded(to[2], again.b) &&
                             to[3] == 255
                         ? 0
                         : 1;
        for (int i = 0; i < 3; ++i)
          largest = std::max(largest, std::abs(to[i] - static_cast<int>(image.at(b, g)[i])));
        off += to[0] == red && to[1] == g && to[2] == b ? 0 : 1;
      }
  }
  EXPECT_EQ(wrong, 0u) << "of 2^24 colours";
  EXPECT_EQ(backWrong, 0u) << "of 2^24 colours";
  EXPECT_LE(largest, 1);
  EXPECT_GT(off, 0u) << "8 bits cannot hold them all: a test that finds none is blind";
}

TEST(Yuv, ValuesThatNoColourHasAreCutOneChannelAtATime) {
  // Planes of every kind of luma and chroma, also those outside of the colours.
  YuvImage yuv(256, 256, Chroma::Yuv444);
  std::size_t wrong = 0;
  for (int luma = 0; luma < 256; luma += 5) {
    const YuvView view = yuv.view();
    for (int cb = 0; cb < 256; ++cb)
      for (int cr = 0; cr < 256; ++cr) {
        const auto at = static_cast<std::size_t>(cb) * view.strides[0] + static_cast<std::size_t>(cr);
        yuv.bytes[at] = static_cast<std::uint8_t>(luma);
        yuv.bytes[at + 65536] = static_cast<std::uint8_t>(cb);
        yuv.bytes[at + 131072] = static_cast<std::uint8_t>(cr);
      }
    const auto image = toRgb(view);
    ASSERT_TRUE(image);
    for (int cb = 0; cb < 256; ++cb)
      for (int cr = 0; cr < 256; ++cr) {
        const Rgb exact = exactRgb(luma, cb, cr);
        const std::uint8_t* to = image->at(cr, cb);
        wrong += isRounded(to[0], exact.r) && isRounded(to[1], exact.g) && isRounded(to[2], exact.b) ? 0 : 1;
      }
  }
  EXPECT_EQ(wrong, 0u);
}

TEST(Yuv, ASquareSharesTheChromaOfItsMean) {
  // Odd sides: the last column and row stand for two.
  Image image{7, 5, std::vector<std::uint8_t>(std::size_t{7} * 5 * 4)};
  std::uint32_t state = 7;
  for (std::uint8_t& value : image.pixels) {
    state = state * 1664525u + 1013904223u;
    value = static_cast<std::uint8_t>(state >> 24u);
  }
  const auto yuv = toYuv(image, Chroma::Yuv420);
  ASSERT_TRUE(yuv);
  const YuvView view = yuv->view();
  ASSERT_EQ(view.planeWidth(1), 4);
  ASSERT_EQ(view.planeHeight(2), 3);
  EXPECT_EQ(yuv->bytes.size(), 8u * 5 + 2 * 4 * 3) << "rows are padded to four bytes";
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) {
      const std::uint8_t* p = image.at(x, y);
      EXPECT_TRUE(isRounded(view.at(0, x, y), exactYuv(p[0], p[1], p[2]).y));
    }
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x) {
      Yuv mean{};
      for (int i = 0; i < 4; ++i) {
        const std::uint8_t* p = image.at(std::min(2 * x + i % 2, 6), std::min(2 * y + i / 2, 4));
        const Yuv one = exactYuv(p[0], p[1], p[2]);
        mean.cb += one.cb / 4;
        mean.cr += one.cr / 4;
      }
      EXPECT_TRUE(isRounded(view.at(1, x, y), mean.cb)) << x << ", " << y;
      EXPECT_TRUE(isRounded(view.at(2, x, y), mean.cr)) << x << ", " << y;
    }
  // And back: a texel has its own luma and its square's chroma.
  const auto back = toRgb(view);
  ASSERT_TRUE(back);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) {
      const Rgb exact = exactRgb(view.at(0, x, y), view.at(1, x / 2, y / 2), view.at(2, x / 2, y / 2));
      const std::uint8_t* to = back->at(x, y);
      EXPECT_TRUE(isRounded(to[0], exact.r) && isRounded(to[1], exact.g) && isRounded(to[2], exact.b));
    }
}

TEST(Yuv, KnownColours) {
  // By hand: white, black, grey, and red's 0.2126 * 255 = 54.2, -54.2 / 1.8556 + 128 = 98.8, 200.8 / 1.5748 +
  // 128.
  Image image{4, 1, {255, 255, 255, 0, 0, 0, 0, 0, 119, 119, 119, 0, 255, 0, 0, 0}};
  const auto yuv = toYuv(image, Chroma::Yuv444);
  ASSERT_TRUE(yuv);
  EXPECT_EQ(yuv->bytes, (std::vector<std::uint8_t>{255, 0, 119, 54, 128, 128, 128, 99, 128, 128, 128, 255}));
}

TEST(Yuv, WhatIsNoPictureIsRefused) {
  EXPECT_FALSE(toYuv(Image{}, Chroma::Yuv420));
  EXPECT_FALSE(toYuv(Image{2, 2, std::vector<std::uint8_t>(15)}, Chroma::Yuv420));
  EXPECT_FALSE(toRgb(YuvView{}));
  const YuvImage good(16, 16, Chroma::Yuv420);
  EXPECT_TRUE(checkPlanes(good.view()));
  YuvView overlap = good.view();
  overlap.strides[1] = 7;
  const auto refused = checkPlanes(overlap);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("plane 1: 7 bytes"), std::string::npos) << refused.error().message;
  YuvView missing = good.view();
  missing.planes[2] = nullptr;
  EXPECT_FALSE(checkPlanes(missing));
}

}  // namespace
}  // namespace tessera
