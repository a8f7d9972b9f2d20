#include "engine/measure/metrics.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/measure/acuity.hpp"

namespace tessera {
namespace {

Image constant(int width, int height, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  Image image{width, height, {}};
  for (int i = 0; i < width * height; ++i) image.pixels.insert(image.pixels.end(), {r, g, b, 255});
  return image;
}

Image noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image image{width, height, {}};
  for (int i = 0; i < width * height * 4; ++i)
    image.pixels.push_back(static_cast<std::uint8_t>(random() & 255U));
  return image;
}

std::size_t indexOf(int width, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

/// Smooth waves, so that filters see more than noise; `phase` moves them.
Image waves(int width, int height, double phase) {
  Image image{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height * 4), 255)};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>(127.5 + 120.0 * std::sin(0.09 * (c + 1) * x + phase) *
                                                                  std::cos(0.13 * y - 0.02 * x * c));
  return image;
}

/// `in` with up to `amount` less or more in each channel.
Image noisy(const Image& in, int amount) {
  std::mt19937 random(11);
  Image out = in;
  for (std::uint8_t& value : out.pixels)
    value = static_cast<std::uint8_t>(std::clamp(
        value + static_cast<int>(random() % (2U * static_cast<unsigned>(amount) + 1U)) - amount, 0, 255));
  return out;
}

Image upsideDown(const Image& in) {
  Image out = in;
  for (int y = 0; y < in.height; ++y) std::copy_n(in.at(0, in.height - 1 - y), in.width * 4, out.at(0, y));
  return out;
}

Image transposed(const Image& in) {
  Image out{in.height, in.width, std::vector<std::uint8_t>(in.pixels.size())};
  for (int y = 0; y < in.height; ++y)
    for (int x = 0; x < in.width; ++x) std::copy_n(in.at(x, y), 4, out.at(y, x));
  return out;
}

// ---- against independent tools ----

TEST(Metrics, MeetsIndependentTools) {
  const std::filesystem::path folder = std::filesystem::path(TESSERA_SHARED_DIR) / "metrics";
  if (!std::filesystem::exists(folder / "expected.json"))
    GTEST_SKIP() << "image pairs with expected values are absent: " << folder;
  const nlohmann::json expected = nlohmann::json::parse(std::ifstream(folder / "expected.json"));
  const auto reference = readImage(folder / "reference.png");
  ASSERT_TRUE(reference) << reference.error().message;
  ASSERT_GE(expected["pairs"].size(), 5U);
  for (const auto& [name, values] : expected["pairs"].items()) {
    const auto test = readImage(folder / (name + ".png"));
    ASSERT_TRUE(test) << test.error().message;
    EXPECT_NEAR(mssim(*reference, *test)->mean, values["mssim"].get<double>(), 1e-4) << name;
    EXPECT_NEAR(psnr(*reference, *test).value(), values["psnr_db"].get<double>(), 1e-4) << name;
    EXPECT_NEAR(flip(*reference, *test)->mean, values["flip_mean"].get<double>(), 2e-3) << name;
  }
}

// ---- PSNR ----

TEST(Psnr, KnownDifferences) {
  // Every channel off by 51 of 255: the mean square is 1/25.
  EXPECT_NEAR(psnr(constant(7, 3, 100, 100, 100), constant(7, 3, 151, 49, 151)).value(),
              10 * std::log10(25.0), 1e-12);
  // One channel of one of four pixels off by everything: 1/12.
  Image dot = constant(2, 2, 0, 0, 0);
  dot.at(1, 0)[1] = 255;
  EXPECT_NEAR(psnr(constant(2, 2, 0, 0, 0), dot).value(), 10 * std::log10(12.0), 1e-12);
}

TEST(Psnr, EqualIsInfiniteAndAlphaIsNotSeen) {
  Image other = noise(9, 9, 1);
  const Image image = other;
  for (std::size_t i = 3; i < other.pixels.size(); i += 4) other.pixels[i] ^= 255U;
  EXPECT_TRUE(std::isinf(psnr(image, other).value()));
  EXPECT_GT(psnr(image, other).value(), 0.0);
}

// ---- MSSIM ----

double luma(const std::uint8_t* p) { return (0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]) / 255; }

