// Foveation, lens and stereo on placed scenes.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "engine/frame/engine.hpp"
#include "glsl/shared/bindings.h"
#include "glsl/shared/blocks.h"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using Spatial = test::GlTest;

constexpr int kWidth = 480;
constexpr int kHeight = 270;

/// A wall 2 m ahead that fills the view and more, in small even patches.
Scene wallScene(int cells = 0) {
  Scene scene = test::emptyScene();
  Material material;
  material.unlit = true;
  if (cells > 0) material.baseColor.image = test::addCheckers(scene, 1024, cells);
  const auto index = test::addMaterial(scene, material);
  test::place(scene, test::addGrid(scene, {-4, -3, -2}, {8, 0, 0}, {0, 6, 0}, 48, 36, index));
  test::finish(scene);
  return scene;
}

View wallView() { return lookAt({0, 0, 0}, {0, 0, -2}, 75.0, kWidth, kHeight, 0.05); }

std::unique_ptr<Engine> make(Scene scene, bool lens = false) {
  EngineOptions options;
  options.atlas.memory.width = options.atlas.memory.height = 1024;
  options.atlas.memory.pressureBias = false;
  options.splitEdges = 0.0;
  options.request.lens = lens;
  auto engine = Engine::create(test::context(), std::move(scene), {}, options);
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return nullptr;
  }
  (*engine)->update(0.0);
  return std::move(*engine);
}

/// An eye that is worse than this small display at once: a share of 1 at the gaze only.
Foveation shortSighted(glm::dvec2 gaze) { return {gaze, 0.05, 0.5}; }

/// log2 of the texels of each visible patch.
std::map<std::uint32_t, int> levelsOf(Engine& engine, std::span<const View> views,
                                      const PlaceOptions& options = {}) {
  engine.atlas()->memory().reset();
  engine.findVisible(views);
  const auto placed = engine.place(views, options);
  EXPECT_TRUE(placed) << placed.error().message;
  const auto states =
      engine.atlas()->memory().patchStates().readAll<glsl::PatchState>(engine.drawScene().patchInstances);
  std::map<std::uint32_t, int> levels;
  for (const std::uint32_t patch : engine.visibleSet()->read())
    levels[patch] =
        static_cast<int>(glsl::levelWidth(states[patch].level) + glsl::levelHeight(states[patch].level));
  EXPECT_EQ(engine.atlas()->memory().readStatistics().failures, 0u);
  return levels;
}

std::vector<float> measuresOf(Engine& engine, const View& view, const PlaceOptions& options) {
  levelsOf(engine, {&view, 1}, options);
  const auto ids = engine.visibleSet()->read();
  const auto measures = engine.atlas()->memory().measures().readAll<glsl::PatchMeasure>(ids.size());
  std::vector<float> byPatch(engine.drawScene().patchInstances, 0.0f);
  for (std::size_t i = 0; i < ids.size(); ++i) byPatch[ids[i]] = measures[i].logArea;
  return byPatch;
}

/// The corners of a patch of the wall, relative to the eye at the origin.
std::array<glm::vec3, 5> cornersOf(const Engine& engine, std::uint32_t patch) {
  const glsl::PatchGeometry& g = engine.drawScene().patches[patch];
  const auto& p = engine.scene().vertices.position;
  return {p[g.v0], p[g.v1], p[g.v2], p[g.v3], p[g.v4]};
}

double eccentricityOf(const Engine& engine, std::uint32_t patch, const glm::dvec3& gaze) {
  const auto v = cornersOf(engine, patch);
  const glsl::PatchGeometry& g = engine.drawScene().patches[patch];
  return static_cast<double>(
      glsl::eccentricity(glsl::coneOfPatch(v[0], v[1], v[2], v[3], v[4], g.triangles), glm::vec3(gaze)));
}

TEST_F(Spatial, OffIsBitIdenticalAndMakesNothing) {
  auto engine = make(wallScene());
  ASSERT_TRUE(engine);
  const View view = wallView();
  const std::size_t programs = engine->permutations().size();
  const auto before = measuresOf(*engine, view, {});
  EXPECT_EQ(engine->permutations().size(), programs);
  const auto foveated = measuresOf(*engine, view, {.foveation = shortSighted({0.5, 0.5})});
  EXPECT_EQ(engine->permutations().size(), programs + 1) << "compiled at first use";
  EXPECT_NE(before, foveated);
  EXPECT_EQ(before, measuresOf(*engine, view, {})) << "something of foveation stayed on";
  for (const std::string& name : engine->permutations())
    EXPECT_EQ(name.find("LENS"), std::string::npos) << name;
  EXPECT_FALSE(engine->distort(Lens{})) << "the plan has no lens";
}

