// The formulas of foveation and lens, against double code of another form and brute force. No GL.
#include "glsl/shared/acuity.h"

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "engine/frame/view.hpp"

namespace tessera {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;

using Corners = std::array<glm::vec3, 5>;

glsl::Cone coneOf(const Corners& v, glsl::uint triangles) {
  return glsl::coneOfPatch(v[0], v[1], v[2], v[3], v[4], triangles);
}

/// By the haversine of the chord: neither atan2 of the cross product nor acos.
double angleOf(const glm::dvec3& a, const glm::dvec3& b) {
  const double chord = glm::length(a / glm::length(a) - b / glm::length(b));
  return 2.0 * std::asin(std::min(1.0, 0.5 * chord));
}

struct Random {
  std::mt19937 engine{7};
  double unit() { return std::uniform_real_distribution<double>(0.0, 1.0)(engine); }
  double normal() { return std::normal_distribution<double>()(engine); }
  glm::dvec3 vector() { return {normal(), normal(), normal()}; }
};

/// The triangles of a patch, as PatchGeometry lays them out.
constexpr std::array<std::array<std::size_t, 3>, 3> kTriangles = {{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}};

/// The least angle from `direction` to samples of the patch: corners, edges and insides.
double nearest(const Corners& v, unsigned triangles, const glm::dvec3& direction, Random& random) {
  double least = 10.0;
  const auto look = [&](const glm::dvec3& p) {
    if (glm::length(p) > 0.0) least = std::min(least, angleOf(p, direction));
  };
  for (unsigned t = 0; t < triangles; ++t) {
    const glm::dvec3 a(v[kTriangles[t][0]]);
    const glm::dvec3 b(v[kTriangles[t][1]]);
    const glm::dvec3 c(v[kTriangles[t][2]]);
    for (int i = 0; i <= 40; ++i) {
      const double s = i / 40.0;
      look(glm::mix(a, b, s));
      look(glm::mix(b, c, s));
      look(glm::mix(c, a, s));
    }
    for (int i = 0; i < 300; ++i) {
      double s = random.unit();
      double r = random.unit();
      if (s + r > 1.0) {
        s = 1.0 - s;
        r = 1.0 - r;
      }
      look(a + (b - a) * s + (c - a) * r);
    }
  }
  return least;
}

/// Patches of all sizes and places about the eye: small and far, long and thin, around the eye.
Corners randomPatch(Random& random, int kind) {
  Corners v;
  const glm::dvec3 centre = random.vector() * (kind == 2 ? 0.05 : 3.0);
  const double size = std::pow(10.0, -4.0 + 5.0 * random.unit());
  const glm::dvec3 along = random.vector();
  for (glm::vec3& corner : v) {
    glm::dvec3 offset = random.vector() * size;
    if (kind == 1) offset = along * (random.normal() * 20.0) + offset * 0.01;
    corner = glm::vec3(centre + offset);
  }
  return v;
}

TEST(Eccentricity, NoPointOfThePatchIsNearer) {
  Random random;
  int positive = 0;
  for (int i = 0; i < 3000; ++i) {
    const Corners v = randomPatch(random, i % 3);
    const auto triangles = static_cast<glsl::uint>(1 + i / 3 % 3);
    const glm::dvec3 gaze = glm::normalize(random.vector());
    const double e = static_cast<double>(glsl::eccentricity(coneOf(v, triangles), glm::vec3(gaze)));
    // 2e-6 rad: some ulps of an angle of up to half a turn.
    ASSERT_LE(e, nearest(v, triangles, gaze, random) + 2e-6) << "patch " << i;
    positive += e > 0.0 ? 1 : 0;
  }
  EXPECT_GT(positive, 1000) << "a bound of 0 holds for everything and says nothing";
}

TEST(Eccentricity, IsThePrintedFormulaInDouble) {
  Random random;
  for (int i = 0; i < 3000; ++i) {
    const Corners v = randomPatch(random, i % 3);
    const auto triangles = static_cast<glsl::uint>(1 + i / 3 % 3);
    const glm::dvec3 gaze = glm::normalize(random.vector());
    glm::dvec3 sum(0.0);
    for (std::size_t k = 0; k < triangles + 2; ++k) sum += glm::normalize(glm::dvec3(v[k]));
    double largest = 0.0;
    for (std::size_t k = 0; k < triangles + 2; ++k)
      largest = std::max(largest, angleOf(sum, glm::dvec3(v[k])));
    // The mean of corners that nearly cancel has no digits in float.
    if (glm::length(sum) < 0.1 || std::abs(largest - 1.5707963) < 1e-4) continue;
    const double expected = largest < 1.5707963 ? std::max(angleOf(sum, gaze) - largest, 0.0) : 0.0;
    ASSERT_NEAR(static_cast<double>(glsl::eccentricity(coneOf(v, triangles), glm::vec3(gaze))), expected,
                2e-5)
        << "patch " << i;
  }
}

// Corners a little more than a quarter turn from their mean, with the gaze between two of them: the printed
// formula gives 80 degrees, though the patch is right there.
TEST(Eccentricity, APatchAroundTheEyeIsEverywhere) {
  const double turn = 100.0 / kDegrees;
  const float below = -0.01f;
  const Corners v = {glm::vec3(1, 0, below), glm::vec3(std::cos(turn), std::sin(turn), below),
                     glm::vec3(std::cos(turn), -std::sin(turn), below)};
  EXPECT_EQ(glsl::eccentricity(coneOf(v, 1), glm::vec3(-1, 0, 0)), 0.0f);
  EXPECT_EQ(glsl::eccentricity(coneOf(v, 1), glm::vec3(0, 0, -1)), 0.0f);
}

TEST(Eccentricity, IsTotal) {
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const glm::vec3 gaze(0, 0, -1);
  for (const glm::vec3 odd :
       {glm::vec3(0), glm::vec3(nan), glm::vec3(infinity, 0, 0), glm::vec3(0, -infinity, nan)})
    for (std::size_t corner = 0; corner < 5; ++corner) {
      Corners v = {glm::vec3(1, 0, 1), glm::vec3(2, 0, 1), glm::vec3(2, 1, 1), glm::vec3(1, 1, 1),
                   glm::vec3(1, 0.5f, 1)};
      v[corner] = odd;
      EXPECT_EQ(glsl::eccentricity(coneOf(v, 3), gaze), 0.0f)
          << "a bad corner " << corner << " counts as seen";
    }
  // Corners that cancel, and lengths whose squares do not exist in float.
  EXPECT_EQ(glsl::eccentricity(
                coneOf({glm::vec3(1, 0, 0), glm::vec3(-1, 0, 0), glm::vec3(1, 0, 0), glm::vec3(-1, 0, 0)}, 2),
                gaze),
            0.0f);
  for (const float scale : {1e-30f, 1e30f}) {
    const Corners v = {glm::vec3(1, 0, 0) * scale, glm::vec3(1, 0.1f, 0) * scale,
                       glm::vec3(1, 0.1f, 0.1f) * scale};
    EXPECT_NEAR(glsl::eccentricity(coneOf(v, 1), gaze), 1.5f, 0.1f) << scale;
  }
  glsl::DensityGpu density{};
  density.gaze = density.axis = glm::vec4(nan);
  density.acuity = density.lens = glm::vec4(nan);
  const glsl::Cone cone = coneOf({glm::vec3(1, 0, 0), glm::vec3(1, 1, 0), glm::vec3(1, 1, 1)}, 1);
  EXPECT_EQ(glsl::logAcuity(density, cone), 0.0f);
  EXPECT_EQ(glsl::logLens(density, cone), 0.0f);
}

TEST(Acuity, ScaleByHand) {
  // 1080 pixels over 60 degrees: 18 a degree, a cycle is 1/9 of a degree.
  const float cycle = glsl::degreesPerCycle(1080.0f * static_cast<float>(kDegrees) / 60.0f);
  EXPECT_NEAR(cycle, 1.0 / 9.0, 1e-7);
  const auto scale = [&](double e) {
    return static_cast<double>(glsl::acuityScale(static_cast<float>(e), 0.022f, 1.0f / 48.0f, cycle));
  };
  // The eye is better than this display up to (1/9 - 1/48) / 0.022 = 4.10 degrees: nothing to gain from more.
  EXPECT_EQ(scale(0.0), 1.0);
  EXPECT_EQ(scale(4.1), 1.0);
  EXPECT_GT(scale(4.2), 1.0);
  EXPECT_NEAR(scale(30.0), 6.1275, 1e-5);  // (0.66 + 0.0208333) * 9
}

TEST(Acuity, BothFactorsMultiply) {
  View view = lookAt({0, 0, 0}, {0, 0, -1}, 60.0, 1920, 1080, 0.1);
  PlaceOptions options{Foveation{{0.5, 0.5}}, Lens{}};
  const glsl::DensityGpu density = densityGpu(view, options);
  // A speck 38 degrees right of the centre.
  const double a = 38.0 / kDegrees;
  const glm::vec3 p(std::sin(a), 0.0, -std::cos(a));
  const glsl::Cone cone = coneOf({p, p * 1.001f, p * 1.002f}, 1);
  EXPECT_NEAR(glsl::logAcuity(density, cone), -2.0 * std::log2(7.7115), 1e-4);  // (0.836 + 0.0208333) * 9
  // The corner's tangent is tan 30 * hypot(1, 16/9), and the undistorted radius there 1.46.
  const double n = 1.46 * std::tan(a) / (std::tan(30.0 / kDegrees) * std::hypot(1.0, 16.0 / 9.0));
  double d = n;
  for (int i = 0; i < 200; ++i) d = n / (1.0 + 0.22 * d * d + 0.24 * d * d * d * d) * 0.5 + d * 0.5;
  const double slope = 1.0 + 0.66 * d * d + 1.2 * d * d * d * d;
  EXPECT_NEAR(glsl::logLens(density, cone), std::log2(1.46 * 1.014 / 0.996 / slope), 1e-4);
  // In the middle neither takes anything.
  const glm::vec3 ahead(0, 0, -1);
  const glsl::Cone middle = coneOf({ahead, ahead * 1.1f, ahead * 1.2f}, 1);
  EXPECT_EQ(glsl::logAcuity(density, middle), 0.0f);
  EXPECT_EQ(glsl::logLens(density, middle), 0.0f);
}

TEST(Gaze, IsTheDirectionOfItsPlace) {
  const View view = lookAt({1, 2, 3}, {4, -1, -2}, 75.0, 640, 480, 0.1);
  for (const glm::dvec2 place : {glm::dvec2(0.5, 0.5), glm::dvec2(0.1, 0.8), glm::dvec2(1.0, 0.0)}) {
    const glm::dvec4 clip =
        viewProjection(view, {0, 0, 0}) * glm::dvec4(view.eye + gazeDirection(view, place) * 5.0, 1.0);
    EXPECT_NEAR(clip.x / clip.w * 0.5 + 0.5, place.x, 1e-9);
    EXPECT_NEAR(0.5 - clip.y / clip.w * 0.5, place.y, 1e-9);
  }
}

TEST(Stereo, EyesAreParallelAndApart) {
  const View centre = lookAt({1, 2, 3}, {4, -1, -2}, 75.0, 640, 480, 0.1);
  const auto eyes = stereoViews(centre, 0.064);
  EXPECT_NEAR(glm::length(eyes[1].eye - eyes[0].eye), 0.064, 1e-12);
  EXPECT_NEAR(glm::length((eyes[0].eye + eyes[1].eye) * 0.5 - centre.eye), 0.0, 1e-12);
  for (const View& eye : eyes) EXPECT_EQ(eye.forward, centre.forward);
  // The right eye is to the right: what is ahead of the centre lies left of its middle.
  const glm::dvec4 clip =
      viewProjection(eyes[1], {0, 0, 0}) * glm::dvec4(centre.eye + centre.forward * 2.0, 1.0);
  EXPECT_LT(clip.x / clip.w, -1e-3);
  EXPECT_NEAR(clip.y / clip.w, 0.0, 1e-12);
}

// ---- lens ----

const std::array<glm::dvec2, 6> kLenses = {glm::dvec2(0.22, 0.24), {0.0, 0.0},  {1.0, 0.5},
                                           {-0.2, 0.05},           {0.5, -0.2}, {10.0, 10.0}};

TEST(LensFormula, DistortionAndItsInverseMeet) {
  for (const glm::dvec2 k : kLenses) {
    Lens lens;
    lens.k1 = k.x;
    lens.k2 = k.y;
    ASSERT_TRUE(check(lens)) << check(lens).error().message;
    const auto k1 = static_cast<float>(k.x);
    const auto k2 = static_cast<float>(k.y);
    float previous = -1.0f;
    for (int i = 0; i <= 1000; ++i) {
      const float d = static_cast<float>(i) / 1000.0f;
      const float u = glsl::lensUndistort(d, k1, k2);
      EXPECT_NEAR(u, d * (1.0 + k.x * d * d + k.y * d * d * d * d), 1e-6 * (1.0 + k.x + k.y));
      EXPECT_GT(u, previous) << "not monotonic";
      previous = u;
      ASSERT_NEAR(glsl::lensDistort(u, k1, k2), d, 1e-6) << "k " << k.x << ", " << k.y;
      // And the other way round, over the same range.
      const float corner = glsl::lensUndistort(1.0f, k1, k2);
      ASSERT_NEAR(glsl::lensUndistort(glsl::lensDistort(d * corner, k1, k2), k1, k2), d * corner,
                  1e-6f * std::fmax(1.0f, corner));
      // The slope is that of the secant.
      const double step = 1e-4;
      const auto exact = [&](double x) { return x * (1.0 + k.x * x * x + k.y * x * x * x * x); };
      EXPECT_NEAR(glsl::lensSlope(d, k1, k2), (exact(d + step) - exact(d - step)) / (2.0 * step),
                  1e-5 * (1.0 + 5.0 * (std::abs(k.x) + std::abs(k.y))));
    }
    EXPECT_EQ(glsl::lensDistort(100.0f, k1, k2), 1.0f);
    EXPECT_EQ(glsl::lensDistort(-1.0f, k1, k2), 0.0f);
  }
}

TEST(LensFormula, FoldsAndBadNumbersAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto message = [](double k1, double k2) {
    Lens lens;
    lens.k1 = k1;
    lens.k2 = k2;
    const auto checked = check(lens);
    return checked ? std::string() : checked.error().message;
  };
  for (const glm::dvec2 k : {glm::dvec2(-0.5, 0.0), glm::dvec2(0.0, -0.3), glm::dvec2(-1.5, 0.9)}) {
    const std::string text = message(k.x, k.y);
    EXPECT_NE(text.find("fold"), std::string::npos) << k.x << ", " << k.y;
    EXPECT_NE(text.find(fmt::format("k1 {}", k.x)), std::string::npos) << text;
    // It does fold: somewhere the radius falls.
    double least = 1.0;
    for (int i = 0; i < 1000; ++i) {
      const auto u = [&](double d) { return d * (1.0 + k.x * d * d + k.y * d * d * d * d); };
      least = std::min(least, u((i + 1) / 1000.0) - u(i / 1000.0));
    }
    EXPECT_LT(least, 0.0) << k.x << ", " << k.y;
  }
  EXPECT_NE(message(nan, 0.0).find("k1"), std::string::npos);
  EXPECT_NE(message(0.0, 1e9).find("k2"), std::string::npos);
  Lens fringe;
  fringe.channelScale.z = nan;
  ASSERT_FALSE(check(fringe));
  EXPECT_NE(check(fringe).error().message.find("channel 2"), std::string::npos);
}

// How closely the printed eq. 4.5 meets the ratio that it was fitted to. Cut to 1 it is good to 0.005 up to n
// = 0.9; rounding its coefficients costs 0.015 at the end of the fitted range, n = 1.46, and it is of no use
// past 2.2.
TEST(LensFormula, ThePrintedPolynomialIsTheRoundedInverse) {
  double within = 0.0;
  double overRange = 0.0;
  for (int i = 1; i <= 1460; ++i) {
    const float n = static_cast<float>(i) / 1000.0f;
    const double error = std::abs(static_cast<double>(glsl::lensScaleAsPrinted(n)) -
                                  static_cast<double>(glsl::lensDistort(n, 0.22f, 0.24f) / n));
    (i <= 900 ? within : overRange) = std::max(i <= 900 ? within : overRange, error);
  }
  EXPECT_LT(within, 0.005);
  EXPECT_GT(within, 0.003);
  EXPECT_LT(overRange, 0.0155);
  EXPECT_GT(overRange, 0.014);
  EXPECT_EQ(glsl::lensScaleAsPrinted(0.001f), 1.0f) << "5.4e-4 / n passes 1 near the centre";
  EXPECT_NEAR(glsl::lensScaleAsPrinted(1.0f), 0.81054, 1e-6);
}

/// Pixels of the picture that meet in an output pixel, along the output's radius and across it, at output
/// place `at` (pixels from the centre), for a channel: by differences of the documented mapping of Lens.
glm::dvec2 pressedAt(const Lens& lens, const View& view, const glm::dvec2& at, int channel) {
  const double half = 0.5 * std::hypot(view.width, view.height);
  const auto from = [&](const glm::dvec2& place) {
    const double d2 = glm::dot(place, place) / (half * half);
    return place * (lens.channelScale[channel] * (1.0 + lens.k1 * d2 + lens.k2 * d2 * d2) / lensFill(lens));
  };
  const glm::dvec2 outward = glm::normalize(at);
  const glm::dvec2 around(-outward.y, outward.x);
  const auto reach = [&](const glm::dvec2& step) { return glm::length(from(at + step) - from(at - step)); };
  return {reach(outward * 0.5), reach(around * 0.5)};
}

TEST(LensFormula, NoPatchGetsLessThanDisplayShowsOfIt) {
  Random random;
  for (const glm::dvec2 k : kLenses)
    for (const bool fringed : {false, true})
      for (const double fovY : {40.0, 75.0, 100.0}) {
        Lens lens;
        lens.k1 = k.x;
        lens.k2 = k.y;
        lens.channelScale = fringed ? glm::dvec3(0.97, 1.0, 1.03) : glm::dvec3(1.0);
        const View view = lookAt({0, 0, 0}, {0, 0, -1}, fovY, 960, 540, 0.1);
        const glsl::DensityGpu density = densityGpu(view, {{}, lens});
        double excess = 0.0;
        int counted = 0;
        for (int i = 0; i < 400; ++i) {
          // A pair of the size of some pixels to a quarter of the picture, anywhere on it.
          const glm::dvec2 place(random.unit() * view.width, random.unit() * view.height);
          const double size = std::exp2(2.0 + 6.0 * random.unit());
          const auto onPicture = [&](double x, double y) {
            return glm::vec3(pixelToRay(view) * glm::dvec3(1.0, place.x + x * size, place.y + y * size));
          };
          const Corners v = {onPicture(0, 0), onPicture(1, 0), onPicture(1, 1), onPicture(0, 1)};
          const double share = std::exp2(static_cast<double>(glsl::logLens(density, coneOf(v, 2))));
          double shown = 0.0;
          const double half = 0.5 * std::hypot(view.width, view.height);
          for (int channel = 0; channel < 3; ++channel)
            for (int y = 0; y <= 8; ++y)
              for (int x = 0; x <= 8; ++x) {
                const glm::dvec2 from =
                    place + glm::dvec2(x, y) * (size / 8.0) - 0.5 * glm::dvec2(view.width, view.height);
                const double n = glm::length(from) / half * lensFill(lens) / lens.channelScale[channel];
                // What lies outside of the picture, or of the output's corners, is not shown.
                if (std::abs(from.x) > 0.5 * view.width || std::abs(from.y) > 0.5 * view.height) continue;
                const auto n32 = static_cast<float>(n);
                const auto k1 = static_cast<float>(k.x);
                const auto k2 = static_cast<float>(k.y);
                if (n < 1e-3 || n > 1.0 + k.x + k.y) continue;
                const glm::dvec2 at =
                    glm::normalize(from) * (half * static_cast<double>(glsl::lensDistort(n32, k1, k2)));
                const glm::dvec2 pressed = glm::max(pressedAt(lens, view, at, channel), glm::dvec2(1.0));
                shown = std::max(shown, 1.0 / (pressed.x * pressed.y));
              }
          if (shown == 0.0) continue;
          ASSERT_GE(share, shown * 0.9999) << "k " << k.x << ", " << k.y << ", fov " << fovY << ", patch of "
                                           << size << " pixels at " << place.x << ", " << place.y;
          if (fringed || size > 16.0) continue;
          excess += share / shown;
          ++counted;
        }
        // Nor much more: small patches get what they show, but for what the channels differ by.
        if (!fringed) {
          EXPECT_GT(counted, 80);
          EXPECT_LT(excess / counted, 1.04) << "k " << k.x << ", " << k.y << ", fov " << fovY;
        }
      }
}

TEST(LensFormula, ShareByHand) {
  const auto share = [](float nearest, float farthest, float fill) {
    return static_cast<double>(glsl::lensShare(nearest, farthest, 0.22f, 0.24f, fill));
  };
  // At d = 1 the slope is 1 + 0.66 + 1.2 and the ratio of radii 1.46; at the centre both are 1.
  EXPECT_NEAR(share(1.46f, 1.46f, 1.46f), 1.46 / 2.86, 1e-6);
  EXPECT_NEAR(share(1.46f, 1.46f, 1.0f), 1.0 / (2.86 * 1.46), 1e-6);
  EXPECT_EQ(share(0.0f, 1.46f, 1.46f), 1.0) << "a patch that reaches the centre is seen as it is there";
  EXPECT_NEAR(share(50.0f, 60.0f, 1.46f), 1.46 / 2.86, 1e-6) << "past the corner as at the corner";
  // 1 - 1.2 q + q^2 is least inside, at q = 0.6: 0.64.
  EXPECT_NEAR(glsl::leastOver(0.0f, 1.0f, -1.2f, 1.0f), 0.64, 1e-6);
  EXPECT_NEAR(glsl::leastOver(0.7f, 1.0f, -1.2f, 1.0f), 0.65, 1e-6);
  EXPECT_NEAR(glsl::leastOver(0.0f, 1.0f, -0.6f, -0.2f), 0.2, 1e-6);
}

}  // namespace
}  // namespace tessera