/// The definition for one window, by a 2D kernel and central moments; `a` and `b` give the luma at a column
/// and row of the window.
template <class A, class B>
double ssimByDefinition(A&& a, B&& b) {
  double weights[11][11];
  double total = 0;
  for (int j = 0; j < 11; ++j)
    for (int i = 0; i < 11; ++i)
      total += weights[j][i] = std::exp(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / 8.0);
  double ma = 0;
  double mb = 0;
  for (int j = 0; j < 11; ++j)
    for (int i = 0; i < 11; ++i) {
      ma += weights[j][i] / total * a(i, j);
      mb += weights[j][i] / total * b(i, j);
    }
  double va = 0;
  double vb = 0;
  double cov = 0;
  for (int j = 0; j < 11; ++j)
    for (int i = 0; i < 11; ++i) {
      const double da = a(i, j) - ma;
      const double db = b(i, j) - mb;
      va += weights[j][i] / total * da * da;
      vb += weights[j][i] / total * db * db;
      cov += weights[j][i] / total * da * db;
    }
  return (2 * ma * mb + 1e-4) / (ma * ma + mb * mb + 1e-4) * (2 * cov + 9e-4) / (va + vb + 9e-4);
}

double mssimByDefinition(const Image& a, const Image& b) {
  double sum = 0;
  for (int y = 0; y + 11 <= a.height; ++y)
    for (int x = 0; x + 11 <= a.width; ++x)
      sum += ssimByDefinition([&](int i, int j) { return luma(a.at(x + i, y + j)); },
                              [&](int i, int j) { return luma(b.at(x + i, y + j)); });
  return sum / ((a.width - 10) * (a.height - 10));
}

TEST(Mssim, EqualsTheDefinition) {
  const Image a = waves(53, 90, 0.0);  // taller than one band
  for (const Image& b : {waves(53, 90, 0.4), noise(53, 90, 3), constant(53, 90, 80, 90, 100)}) {
    const auto result = mssim(a, b);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->width, 43);
    EXPECT_EQ(result->height, 80);
    EXPECT_NEAR(result->mean, mssimByDefinition(a, b), 1e-10);
  }
}

TEST(Mssim, ConstantImagesFollowTheClosedForm) {
  // No variance: only the luminance term is left.
  const double x = 200 / 255.0;
  const double y = 50 / 255.0;
  const auto result = mssim(constant(20, 15, 200, 200, 200), constant(20, 15, 50, 50, 50));
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->mean, (2 * x * y + 1e-4) / (x * x + y * y + 1e-4), 1e-10);
}

TEST(Mssim, EqualIsOneEverywhere) {
  const Image image = noise(40, 70, 5);
  const auto result = mssim(image, image);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->mean, 1.0);
  for (const float value : result->map) ASSERT_EQ(value, 1.0F);
}

TEST(Mssim, SmallImagesUseTheLargestWindowThatFits) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 2}, {10, 30}, {1, 40}, {11, 11}}) {
    const Image a = noise(width, height, 7);
    const auto same = mssim(a, a);
    ASSERT_TRUE(same);
    EXPECT_EQ(same->mean, 1.0);
    EXPECT_EQ(same->width, std::max(1, width - 10));
    EXPECT_EQ(same->height, std::max(1, height - 10));
    const auto other = mssim(a, noise(width, height, 8));
    ASSERT_TRUE(other);
    EXPECT_LT(other->mean, 1.0);
  }
}

TEST(Mssim, DssimIsHalfTheDistanceToOne) {
  EXPECT_DOUBLE_EQ(dssim(1.0), 0.0);
  EXPECT_DOUBLE_EQ(dssim(0.9), 0.05);
  EXPECT_DOUBLE_EQ(dssim(-1.0), 1.0);
}

// ---- MSSIM at the scale of the eye ----

constexpr double kFovY = 1.0471975512;  // 60 degrees

/// The acuity scale of a pixel, worked in degrees from the law of cosines.
double scaleByHand(int width, int height, int x, int y, const Foveation& eye) {
  const double pixel = 2 * std::tan(kFovY / 2) / height;
  const double ax = (eye.gaze.x - 0.5) * width * pixel;
  const double ay = (eye.gaze.y - 0.5) * height * pixel;
  const double bx = (x + 0.5 - 0.5 * width) * pixel;
  const double by = (y + 0.5 - 0.5 * height) * pixel;
  const double a2 = 1 + ax * ax + ay * ay;
  const double b2 = 1 + bx * bx + by * by;
  const double c2 = (ax - bx) * (ax - bx) + (ay - by) * (ay - by);
  const double degrees =
      std::acos(std::min(1.0, (a2 + b2 - c2) / (2 * std::sqrt(a2 * b2)))) * 57.29577951308232;
  return std::max(1.0, (eye.slope * degrees + eye.smallest) / (2 * 60.0 / height));
}