TEST_F(Spatial, MeasuresDropByTheSharedFormula) {
  auto engine = make(wallScene());
  ASSERT_TRUE(engine);
  const View view = wallView();
  const auto plain = measuresOf(*engine, view, {});
  for (const PlaceOptions& options : {PlaceOptions{shortSighted({0.2, 0.7}), {}}, PlaceOptions{{}, Lens{}},
                                      PlaceOptions{shortSighted({0.2, 0.7}), Lens{}}}) {
    const auto reduced = measuresOf(*engine, view, options);
    const glsl::DensityGpu density = densityGpu(view, options);
    float largest = 0.0f;
    for (const std::uint32_t patch : engine->visibleSet()->read()) {
      const auto v = cornersOf(*engine, patch);
      const glsl::Cone cone =
          glsl::coneOfPatch(v[0], v[1], v[2], v[3], v[4], engine->drawScene().patches[patch].triangles);
      const float factor = (options.foveation ? glsl::logAcuity(density, cone) : 0.0f) +
                           (options.lens ? glsl::logLens(density, cone) : 0.0f);
      ASSERT_NEAR(reduced[patch] - plain[patch], factor, 2e-4f) << "patch " << patch;
      largest = std::max(largest, -factor);
    }
    EXPECT_GT(largest, 0.5f);
  }
}

TEST_F(Spatial, LevelsFallWithEccentricity) {
  auto engine = make(wallScene());
  ASSERT_TRUE(engine);
  const View view = wallView();
  const auto plain = levelsOf(*engine, {&view, 1});
  const Foveation foveation = shortSighted({0.3, 0.4});
  const auto reduced = levelsOf(*engine, {&view, 1}, {.foveation = foveation});
  ASSERT_EQ(plain.size(), reduced.size());
  const glm::dvec3 gaze = gazeDirection(view, foveation.gaze);
  // Rounded levels, averaged over rings of ten degrees.
  std::array<double, 12> drop{};
  std::array<int, 12> count{};
  for (const auto& [patch, level] : plain) {
    EXPECT_LE(reduced.at(patch), level) << "foveation enlarged a patch";
    const auto ring = static_cast<std::size_t>(eccentricityOf(*engine, patch, gaze) * 57.29578 / 10.0);
    ASSERT_LT(ring, drop.size());
    drop[ring] += level - reduced.at(patch);
    ++count[ring];
  }
  double previous = -1.0;
  int rings = 0;
  for (std::size_t ring = 0; ring < drop.size(); ++ring) {
    if (count[ring] < 10) continue;
    EXPECT_GT(drop[ring] / count[ring], previous) << "ring " << ring;
    previous = drop[ring] / count[ring];
    ++rings;
  }
  EXPECT_GE(rings, 4);
  EXPECT_GT(previous, 2.0);
}

TEST_F(Spatial, EachViewHasItsOwnGaze) {
  auto engine = make(wallScene());
  ASSERT_TRUE(engine);
  const PlaceOptions options{.foveation = shortSighted({0.5, 0.5})};
  const std::array<View, 2> views = {lookAt({0, 0, 0}, {-1.5, 0, -2}, 75.0, kWidth, kHeight, 0.05),
                                     lookAt({0, 0, 0}, {1.5, 0, -2}, 75.0, kWidth, kHeight, 0.05)};
  const auto left = levelsOf(*engine, {&views[0], 1}, options);
  const auto right = levelsOf(*engine, {&views[1], 1}, options);
  const auto both = levelsOf(*engine, views, options);
  int shared = 0;
  for (const auto& [patch, level] : both) {
    // Both eyes are at one place, so an area differs by the gaze only: the larger counts.
    const int wanted =
        std::max(left.count(patch) ? left.at(patch) : -1, right.count(patch) ? right.at(patch) : -1);
    if (left.count(patch) == 0 || right.count(patch) == 0) {
      // Seen by one view; the other's gaze still counts, and is farther or not.
      EXPECT_GE(level, wanted);
      continue;
    }
    EXPECT_EQ(level, wanted) << "patch " << patch;
    shared += left.at(patch) != right.at(patch) ? 1 : 0;
  }
  EXPECT_GT(shared, 20) << "the gazes made no difference";
}

TEST_F(Spatial, BadOptionsAreRefusedAndChangeNothing) {
  auto engine = make(wallScene());
  ASSERT_TRUE(engine);
  const View view = wallView();
  const auto before = levelsOf(*engine, {&view, 1});
  Foveation blind;
  blind.smallest = 0.0;
  Lens folded;
  folded.k1 = -3.0;
  for (const PlaceOptions& options : {PlaceOptions{blind, {}}, PlaceOptions{{}, folded}}) {
    const auto placed = engine->place({&view, 1}, options);
    ASSERT_FALSE(placed);
    EXPECT_FALSE(placed.error().message.empty());
  }
  Foveation nowhere;
  nowhere.gaze.y = std::nan("");
  EXPECT_FALSE(engine->place({&view, 1}, {.foveation = nowhere}));
  Foveation steep;
  steep.slope = -1.0;
  EXPECT_FALSE(engine->place({&view, 1}, {.foveation = steep}));
  const auto after = levelsOf(*engine, {&view, 1});
  EXPECT_EQ(before, after);
}

// ---- the display through the lens ----

double linearOf(std::uint8_t encoded) {
  const double c = encoded / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

double encodedOf(double linear) {
  return 255.0 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055);
}

/// The picture at a place in pixels, bilinear in linear light; 0 outside.
double sampleLinear(const Image& image, double x, double y, int channel) {
  if (x < 0.0 || y < 0.0 || x > image.width || y > image.height) return 0.0;
  const double fx = std::clamp(x - 0.5, 0.0, image.width - 1.0);
  const double fy = std::clamp(y - 0.5, 0.0, image.height - 1.0);
  const int x0 = std::min(static_cast<int>(fx), image.width - 2);
  const int y0 = std::min(static_cast<int>(fy), image.height - 2);
  const auto at = [&](int i, int j) {
    return channel == 3 ? image.at(i, j)[3] / 255.0 : linearOf(image.at(i, j)[channel]);
  };
  const double s = fx - x0;
  const double t = fy - y0;
  return (at(x0, y0) * (1 - s) + at(x0 + 1, y0) * s) * (1 - t) +
         (at(x0, y0 + 1) * (1 - s) + at(x0 + 1, y0 + 1) * s) * t;
}

/// What an output pixel of `size` shows of a picture, as large or larger, as a mean over 16 x 16 places in
/// it; nothing where the picture's border runs through the pixel, which few taps cannot tell.
std::optional<double> expectedPixel(const Image& image, const Lens& lens, int x, int y, int channel,
                                    glm::dvec2 size = {kWidth, kHeight}) {
  const double half = 0.5 * std::hypot(size.x, size.y);
  const double larger = image.width / size.x;
  const double scale = lens.channelScale[channel == 3 ? 1 : channel];
  const double fill =
      (1.0 + lens.k1 + lens.k2) * std::max({lens.channelScale.x, lens.channelScale.y, lens.channelScale.z});
  double sum = 0.0;
  int inside = 0;
  constexpr int kPlaces = 16;
  for (int j = 0; j < kPlaces; ++j)
    for (int i = 0; i < kPlaces; ++i) {
      const double px = x + (i + 0.5) / kPlaces - 0.5 * size.x;
      const double py = y + (j + 0.5) / kPlaces - 0.5 * size.y;
      const double d2 = (px * px + py * py) / (half * half);
      const double ratio = scale * (1.0 + lens.k1 * d2 + lens.k2 * d2 * d2) / fill;
      const double fromX = larger * (0.5 * size.x + px * ratio);
      const double fromY = larger * (0.5 * size.y + py * ratio);
      inside += fromX >= 0.0 && fromY >= 0.0 && fromX <= image.width && fromY <= image.height ? 1 : 0;
      sum += sampleLinear(image, fromX, fromY, channel);
    }
  if (inside > 0 && inside < kPlaces * kPlaces) return std::nullopt;
  return sum / (kPlaces * kPlaces);
}