TEST(AcuityScales, AreTheAcuityCurve) {
  const int width = 96;
  const int height = 540;  // pixels small enough for the eye to tell them apart only near the gaze
  const Foveation eye{{0.25, 0.75}};
  const auto scales = acuityScales(width, height, kFovY, eye);
  ASSERT_TRUE(scales);
  double largest = 1.0;
  std::size_t least = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float scale = (*scales)[indexOf(width, x, y)];
      ASSERT_NEAR(scale, scaleByHand(width, height, x, y, eye), 1e-5) << x << ", " << y;
      largest = std::max(largest, static_cast<double>(scale));
      least += scale == 1.0F ? 1 : 0;
    }
  EXPECT_GT(largest, 3.0);
  EXPECT_GT(least, 1000U);
}

TEST(AcuityScales, BadNumbersAreNamed) {
  EXPECT_NE(acuityScales(0, 5, 1.0).error().message.find("0 x 5"), std::string::npos);
  EXPECT_NE(acuityScales(5, 5, 4.0).error().message.find("4 radians"), std::string::npos);
  EXPECT_NE(acuityScales(5, 5, 1.0, {{0.5, 0.5}, -1.0}).error().message.find("-1"), std::string::npos);
  EXPECT_NE(acuityScales(5, 5, 1.0, {{0.5, std::nan("")}}).error().message.find("nan"), std::string::npos);
  EXPECT_FALSE(acuityScales(5, 5, std::nan("")));
}

/// A picture's luma on a level of half sizes, each value from the four below it.
double lumaAt(const Image& image, int level, int x, int y) {
  const int width = (image.width + (1 << level) - 1) >> level;
  const int height = (image.height + (1 << level) - 1) >> level;
  x = std::min(x, width - 1);
  y = std::min(y, height - 1);
  if (level == 0) return luma(image.at(x, y));
  double sum = 0;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) sum += lumaAt(image, level - 1, 2 * x + i, 2 * y + j);
  return sum / 4;
}

/// SSIM of the window whose middle is nearest to (x, y) on a level, for levels of 11 pixels and more.
double ssimAt(const Image& a, const Image& b, int level, int x, int y) {
  const int width = (a.width + (1 << level) - 1) >> level;
  const int height = (a.height + (1 << level) - 1) >> level;
  const int left = std::clamp(x, 5, width - 6) - 5;
  const int top = std::clamp(y, 5, height - 6) - 5;
  return ssimByDefinition([&](int i, int j) { return lumaAt(a, level, left + i, top + j); },
                          [&](int i, int j) { return lumaAt(b, level, left + i, top + j); });
}

TEST(AcuityMssim, EqualsTheDefinition) {
  const int width = 117;  // odd from the first level on, and on the second in height
  const int height = 90;
  // A display so large that 1 to 8 of its cycles go into one that this eye resolves.
  const Foveation eye{{0.2, 0.6}, 0.13, 0.3};
  const Image a = waves(width, height, 0.0);
  const Image b = noisy(waves(width, height, 0.3), 9);
  const auto result = acuityMssim(a, b, kFovY, eye);
  ASSERT_TRUE(result) << result.error().message;
  double sum = 0;
  double total = 0;
  double largest = 0;
  for (int y = 5; y < height - 5; ++y)
    for (int x = 5; x < width - 5; ++x) {
      const double s = scaleByHand(width, height, x, y, eye);
      const int k = static_cast<int>(std::floor(std::log2(s)));
      const double toCoarse = std::log2(s) - k;
      const double fine = ssimAt(a, b, k, x >> k, y >> k);
      const double coarse = ssimAt(a, b, k + 1, x >> (k + 1), y >> (k + 1));
      sum += (fine * (1 - toCoarse) + coarse * toCoarse) / (s * s);
      total += 1 / (s * s);
      largest = std::max(largest, s);
    }
  EXPECT_GT(largest, 4.0) << "fewer levels than meant";
  EXPECT_LT(largest, 8.0) << "levels smaller than a window";
  EXPECT_NEAR(*result, sum / total, 1e-6);
  EXPECT_GT(std::abs(*result - mssim(a, b)->mean), 1e-2) << "the eye made no difference";
}