TEST_F(Spatial, LensShowsThePictureByTheFormula) {
  auto engine = make(wallScene(32), true);
  ASSERT_TRUE(engine);
  const View view = wallView();
  engine->rect(view);
  const Image flat = engine->readColor();
  Lens strong;
  strong.k1 = 0.9;
  strong.k2 = 0.4;
  Lens pincushion{-0.2, 0.0, {1.0, 1.0, 1.0}};
  for (const Lens& lens : {Lens{}, strong, pincushion}) {
    ASSERT_TRUE(engine->distort(lens));
    const Image bent = engine->readColor();
    ASSERT_EQ(bent.width, kWidth);
    ASSERT_EQ(bent.height, kHeight);
    double worst = 0.0;
    double sum = 0.0;
    int count = 0;
    for (int y = 3; y < kHeight; y += 7)
      for (int x = 2; x < kWidth; x += 7)
        for (int c = 0; c < 3; ++c) {
          const auto expected = expectedPixel(flat, lens, x, y, c);
          if (!expected) continue;
          const double error = std::abs(encodedOf(*expected) - bent.at(x, y)[c]);
          worst = std::max(worst, error);
          sum += error;
          ++count;
        }
    // One to a few bilinear taps against a mean over the pixel: they differ at the edges of checkers only.
    EXPECT_GT(count, 7000) << lens.k1;
    EXPECT_LT(sum / count, 2.0) << lens.k1;
    std::printf("lens %.2f, %.2f: mean error %.3f, largest %.1f of 255\n", lens.k1, lens.k2, sum / count,
                worst);
    EXPECT_LT(worst, 48.0) << lens.k1;
    // Distorting is of the picture that was drawn, however often it is done.
    ASSERT_TRUE(engine->distort(lens));
    EXPECT_EQ(engine->readColor().pixels, bent.pixels);
  }
  engine->display(view);
  EXPECT_EQ(engine->readColor().pixels, flat.pixels) << "color() is the plain picture again";
}

// Cells of some two pixels, pressed together by half and more near the corners: a single tap a pixel would
// show whichever cell it meets.
TEST_F(Spatial, PressedPartsAreFiltered) {
  auto engine = make(wallScene(256), true);
  ASSERT_TRUE(engine);
  engine->rect(wallView());
  const Image flat = engine->readColor();
  const Lens strong{0.9, 0.4, {1.0, 1.0, 1.0}};
  ASSERT_TRUE(engine->distort(strong));
  const Image bent = engine->readColor();
  double sum = 0.0;
  int count = 0;
  for (int y = 0; y < kHeight; y += 3)
    for (int x = 0; x < kWidth / 8; x += 3) {
      const auto expected = expectedPixel(flat, strong, x, y, 1);
      ASSERT_TRUE(expected);
      sum += std::abs(encodedOf(*expected) - bent.at(x, y)[1]);
      ++count;
    }
  std::printf("pressed parts: mean error %.2f of 255\n", sum / count);
  EXPECT_LT(sum / count, 1.0);  // 1.6 with one tap
}

// Fine checkers through the lens, from an atlas that has fewer texels for it, against forward with 16 samples
// for each pixel of the picture, seen through the same lens: the texels that were left out are not missed,
// from the centre to the corners.
TEST_F(Spatial, TexelsThatTheLensLeavesOutAreNotMissed) {
  auto engine = make(wallScene(400), true);
  ASSERT_TRUE(engine);
  const View view = wallView();
  View large = view;
  large.width *= 4;
  large.height *= 4;
  engine->forward(large);
  const Image truth = engine->readColor();
  const Lens lens{0.5, 0.5, {1.0, 1.0, 1.0}};
  std::vector<std::optional<double>> expected;
  for (int y = 0; y < kHeight; y += 2)
    for (int x = 0; x < kWidth; x += 2) expected.push_back(expectedPixel(truth, lens, x, y, 1));
  constexpr std::size_t kRings = 4;
  struct Shown {
    std::array<double, kRings> error{};
    std::uint64_t texels = 0;
  };
  const auto shownWith = [&](const PlaceOptions& options, float fewer) {
    Shown shown;
    std::array<int, kRings> count{};
    RectMemoryOptions memory;
    memory.width = memory.height = 1024;
    memory.pressureBias = false;
    memory.bias = fewer;
    EXPECT_TRUE(engine->remakeAtlas(memory));
    levelsOf(*engine, {&view, 1}, options);
    engine->shade(view);
    engine->display(view);
    EXPECT_TRUE(engine->distort(lens));
    const Image bent = engine->readColor();
    std::size_t place = 0;
    for (int y = 0; y < kHeight; y += 2)
      for (int x = 0; x < kWidth; x += 2) {
        const auto& wanted = expected[place++];
        if (!wanted) continue;
        const double radius = std::hypot(x + 0.5 - kWidth / 2, y + 0.5 - kHeight / 2);
        const auto ring = static_cast<std::size_t>(kRings * radius / std::hypot(kWidth / 2, kHeight / 2));
        shown.error[ring] += std::abs(encodedOf(*wanted) - bent.at(x, y)[1]);
        ++count[ring];
      }
    for (std::size_t ring = 0; ring < kRings; ++ring) shown.error[ring] /= count[ring];
    shown.texels = engine->atlas()->memory().readStatistics().samples;
    return shown;
  };
  const Shown all = shownWith({}, 0.0f);
  const Shown lensed = shownWith({.lens = lens}, 0.0f);
  const Shown fewer = shownWith({}, static_cast<float>(std::log2(static_cast<double>(all.texels) /
                                                                 static_cast<double>(lensed.texels))));
  std::printf("texels %llu, with the lens %llu, everywhere fewer %llu\n",
              static_cast<unsigned long long>(all.texels), static_cast<unsigned long long>(lensed.texels),
              static_cast<unsigned long long>(fewer.texels));
  EXPECT_LT(lensed.texels, all.texels * 9 / 10);
  for (std::size_t ring = 0; ring < kRings; ++ring) {
    std::printf("ring %zu: error %.2f, with the lens %.2f, everywhere fewer %.2f of 255\n", ring,
                all.error[ring], lensed.error[ring], fewer.error[ring]);
    // By levels that fall where nothing is pressed, or by (d / n)^2, rings lose 3 % and more.
    EXPECT_LT(lensed.error[ring], 1.02 * all.error[ring]) << "ring " << ring;
  }
  EXPECT_GT(fewer.error[2], 1.04 * all.error[2]) << "checkers that a tenth fewer texels show as well";
}

TEST_F(Spatial, WithoutALensEveryPixelStays) {
  auto engine = make(wallScene(32), true);
  ASSERT_TRUE(engine);
  engine->rect(wallView());
  const Image flat = engine->readColor();
  ASSERT_TRUE(engine->distort({0.0, 0.0, {1.0, 1.0, 1.0}}));
  const Image same = engine->readColor();
  int largest = 0;
  for (std::size_t i = 0; i < flat.pixels.size(); ++i)
    largest = std::max(largest, std::abs(int{flat.pixels[i]} - int{same.pixels[i]}));
  // Places are computed from the centre outwards: some 1e-5 of a pixel aside, and decoded and encoded once.
  EXPECT_LE(largest, 1);
}

TEST_F(Spatial, ABarrelFillsTheOutputAndAPincushionLeavesBlack) {
  auto engine = make(wallScene(32), true);
  ASSERT_TRUE(engine);
  engine->rect(wallView());
  const auto holes = [&](const Lens& lens) {
    EXPECT_TRUE(engine->distort(lens));
    const Image image = engine->readColor();
    std::size_t count = 0;
    for (std::size_t i = 3; i < image.pixels.size(); i += 4) {
      if (image.pixels[i] != 0) continue;
      ++count;
      EXPECT_EQ(image.pixels[i - 1], 0) << "outside is black";
    }
    return count;
  };
  EXPECT_EQ(holes({}), 0u);
  // Half the width, 0.8716 of the half diagonal, shows 0.8716 * (1 - 0.2 * 0.7597) / 0.8 = 0.924: outside.
  EXPECT_GT(holes({-0.2, 0.0, {1.0, 1.0, 1.0}}), 1000u);
}