TEST(AcuityMssim, WithoutFalloffIsMssim) {
  const Foveation sharp{{0.1, 0.9}, 0.0, 1e-6};
  for (const auto& [width, height] : {std::pair{53, 90}, {11, 11}, {3, 2}, {1, 1}}) {
    const Image a = waves(width, height, 0.0);
    const Image b = noise(width, height, 3);
    const auto result = acuityMssim(a, b, kFovY, sharp);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_NEAR(*result, mssim(a, b)->mean, 1e-7) << width << " x " << height;  // summed from floats
  }
}

TEST(AcuityMssim, EqualIsOneForAnyEye) {
  for (const auto& [width, height] : {std::pair{200, 120}, {7, 300}, {3, 2}, {1, 1}}) {
    const Image image = noise(width, height, 5);
    for (const Foveation& eye : {Foveation{}, {{0.9, 0.1}, 0.1, 0.3}, {{-10.0, 3.0}, 10.0, 90.0}})
      EXPECT_NEAR(acuityMssim(image, image, kFovY, eye).value(), 1.0, 1e-12) << width << " x " << height;
    EXPECT_FALSE(acuityMssim(image, image, kFovY, {{-50.0, 3.0}, 10.0, 90.0}))
        << "a gaze far from any picture";
  }
}

/// `clean` with 20 x 20 pixels of another picture.
Image spoiled(const Image& clean, const Image& dirt, int left, int top) {
  Image image = clean;
  for (int y = top; y < top + 20; ++y)
    for (int x = left; x < left + 20; ++x) std::copy_n(dirt.at(x, y), 3, image.at(x, y));
  return image;
}

TEST(AcuityMssim, AnErrorAtTheGazeCountsMore) {
  const Foveation eye{{0.25, 0.5}, 0.1, 0.3};
  const Image clean = waves(200, 120, 0.0);
  const Image dirt = constant(200, 120, 255, 255, 255);  // seen at any scale
  const double atGaze = 1.0 - acuityMssim(clean, spoiled(clean, dirt, 40, 50), kFovY, eye).value();
  const double aside = 1.0 - acuityMssim(clean, spoiled(clean, dirt, 160, 50), kFovY, eye).value();
  EXPECT_GT(atGaze, 5.0 * aside);
  EXPECT_GT(aside, 1e-3);
}

TEST(AcuityMssim, BlurBelowTheEyesResolutionCountsLittle) {
  const int width = 256;
  const int height = 128;
  const Image clean = noise(width, height, 4);
  Image blurred = clean;
  for (int y = 0; y < height; y += 2)
    for (int x = 0; x < width; x += 2)
      for (int c = 0; c < 3; ++c) {
        const int sum =
            clean.at(x, y)[c] + clean.at(x + 1, y)[c] + clean.at(x, y + 1)[c] + clean.at(x + 1, y + 1)[c];
        for (int i = 0; i < 4; ++i)
          blurred.at(x + i % 2, y + i / 2)[c] = static_cast<std::uint8_t>((sum + 2) / 4);
      }
  const Foveation eye{{0.25, 0.5}, 0.1, 0.01};
  const auto scales = acuityScales(width, height, kFovY, eye);
  ASSERT_TRUE(scales);
  // What the blur takes from the mean where every pixel is seen at the scale of the display.
  const auto lossOf = [&](const Image& test) {
    const auto map = mssim(clean, test);
    double loss = 0;
    double total = 0;
    for (int y = 0; y < map->height; ++y)
      for (int x = 0; x < map->width; ++x) {
        const double s = static_cast<double>((*scales)[indexOf(width, x + 5, y + 5)]);
        loss += (1 - map->map[indexOf(map->width, x, y)]) / (s * s);
        total += 1 / (s * s);
      }
    return loss / total;
  };
  const Image atGaze = spoiled(clean, blurred, 54, 54);
  const Image aside = spoiled(clean, blurred, 180, 54);
  EXPECT_EQ((*scales)[indexOf(width, 50, 64)], 1.0F);
  EXPECT_GT((*scales)[indexOf(width, 175, 64)], 2.0F);
  EXPECT_LT(mssim(clean, aside)->mean, 0.995) << "no blur to see";
  EXPECT_NEAR(1 - acuityMssim(clean, atGaze, kFovY, eye).value(), lossOf(atGaze), 1e-2 * lossOf(atGaze));
  EXPECT_LT(1 - acuityMssim(clean, aside, kFovY, eye).value(), 1e-2 * lossOf(aside));
}

TEST(AcuityMssim, BadInputIsNamed) {
  const Image image = noise(20, 20, 1);
  EXPECT_NE(acuityMssim(image, noise(20, 21, 1), kFovY).error().message.find("20 x 21"), std::string::npos);
  EXPECT_NE(acuityMssim(image, image, -1.0).error().message.find("-1 radians"), std::string::npos);
  EXPECT_NE(acuityMssim(image, image, kFovY, {{0.5, 0.5}, 0.02, 91.0}).error().message.find("91"),
            std::string::npos);
  EXPECT_FALSE(acuityMssim(Image{}, Image{}, kFovY));
}

// ---- FLIP ----

TEST(Flip, EqualIsZeroEverywhere) {
  const Image image = noise(50, 70, 9);
  const auto result = flip(image, image);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->mean, 0.0);
  EXPECT_EQ(*std::max_element(result->map.begin(), result->map.end()), 0.0F);
}

TEST(Flip, ConstantColoursWorkedByHand) {
  // Tables give L*a*b* of sRGB green as 87.73, -86.18, 83.18 and of blue as 32.30, 79.19, -107.86. With the
  // chroma scaled by L*/100 their HyAB distance is 203.3; to the power 0.7 the largest difference, 41.27,
  // knee at 16.51.
  const double largest =
      std::pow(55.43 + std::hypot(0.8773 * 86.18 + 0.3230 * 79.19, 0.8773 * 83.18 + 0.3230 * 107.86), 0.7);
  const double knee = 0.4 * largest;
  // Black to white is 100 in L*; constant images have no features, so that the colour difference is all.
  const double blackWhite = 0.95 + (std::pow(100.0, 0.7) - knee) / (largest - knee) * 0.05;
  EXPECT_NEAR(flip(constant(30, 30, 0, 0, 0), constant(30, 30, 255, 255, 255))->mean, blackWhite, 2e-4);
  // sRGB grey 119 has L* 50.03 (linear 0.1845), and grey 0 has 0: below the knee.
  const double greyBlack = 0.95 * std::pow(50.03, 0.7) / knee;
  EXPECT_NEAR(flip(constant(30, 30, 0, 0, 0), constant(30, 30, 119, 119, 119))->mean, greyBlack, 5e-4);
  // Green against blue is the largest difference itself.
  EXPECT_NEAR(flip(constant(30, 30, 0, 255, 0), constant(30, 30, 0, 0, 255))->mean, 1.0, 1e-5);
}

TEST(Flip, ValuesAreFiniteAndBetweenZeroAndOne) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 1}, {1, 200}, {64, 65}}) {
    for (const double ppd : {1.0, 67.0, 1000.0}) {
      const auto result = flip(noise(width, height, 10), noise(width, height, 11), ppd);
      ASSERT_TRUE(result);
      ASSERT_EQ(result->map.size(), static_cast<std::size_t>(width * height));
      double sum = 0;
      for (const float value : result->map) {
        ASSERT_TRUE(value >= 0.0F && value <= 1.0F) << value;
        sum += double{value};
      }
      EXPECT_GT(result->mean, 0.0);
      EXPECT_NEAR(result->mean, sum / static_cast<double>(result->map.size()), 1e-9);
    }
  }
}

TEST(Flip, AnEdgeWeighsMoreThanItsColourDifference) {
  // The same small colour difference as a step in one image only: the feature term must raise the error at
  // the step.
  const Image flat = constant(80, 40, 120, 120, 120);
  Image step = flat;
  for (int y = 0; y < 40; ++y)
    for (int x = 40; x < 80; ++x) std::fill_n(step.at(x, y), 3, std::uint8_t{160});
  const auto result = flip(flat, step);
  ASSERT_TRUE(result);
  const auto at = [&](std::size_t x) { return result->map[20 * 80 + x]; };
  EXPECT_NEAR(at(70), flip(flat, constant(80, 40, 160, 160, 160))->mean, 1e-5);
  EXPECT_GT(at(41), at(70) + 0.02F);
  EXPECT_LT(at(5), 1e-4F);
}

TEST(Flip, RefusesPixelsPerDegreeOutsideItsRange) {
  const Image image = constant(4, 4, 1, 2, 3);
  for (const double ppd : {0.0, -67.0, 0.5, 1001.0, std::nan("")})
    EXPECT_FALSE(flip(image, image, ppd)) << ppd;
}