// A vertical line right of the middle bends outward in its middle under barrel distortion: the rows at the
// top and bottom are nearer to the middle of the picture.
TEST_F(Spatial, StraightLinesBendOutward) {
  Scene scene = test::emptyScene();
  Material white;
  white.unlit = true;
  const auto index = test::addMaterial(scene, white);
  test::place(scene, test::addGrid(scene, {0.8f, -3, -2}, {4, 0, 0}, {0, 6, 0}, 4, 8, index));
  test::finish(scene);
  auto engine = make(std::move(scene), true);
  ASSERT_TRUE(engine);
  engine->rect(wallView());
  const auto edge = [&](int y, int channel) {
    const Image image = engine->readColor();
    for (int x = 0; x < kWidth; ++x)
      if (image.at(x, y)[channel] > 128) return x;
    return kWidth;
  };
  const int straight = edge(kHeight / 2, 1);
  EXPECT_NEAR(edge(2, 1), straight, 1);
  Lens lens;
  lens.channelScale = {0.95, 1.0, 1.05};
  ASSERT_TRUE(engine->distort(lens));
  EXPECT_GT(edge(kHeight / 2, 1), edge(2, 1) + 5);
  EXPECT_NEAR(edge(2, 1), edge(kHeight - 3, 1), 1) << "the same above and below";
  // A larger scale looks farther out, so it meets the line sooner.
  EXPECT_LT(edge(kHeight / 2, 2), edge(kHeight / 2, 1));
  EXPECT_LT(edge(kHeight / 2, 1), edge(kHeight / 2, 0));
}

TEST_F(Spatial, LensWorksOnForwardPictures) {
  EngineOptions options;
  options.request = {.forward = true, .lens = true};
  auto engine = Engine::create(test::context(), wallScene(32), {}, options);
  ASSERT_TRUE(engine) << engine.error().message;
  const auto early = (*engine)->distort({});
  ASSERT_FALSE(early);
  EXPECT_NE(early.error().message.find("no picture"), std::string::npos);
  (*engine)->update(0.0);
  (*engine)->forward(wallView());
  const Image flat = (*engine)->readColor();
  ASSERT_TRUE((*engine)->distort({}));
  EXPECT_NE((*engine)->readColor().pixels, flat.pixels);
}

// ---- stereo ----

/// A wall behind a board that hides other parts of it from either eye, glossy under a lamp.
Scene stereoScene() {
  Scene scene = test::emptyScene();
  Material gloss;
  gloss.roughnessFactor = 0.2f;
  const auto index = test::addMaterial(scene, gloss);
  test::place(scene, test::addGrid(scene, {-4, -3, -4}, {8, 0, 0}, {0, 6, 0}, 40, 30, index));
  test::place(scene, test::addGrid(scene, {-0.3f, -0.4f, -1}, {0.6f, 0, 0}, {0, 0.8f, 0}, 4, 4, index));
  test::finish(scene);
  return scene;
}

TEST_F(Spatial, AStereoPairIsShadedOnceAndHasNoHoles) {
  Stage stage;
  StageLight lamp;
  lamp.light.type = LightType::Point;
  lamp.keys.push_back({0.0, {0.5, 0.5, 0.0}, {0, 0, 0}, glm::vec3(1.0f), 30.0f});
  stage.lights.push_back(lamp);
  EngineOptions options;
  options.atlas.memory.width = options.atlas.memory.height = 1024;
  options.splitEdges = 0.0;
  options.timePasses = true;
  options.countFragments = true;
  auto made = Engine::create(test::context(), stereoScene(), stage, options);
  ASSERT_TRUE(made) << made.error().message;
  Engine& engine = **made;
  engine.update(0.0);
  const View centre = wallView();
  const auto eyes = stereoViews(centre, 0.2);

  // Each eye sees parts of the wall that the other does not.
  std::array<std::vector<std::uint32_t>, 2> seen;
  for (std::size_t i = 0; i < 2; ++i) {
    engine.findVisible({&eyes[i], 1});
    seen[i] = engine.visibleSet()->read();
    std::sort(seen[i].begin(), seen[i].end());
  }
  std::vector<std::uint32_t> onlyOne;
  std::set_symmetric_difference(seen[0].begin(), seen[0].end(), seen[1].begin(), seen[1].end(),
                                std::back_inserter(onlyOne));
  EXPECT_GT(onlyOne.size(), 10u);

  engine.clearTimes();
  engine.findVisible(eyes);
  ASSERT_TRUE(engine.place(eyes));
  engine.shade(centre);
  const std::uint64_t shaded = engine.samplesPassed();
  std::array<Image, 2> shown;
  for (std::size_t i = 0; i < 2; ++i) {
    engine.display(eyes[i]);
    shown[i] = engine.readColor();
  }
  const auto runs = [&](const char* name) {
    return std::count_if(engine.times().begin(), engine.times().end(),
                         [&](const PassTime& t) { return t.name == name; });
  };
  EXPECT_EQ(runs("id"), test::context().info().vertexLayers ? 1 : 2);
  EXPECT_EQ(runs("levels"), 1);
  EXPECT_EQ(runs("gather"), 1);
  EXPECT_EQ(runs("display"), 2);
  EXPECT_EQ(shaded, engine.atlas()->memory().readStatistics().samples) << "each texel of the pair once";

  std::size_t pixels = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    engine.forward(eyes[i]);
    const Image forward = engine.readColor();
    std::size_t holes = 0;
    for (std::size_t k = 3; k < forward.pixels.size(); k += 4) {
      pixels += forward.pixels[k] > 0 ? 1 : 0;
      holes += forward.pixels[k] > 0 && shown[i].pixels[k] == 0 ? 1 : 0;
    }
    EXPECT_EQ(holes, 0u) << "eye " << i;
    // A texel that was never shaded would be black, where everything here is lit.
    std::size_t black = 0;
    for (std::size_t k = 0; k < forward.pixels.size(); k += 4)
      black += forward.pixels[k + 1] > 40 && shown[i].pixels[k + 1] < 10 ? 1 : 0;
    EXPECT_EQ(black, 0u) << "eye " << i;
  }
  EXPECT_LT(static_cast<double>(shaded), 0.8 * static_cast<double>(pixels));
}