// ---- all of them ----

TEST(Metrics, SymmetricInTheirImages) {
  const Image a = waves(90, 70, 0.0);
  const Image b = noise(90, 70, 12);
  EXPECT_DOUBLE_EQ(mssim(a, b)->mean, mssim(b, a)->mean);
  EXPECT_DOUBLE_EQ(psnr(a, b).value(), psnr(b, a).value());
  EXPECT_DOUBLE_EQ(flip(a, b)->mean, flip(b, a)->mean);
}

TEST(Metrics, BandsLeaveNoSeam) {
  // 150 rows upside down, or as columns, put the seams between bands of rows elsewhere.
  const Image a = waves(100, 150, 0.0);
  const Image b = waves(100, 150, 0.5);
  const auto expectMirrored = [](const MetricMap& map, const MetricMap& mirrored) {
    ASSERT_EQ(map.map.size(), mirrored.map.size());
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x)
        ASSERT_NEAR(map.map[static_cast<std::size_t>(y * map.width + x)],
                    mirrored.map[static_cast<std::size_t>((map.height - 1 - y) * map.width + x)], 2e-3)
            << x << ", " << y;
    EXPECT_NEAR(map.mean, mirrored.mean, 1e-5);
  };
  expectMirrored(*mssim(a, b), *mssim(upsideDown(a), upsideDown(b)));
  expectMirrored(*flip(a, b), *flip(upsideDown(a), upsideDown(b)));
  EXPECT_NEAR(mssim(a, b)->mean, mssim(transposed(a), transposed(b))->mean, 1e-10);
  EXPECT_NEAR(flip(a, b)->mean, flip(transposed(a), transposed(b))->mean, 1e-5);
}

TEST(Metrics, RefusePairsThatDoNotMatch) {
  Image shortened = constant(8, 8, 0, 0, 0);
  shortened.pixels.pop_back();
  const Image image = constant(8, 8, 0, 0, 0);
  const std::pair<Image, Image> pairs[] = {{image, constant(8, 9, 0, 0, 0)},
                                           {{}, {}},
                                           {image, shortened},
                                           {shortened, image},
                                           {{-8, -8, image.pixels}, {-8, -8, image.pixels}}};
  for (const auto& [a, b] : pairs) {
    EXPECT_FALSE(mssim(a, b));
    EXPECT_FALSE(psnr(a, b));
    EXPECT_FALSE(flip(a, b));
  }
  EXPECT_EQ(mssim(image, constant(8, 9, 0, 0, 0)).error().message,
            "MSSIM: the reference is 8 x 8 pixels, the test image 8 x 9");
}

TEST(Metrics, LargeImages) {
  const Image a = noise(2600, 1400, 13);
  Image b = a;
  for (int y = 1000; y < 1100; ++y) std::fill_n(b.at(2000, y), 400, std::uint8_t{0});
  const auto similarity = mssim(a, b);
  const auto error = flip(a, b);
  ASSERT_TRUE(similarity);
  ASSERT_TRUE(error);
  // What changed is 100 x 100 pixels and the reach of the filters around them, and nothing else.
  const auto changed = std::count_if(error->map.begin(), error->map.end(), [](float e) { return e > 0.0F; });
  EXPECT_GT(changed, 9000);
  EXPECT_LE(changed, 120 * 120);
  const auto dissimilar =
      std::count_if(similarity->map.begin(), similarity->map.end(), [](float s) { return s < 1.0F; });
  EXPECT_GT(dissimilar, 9000);
  EXPECT_LE(dissimilar, 110 * 110);
}

TEST(Metrics, TimeOfAFrame) {
  const Image a = noise(1280, 720, 1);
  const Image b = noise(1280, 720, 2);
  const auto start = std::chrono::steady_clock::now();
  ASSERT_TRUE(mssim(a, b));
  const auto middle = std::chrono::steady_clock::now();
  ASSERT_TRUE(flip(a, b));
  const auto end = std::chrono::steady_clock::now();
  // Recorded, not judged: a machine that is busy must not fail the test.
  RecordProperty("mssim_ms",
                 std::to_string(std::chrono::duration<double, std::milli>(middle - start).count()));
  RecordProperty("flip_ms", std::to_string(std::chrono::duration<double, std::milli>(end - middle).count()));
}

}  // namespace
}  // namespace tessera