/// Standard deviation of a picture's green, in linear light.
double contrastOf(const Image& image) {
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 1; i < image.pixels.size(); i += 4) {
    const double encoded = static_cast<double>(image.pixels[i]) / 255.0;
    const double value = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
    sum += value;
    squares += value * value;
  }
  const auto pixels = static_cast<double>(image.pixels.size() / 4);
  return std::sqrt(squares / pixels - sum / pixels * (sum / pixels));
}

TEST_F(Spatial, TextureBiasMovesTheMipLevelByAsMuch) {
  // Checkers of a texel each: mip 0 has all contrast, mip 1 has none, and what lies between is linear.
  // Shading samples lie sqrt(2) texels apart, half-way between the two, since corners are the centres of a
  // block's outermost texels (but for the margin that gather draws more).
  constexpr int kTexels = 256;
  constexpr int kPatches = 24;
  constexpr int kBlock = 128;
  Scene scene = test::emptyScene();
  Material material;
  material.unlit = true;
  material.baseColor.image = test::addCheckers(scene, kTexels, kTexels);
  const auto index = test::addMaterial(scene, material);
  test::place(scene, test::addGrid(scene, {-4, -4, -2}, {8, 0, 0}, {0, 8, 0}, kPatches, kPatches, index));
  for (glm::vec2& uv : scene.vertices.uv0)
    uv *= std::sqrt(2.0) * (kBlock - 1 + 2.0 * static_cast<double>(glsl::kGatherMargin)) * kPatches / kTexels;
  test::finish(scene);
  auto engine = make(std::move(scene));
  ASSERT_TRUE(engine);
  const View view = lookAt({0, 0, 0}, {0, 0, -2}, 20.0, kWidth, kHeight, 0.05);
  for (const auto& [patch, level] : levelsOf(*engine, {&view, 1})) ASSERT_EQ(1 << level, kBlock * kBlock);
  const auto contrastAt = [&](float bias) {
    engine->shade(view, {.textureBias = bias});
    engine->display(view);
    return contrastOf(engine->readColor());
  };
  const double all = contrastAt(-2.0f);
  EXPECT_GT(all, 0.05);
  for (const float bias : {-0.4f, -0.25f, 0.0f, 0.25f, 0.4f})
    EXPECT_NEAR(contrastAt(bias) / all, 0.5 - static_cast<double>(bias), 0.04) << bias;
  EXPECT_NEAR(contrastAt(1.0f) / all, 0.0, 0.04);

  EXPECT_EQ(contrastAt(-9.0f), all) << "not cut to -2";
  EXPECT_EQ(contrastAt(9.0f), contrastAt(1.0f)) << "not cut to 1";
  EXPECT_EQ(contrastAt(std::numeric_limits<float>::quiet_NaN()), contrastAt(0.0f));
}

}  // namespace
}  // namespace tessera
