// The tessellation gatherer end to end on scenes made in code: against forward, against itself by every way
// to spawn samples, and on triangles that are hard to sample.
#include <array>
#include <cmath>
#include <cstring>
#include <set>

#include "engine/frame/engine.hpp"
#include "engine/measure/metrics.hpp"
#include "glsl/shared/tess_atlas.h"
#include "tests/frame/pictures.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using TessFrame = test::GlTest;
using test::blackenAtlas;
using test::countCovered;
using test::darkPixels;
using test::largestDifference;
using test::meanDifference;

constexpr int kWidth = 320;
constexpr int kHeight = 240;

TessAtlasOptions tessAtlas(AtlasFormat format = AtlasFormat::Srgb8, float slanted = 4.0f) {
  TessAtlasOptions options;
  options.memory.width = 1024;
  options.memory.height = 1024;
  options.memory.slanted = slanted;
  options.memory.pressureBias = false;
  options.format = format;
  return options;
}

EngineOptions optionsOf(const TessAtlasOptions& tess) {
  EngineOptions options;
  options.gatherer = GathererKind::Tess;
  options.tess = tess;
  options.atlas.memory.width = options.atlas.memory.height = 1024;
  options.atlas.memory.pressureBias = false;
  options.atlas.format = tess.format;
  options.splitEdges = 0.0;
  options.shadowSize = 256;
  options.request.displayDeferred = true;
  return options;
}

std::unique_ptr<Engine> make(Scene scene, const TessAtlasOptions& tess = tessAtlas(),
                             std::optional<Stage> stage = {}) {
  auto engine = Engine::create(test::context(), std::move(scene), std::move(stage), optionsOf(tess));
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return nullptr;
  }
  (*engine)->update(0.0);
  return std::move(*engine);
}

View cornerView() { return lookAt({4.5, 2.2, 1.5}, {1.5, 0.9, -2.0}, 60.0, kWidth, kHeight, 0.05); }
View frontView() { return lookAt({0, 0, 0}, {0, 0, -1}, 60.0, kWidth, kHeight, 0.01); }

Image forwardOf(Engine& engine, const View& view) {
  engine.forward(view);
  return engine.readColor();
}
Image drawn(Engine& engine, const View& view, DisplayMode mode = DisplayMode::Geometry) {
  engine.rect(view, mode);
  return engine.readColor();
}

/// The shapes of what is visible: of triangles, and of pieces of split ones.
std::vector<glsl::TessShape> shapesOf(const Engine& engine) {
  const TessMemory& memory = engine.tess()->memory();
  const auto epoch = memory.readState().epoch;
  std::vector<glsl::TessShape> shapes;
  for (const auto& state : memory.readStates())
    if (state.epoch == epoch) shapes.push_back(state.shape);
  return shapes;
}
std::set<std::uint32_t> kindsOf(const Engine& engine) {
  std::set<std::uint32_t> kinds;
  for (const auto& shape : shapesOf(engine)) kinds.insert(glsl::kindOf(shape.kind));
  return kinds;
}
std::set<std::uint32_t> levelsOf(const Engine& engine) {
  std::set<std::uint32_t> levels;
  for (const auto& shape : shapesOf(engine))
    if (glsl::kindOf(shape.kind) == glsl::kTessL) levels.insert(glsl::levelOfKind(shape.kind));
  return levels;
}

/// The texels as they are stored.
std::vector<std::uint8_t> texelsOf(const Engine& engine) {
  const AtlasTexture& atlas = engine.gatherer()->atlas();
  gl::api().MemoryBarrier(GL_ALL_BARRIER_BITS);
  return atlas.format == AtlasFormat::Rgba16f
             ? gl::readTexture(atlas.texture, GL_RGBA, GL_HALF_FLOAT, 8)
             : gl::readTexture(atlas.display(), GL_RGBA, GL_UNSIGNED_BYTE, 4);
}

struct Method {
  const char* name;
  float slanted;
};
constexpr std::array<Method, 3> kMethods = {Method{"tess", 4.0f},
                                            Method{"lpack", TessMemoryOptions::kNoneSlanted},
                                            Method{"oversample", TessMemoryOptions::kAllSlanted}};

TEST_F(TessFrame, PicturesAreAsGoodAsTheRectangularAtlas) {
  for (const bool textured : {false, true}) {
    Scene scene = test::cornerScene(!textured);
    if (textured) scene.materials[1].baseColor.image = test::addCheckers(scene, 128, 8);
    test::finish(scene);
    // Ramps in linear values: what is linear comes back as it was. 8-bit encoded values bend between texels.
    const AtlasFormat format = textured ? AtlasFormat::Srgb8 : AtlasFormat::Rgba16f;
    auto engine = make(std::move(scene), tessAtlas(format));
    ASSERT_TRUE(engine);
    const View view = cornerView();
    const Image forward = forwardOf(*engine, view);
    RectMemoryOptions memory;
    memory.width = memory.height = 1024;
    memory.pressureBias = false;
    ASSERT_TRUE(engine->remakeAtlas(memory));
    const auto rect = psnr(forward, drawn(*engine, view));
    ASSERT_TRUE(rect);
    const auto samples = engine->gatherer()->readSamples();
    for (const Method& method : kMethods) {
      ASSERT_TRUE(engine->remakeAtlas(tessAtlas(format, method.slanted)));
      const Image image = drawn(*engine, view);
      EXPECT_EQ(countCovered(image), countCovered(forward)) << method.name;
      const auto quality = psnr(forward, image);
      ASSERT_TRUE(quality);
      std::printf("%s, %s: %.1f dB, %.2f times rect's samples; rect %.1f dB\n",
                  textured ? "checkers" : "ramps", method.name, *quality,
                  static_cast<double>(engine->gatherer()->readSamples()) / static_cast<double>(samples),
                  *rect);
      // Ramps are off by less than a level here and there: 3 dB are 1.4 times as often.
      EXPECT_GT(*quality, *rect - (textured ? 0.0 : 3.0)) << method.name << (textured ? " textured" : "");
    }
  }
}

TEST_F(TessFrame, AllWaysToSpawnWriteTheSameTexels) {
  const View view = frontView();
  for (const AtlasFormat format : {AtlasFormat::Srgb8, AtlasFormat::Rgba16f}) {
    auto engine = make(test::everythingScene(), tessAtlas(format), test::lampStage());
    ASSERT_TRUE(engine);
    engine->findVisible({&view, 1});
    ASSERT_TRUE(engine->place({&view, 1}));
    EXPECT_EQ(kindsOf(*engine).size(), 3u) << "the scene has all kinds";
    EXPECT_GT(*levelsOf(*engine).rbegin(), 64u);
    std::vector<std::uint8_t> first;
    std::vector<TessSpawn> ways = {{TessGather::Compute, 64},
                                   {TessGather::Tess, 64},
                                   {TessGather::Raster, 64},
                                   {TessGather::Deferred, 128}};
    if (format == AtlasFormat::Srgb8) ways.push_back({TessGather::Compute, 512});
    for (const TessSpawn& spawn : ways) {
      blackenAtlas(*engine);
      ASSERT_TRUE(engine->setSpawn(spawn));
      engine->shade(view);
      const auto texels = texelsOf(*engine);
      if (first.empty()) first = texels;
      const std::size_t texel = format == AtlasFormat::Rgba16f ? 8 : 4;
      std::size_t differing = 0;
      std::size_t shaded = 0;
      for (std::size_t i = 0; i < texels.size(); i += texel) {
        differing += std::memcmp(&texels[i], &first[i], texel) != 0 ? 1 : 0;
        shaded += texels[i + texel - 1] != 0 ? 1 : 0;  // alpha
      }
      EXPECT_EQ(differing, 0u) << "way " << static_cast<int>(spawn.gather) << ", group " << spawn.group;
      const auto wanted = engine->gatherer()->readSamples();
      EXPECT_LE(shaded, wanted);
      EXPECT_GT(static_cast<double>(shaded), 0.97 * static_cast<double>(wanted));
    }
  }
}

TEST_F(TessFrame, WaysToSpawnThatAreNoneAreRefused) {
  auto engine = make(test::cornerScene());
  ASSERT_TRUE(engine);
  const Image before = drawn(*engine, cornerView());
  for (const int group : {0, 1, 65, 1024, -64}) {
    const auto set = engine->setSpawn({TessGather::Compute, group});
    ASSERT_FALSE(set);
    EXPECT_NE(set.error().message.find(std::to_string(group)), std::string::npos) << set.error().message;
  }
  EXPECT_EQ(drawn(*engine, cornerView()).pixels, before.pixels);
}

TEST_F(TessFrame, DeferredDisplayEqualsGeometryDisplay) {
  for (const Method& method : kMethods) {
    Scene scene = test::cornerScene();
    scene.nodes.emplace_back();
    scene.nodes.back().scale = {-1, 1, 1};
    scene.nodes.back().translation = {3.4, 0.2, 0.6};
    scene.instances.push_back({1, 3});
    test::finish(scene);
    auto engine = make(std::move(scene), tessAtlas(AtlasFormat::Srgb8, method.slanted));
    ASSERT_TRUE(engine);
    const View view = cornerView();
    const Image geometry = drawn(*engine, view);
    engine->display(view, DisplayMode::Deferred);
    const Image deferred = engine->readColor();
    EXPECT_EQ(countCovered(geometry), countCovered(deferred)) << method.name;
    EXPECT_LT(meanDifference(geometry, deferred), 0.02) << method.name;
    EXPECT_LE(largestDifference(geometry, deferred), 6) << method.name;
  }
}

// ---- several views, foveation, lens ----

TEST_F(TessFrame, WhatOneEyeSeesIsShadedForBoth) {
  auto engine = make(test::whiteScene());
  ASSERT_TRUE(engine);
  const View centre = frontView();
  const auto eyes = stereoViews(centre, 0.2);
  std::array<std::set<std::uint32_t>, 2> seen;
  for (std::size_t i = 0; i < 2; ++i) {
    engine->findVisible({&eyes[i], 1});
    const auto list = engine->visibleSet()->read();
    seen[i] = {list.begin(), list.end()};
  }
  EXPECT_TRUE(std::any_of(seen[0].begin(), seen[0].end(), [&](auto t) { return seen[1].count(t) == 0; }));
  blackenAtlas(*engine);
  engine->findVisible(eyes);
  ASSERT_TRUE(engine->place(eyes));
  const auto states = engine->tess()->memory().readStates();
  for (const auto& one : seen)
    for (const std::uint32_t triangle : one) EXPECT_NE(states[triangle].shape.kind, glsl::kTessNone);
  engine->shade(centre);
  for (std::size_t i = 0; i < 2; ++i) {
    engine->display(eyes[i]);
    const Image shown = engine->readColor();
    EXPECT_EQ(darkPixels(shown), 0u) << "eye " << i;
    EXPECT_EQ(countCovered(shown), countCovered(forwardOf(*engine, eyes[i]))) << "eye " << i;
  }
}

TEST_F(TessFrame, FoveationAndLensTakeSamplesAndLeaveNoHoles) {
  auto engine = make(test::whiteScene());
  ASSERT_TRUE(engine);
  const View view = frontView();
  const auto samples = [&](const PlaceOptions& options) {
    engine->tess()->memory().reset();
    engine->findVisible({&view, 1});
    EXPECT_TRUE(engine->place({&view, 1}, options));
    const auto count = engine->gatherer()->readSamples();
    blackenAtlas(*engine);
    engine->shade(view);
    engine->display(view);
    EXPECT_EQ(darkPixels(engine->readColor()), 0u);
    return static_cast<double>(count);
  };
  const double plain = samples({});
  const Foveation sharpInTheMiddle{{0.5, 0.5}, 0.05, 0.5};
  const double foveated = samples({.foveation = sharpInTheMiddle});
  const double bent = samples({.lens = Lens{}});
  EXPECT_LT(foveated, 0.6 * plain);
  EXPECT_LT(bent, 0.95 * plain) << "the lens presses only the wall's outer part together";
  EXPECT_LT(samples({.foveation = sharpInTheMiddle, .lens = Lens{}}), std::min(foveated, bent));
  EXPECT_EQ(samples({}), plain) << "something of them stayed on";
}

// ---- triangles that are hard to sample ----

TEST_F(TessFrame, HardTrianglesHaveNoHolesAndFiniteTexels) {
  const Scene scene = test::hardScene();
  for (const AtlasFormat format : {AtlasFormat::Rgba16f, AtlasFormat::Srgb8}) {
    auto engine = make(scene, tessAtlas(format));
    ASSERT_TRUE(engine);
    for (const Method& method : kMethods) {
      ASSERT_TRUE(engine->remakeAtlas(tessAtlas(format, method.slanted)));
      for (const glm::dvec3 eye :
           {glm::dvec3(0, 0, 0), glm::dvec3(0.01, 0.9, -0.5), glm::dvec3(0, 0.0001, -0.9)}) {
        SCOPED_TRACE(testing::Message() << method.name << " from " << eye.x << " " << eye.y);
        const View view = lookAt(eye, eye + glm::dvec3(0.02, 0.01, -1), 80.0, kWidth, kHeight, 0.01);
        blackenAtlas(*engine);
        for (const DisplayMode mode : {DisplayMode::Geometry, DisplayMode::Deferred}) {
          const Image image = drawn(*engine, view, mode);
          EXPECT_EQ(darkPixels(image), 0u) << "mode " << static_cast<int>(mode);
          EXPECT_EQ(countCovered(image), static_cast<std::size_t>(kWidth * kHeight));
        }
        EXPECT_EQ(engine->nonFiniteTexels(), 0u);
      }
    }
  }
}

TEST_F(TessFrame, TrianglesOfAFewPixelsHaveNoHoles) {
  for (const int pixels : {1, 2, 3}) {
    // Cells of that many pixels, over the whole view: 240 pixels are 1.1547 high at depth 1.
    const float cell = 1.1547f / 240.0f * static_cast<float>(pixels);
    Scene scene = test::emptyScene();
    const auto index = test::addMaterial(scene, test::unlit());
    const int nx = 340 / pixels;
    const int ny = 260 / pixels;
    const glm::vec3 size(cell * static_cast<float>(nx), cell * static_cast<float>(ny), 0.0f);
    test::place(scene, test::addGrid(scene, {-0.5f * size.x, -0.5f * size.y, -1.0f}, {size.x, 0, 0},
                                     {0, size.y, 0}, nx, ny, index, true));
    test::finish(scene);
    auto engine = make(std::move(scene), tessAtlas(AtlasFormat::Rgba16f));
    ASSERT_TRUE(engine);
    const View view = frontView();
    const Image forward = forwardOf(*engine, view);
    for (const Method& method : kMethods) {
      ASSERT_TRUE(engine->remakeAtlas(tessAtlas(AtlasFormat::Rgba16f, method.slanted)));
      const Image image = drawn(*engine, view);
      EXPECT_EQ(countCovered(image), countCovered(forward));
      // A triangle of one texel has one colour: the ramp changes by a level over a pixel, and more in the
      // dark.
      EXPECT_LT(meanDifference(image, forward), 0.2) << method.name << " " << pixels;
      EXPECT_EQ(engine->tess()->memory().readStatistics().failures, 0u);
    }
  }
}

// A ramp over a mesh whose triangles have all levels, small and past what a tessellator spawns: at a seam
// nothing may show.
TEST_F(TessFrame, LinearColoursAreReproducedAcrossLevels) {
  Scene scene = test::emptyScene();
  const auto index = test::addMaterial(scene, test::unlit());
  test::place(scene, test::addGrid(scene, {-3, -1, -1.0f}, {6, 0.2f, 0}, {0, 1.8f, -6}, 6, 9, index, true));
  // Samples outside of the triangle are extrapolated, and colours below 0 do not exist.
  for (glm::vec4& color : scene.vertices.color) color = glm::vec4(glm::vec3(color) * 0.5f + 0.25f, 1.0f);
  test::finish(scene);
  auto engine = make(std::move(scene), tessAtlas(AtlasFormat::Rgba16f));
  ASSERT_TRUE(engine);
  for (const Method& method : kMethods) {
    ASSERT_TRUE(engine->remakeAtlas(tessAtlas(AtlasFormat::Rgba16f, method.slanted)));
    std::set<std::uint32_t> levels;
    for (const double fov : {60.0, 52.0, 44.0}) {
      const View view = lookAt({0, 0.4, 0.2}, {0, -0.2, -3}, fov, kWidth, kHeight, 0.05);
      const Image forward = forwardOf(*engine, view);
      blackenAtlas(*engine);
      const Image image = drawn(*engine, view);
      EXPECT_EQ(countCovered(image), countCovered(forward));
      EXPECT_LE(largestDifference(image, forward), 1) << method.name << " " << fov;
      EXPECT_LT(meanDifference(image, forward), 0.05) << method.name << " " << fov;
      levels.merge(levelsOf(*engine));
    }
    if (method.slanted < 1.0f) continue;
    EXPECT_LT(*levels.begin(), 40u);
    EXPECT_GT(*levels.rbegin(), 64u);
  }
}

// Few samples over a steep ramp: what filtering makes of the cells on an L's seams would show. With fewer
// still, so would the 8 bits of a filter's weights.
TEST_F(TessFrame, CoarseSamplesReproduceARampToo) {
  Scene scene = test::emptyScene();
  const auto index = test::addMaterial(scene, test::unlit());
  test::place(scene, test::addGrid(scene, {-0.6f, -0.4f, -1}, {1.2f, 0.1f, 0}, {0.1f, 0.9f, -0.3f}, 1, 1,
                                   index, true));
  for (glm::vec4& color : scene.vertices.color) color = glm::vec4(glm::vec3(color) * 0.6f + 0.3f, 1.0f);
  test::finish(scene);
  auto engine = make(std::move(scene), tessAtlas(AtlasFormat::Rgba16f));
  ASSERT_TRUE(engine);
  const View view = frontView();
  const Image forward = forwardOf(*engine, view);
  for (const Method& method : kMethods)
    for (const float bias : {8.0f, 10.0f, 11.0f}) {
      TessAtlasOptions options = tessAtlas(AtlasFormat::Rgba16f, method.slanted);
      options.memory.bias = bias;
      ASSERT_TRUE(engine->remakeAtlas(options));
      EXPECT_LE(largestDifference(drawn(*engine, view), forward), 1) << method.name << ", bias " << bias;
    }
}

TEST_F(TessFrame, Levels64And65MeetWithoutASeam) {
  Scene scene = test::emptyScene();
  const auto index = test::addMaterial(scene, test::unlit());
  // Mirror images, but that the lower one is a hundredth longer.
  const auto pair = test::addTriangles(
      scene,
      {{-0.5f, 0, -2}, {0.5f, 0, -2}, {0.45f, 0.9f, -2}, {-0.5f, 0, -2}, {0.45f, -0.92f, -2}, {0.5f, 0, -2}},
      index);
  scene.primitives[pair].hasColor = true;
  for (std::size_t i = 0; i < scene.vertices.position.size(); ++i)
    scene.vertices.color[i] =
        glm::vec4(0.5f + 0.3f * scene.vertices.position[i], 1.0f) * glm::vec4(1, 1, -1, 1);
  test::place(scene, pair);
  test::finish(scene);
  TessAtlasOptions options = tessAtlas(AtlasFormat::Rgba16f);
  options.memory.hysteresis = -1.0f;
  auto engine = make(std::move(scene), options);
  ASSERT_TRUE(engine);
  bool met = false;
  for (double fov = 140.0; fov > 60.0 && !met; fov -= 0.5) {
    const View view = lookAt({0, 0, 0}, {0, 0, -2}, fov, kWidth, kHeight, 0.05);
    engine->findVisible({&view, 1});
    ASSERT_TRUE(engine->place({&view, 1}));
    met = levelsOf(*engine) == std::set<std::uint32_t>{64, 65};
    if (!met) continue;
    for (const TessGather gather : {TessGather::Compute, TessGather::Tess}) {
      ASSERT_TRUE(engine->setSpawn({gather, 64}));
      blackenAtlas(*engine);
      engine->shade(view);
      engine->display(view);
      EXPECT_LE(largestDifference(engine->readColor(), forwardOf(*engine, view)), 1);
    }
  }
  EXPECT_TRUE(met) << "no view gave the triangles levels 64 and 65";
}

TEST_F(TessFrame, ThePlainDecodeBendsARampAndTheExactOneDoesNot) {
  // One triangle of some tens of levels with a ramp of all of a colour: what is off is off by a share of a
  // step.
  Scene scene = test::cornerScene(true);
  test::finish(scene);
  auto engine = make(std::move(scene), tessAtlas(AtlasFormat::Rgba16f, TessMemoryOptions::kNoneSlanted));
  ASSERT_TRUE(engine);
  const View view = cornerView();
  const Image forward = forwardOf(*engine, view);
  std::array<double, 2> quality{};
  for (const TessDecode decode : {TessDecode::Exact, TessDecode::Plain}) {
    TessAtlasOptions options = tessAtlas(AtlasFormat::Rgba16f, TessMemoryOptions::kNoneSlanted);
    options.decode = decode;
    options.memory.bias = 5.0f;  // coarse: a step of samples is some pixels
    ASSERT_TRUE(engine->remakeAtlas(options));
    const Image shown = drawn(*engine, view);
    const auto decibels = psnr(forward, shown);
    ASSERT_TRUE(decibels);
    quality[decode == TessDecode::Plain ? 1 : 0] = *decibels;
    EXPECT_LE(largestDifference(drawn(*engine, view, DisplayMode::Deferred), shown), 2);
  }
  std::printf("exact %.2f dB, plain %.2f dB\n", quality[0], quality[1]);
  EXPECT_GT(quality[0], quality[1] + 3.0);
}

// ---- triangles that are split ----

/// A floor of two triangles around the camera, and a wall of two: a batch each. Checks of `checkers` texels
/// of 256, or white.
Scene largeScene(int checkers) {
  Scene scene = test::emptyScene();
  Material material = test::unlit();
  material.doubleSided = true;
  if (checkers > 0) material.baseColor.image = test::addCheckers(scene, 256, checkers);
  const auto floor = test::addMaterial(scene, material);
  const auto wall = test::addMaterial(scene, material);
  test::place(scene, test::addGrid(scene, {-6, -1, 6}, {12, 0, 0}, {0, 0, -12}, 1, 1, floor));
  test::place(scene, test::addGrid(scene, {-3, -1, -5}, {6, 0, 0}, {0, 3, 0}, 1, 1, wall));
  test::finish(scene);
  return scene;
}

View largeView(double turn = 0.0) {
  return lookAt({0.3, 0.5, 0}, {0.3 + 4.0 * std::sin(turn), -0.5, -4.0 * std::cos(turn)}, 70.0, 960, 540,
                0.01);
}

/// Large enough that nothing is coarser for want of memory.
TessAtlasOptions largeAtlas(float slanted = 4.0f) {
  TessAtlasOptions options = tessAtlas(AtlasFormat::Srgb8, slanted);
  options.memory.width = options.memory.height = 2048;
  return options;
}

std::uint32_t splitTriangles(const Engine& engine) { return engine.tess()->split().readSplit(); }

TEST_F(TessFrame, TrianglesThatNeedMoreThanASlotAreSplit) {
  for (const Method& method : kMethods) {
    auto engine = make(largeScene(64), largeAtlas(method.slanted));
    ASSERT_TRUE(engine);
    const View view = largeView();
    const Image forward = forwardOf(*engine, view);
    const Image image = drawn(*engine, view);
    EXPECT_GT(splitTriangles(*engine), 0u) << method.name;
    EXPECT_EQ(countCovered(image), countCovered(forward)) << method.name;
    const auto similarity = mssim(forward, image);
    ASSERT_TRUE(similarity);
    std::printf("%s: %u split, MSSIM %.3f, %llu samples\n", method.name, splitTriangles(*engine),
                similarity->mean, static_cast<unsigned long long>(engine->gatherer()->readSamples()));
    EXPECT_GT(similarity->mean, 0.9) << method.name;
    EXPECT_LE(largestDifference(drawn(*engine, view, DisplayMode::Deferred), image), 2) << method.name;
    EXPECT_EQ(engine->tess()->memory().readStatistics().moved, 0u) << "a still camera moves nothing";
  }
}

TEST_F(TessFrame, PiecesMeetWithoutASeamAndAreShadedInEveryWay) {
  auto engine = make(largeScene(0), largeAtlas());
  ASSERT_TRUE(engine);
  const View view = largeView();
  std::vector<std::uint8_t> first;
  for (const TessSpawn& spawn : {TessSpawn{TessGather::Compute, 64}, TessSpawn{TessGather::Tess, 64},
                                 TessSpawn{TessGather::Raster, 64}, TessSpawn{TessGather::Deferred, 64}}) {
    ASSERT_TRUE(engine->setSpawn(spawn));
    engine->findVisible({&view, 1});
    ASSERT_TRUE(engine->place({&view, 1}));
    EXPECT_GT(splitTriangles(*engine), 0u);
    blackenAtlas(*engine);
    engine->shade(view);
    for (const DisplayMode mode : {DisplayMode::Geometry, DisplayMode::Deferred}) {
      engine->display(view, mode);
      const Image image = engine->readColor();
      EXPECT_GT(countCovered(image), 10000u);
      EXPECT_EQ(darkPixels(image), 0u) << "way " << static_cast<int>(spawn.gather);
    }
  }
}

TEST_F(TessFrame, OnlyPiecesInViewAreShadedAndTheOthersAreNeverBlack) {
  auto engine = make(largeScene(0), largeAtlas());
  ASSERT_TRUE(engine);
  const View view = largeView();
  const View turned = largeView(1.2);
  engine->findVisible({&view, 1});
  ASSERT_TRUE(engine->place({&view, 1}));
  const auto one = engine->gatherer()->readSamples();
  const std::array<View, 2> both = {view, turned};
  engine->findVisible(both);
  ASSERT_TRUE(engine->place(both));
  const auto two = engine->gatherer()->readSamples();
  EXPECT_GT(static_cast<double>(two), 1.2 * static_cast<double>(one));
  blackenAtlas(*engine);
  engine->shade(view);
  for (const View& shown : both) {
    engine->display(shown);
    EXPECT_EQ(darkPixels(engine->readColor()), 0u);
  }
  // Placed for one view, shown from the other, for which pieces are missing.
  engine->findVisible({&view, 1});
  ASSERT_TRUE(engine->place({&view, 1}));
  EXPECT_LT(engine->gatherer()->readSamples(), two) << "pieces that nobody sees are given up";
  blackenAtlas(*engine);
  engine->shade(view);
  engine->display(turned);
  const Image shown = engine->readColor();
  EXPECT_GT(countCovered(shown), 10000u);
  EXPECT_EQ(darkPixels(shown), 0u);
}

TEST_F(TessFrame, PiecesThatNobodySawShowTheirTriangleCoarsely) {
  auto engine = make(largeScene(4), largeAtlas());
  ASSERT_TRUE(engine);
  const View view = largeView();
  const View turned = largeView(1.2);
  const Image forward = forwardOf(*engine, turned);
  engine->findVisible({&view, 1});
  ASSERT_TRUE(engine->place({&view, 1}));
  engine->shade(view);
  for (const DisplayMode mode : {DisplayMode::Geometry, DisplayMode::Deferred}) {
    if (mode == DisplayMode::Deferred) {
      engine->findVisible({&turned, 1});  // ids of that view; places are still the other's
    }
    engine->display(turned, mode);
    EXPECT_LT(meanDifference(engine->readColor(), forward), 5.0) << static_cast<int>(mode);
  }
}

TEST_F(TessFrame, MoreSplitTrianglesThanBlocksAreSampledCoarsely) {
  // Stripes across a wall and the view, each too long for a slot, more than there are blocks for.
  Scene scene = test::emptyScene();
  const auto white = test::addMaterial(scene, test::unlit());
  test::place(scene, test::addGrid(scene, {-9, -0.8f, -1}, {18, 0, 0}, {0, 1.6f, 0}, 1, 300, white));
  test::finish(scene);
  auto engine = make(std::move(scene));
  ASSERT_TRUE(engine);
  const View view = lookAt({0, 0, 0}, {0, 0, -1}, 90.0, 1600, 1080, 0.01);
  for (int frame = 0; frame < 3; ++frame) {
    engine->findVisible({&view, 1});
    ASSERT_TRUE(engine->place({&view, 1}));
    EXPECT_EQ(splitTriangles(*engine), glsl::kSplitBlocks);
    blackenAtlas(*engine);
    engine->shade(view);
    engine->display(view);
    const Image image = engine->readColor();
    EXPECT_GT(countCovered(image), 10000u);
    EXPECT_EQ(darkPixels(image), 0u);
  }
  // What is gone gives its numbers back.
  const View away = lookAt({0, 0, 0}, {0, 1, 0.01}, 60.0, 960, 540, 0.01);
  engine->findVisible({&away, 1});
  ASSERT_TRUE(engine->place({&away, 1}));
  EXPECT_EQ(splitTriangles(*engine), 0u);
}

// ---- materials ----

TEST_F(TessFrame, CullingMaskMirrorAndDoubleSideMatchForward) {
  auto engine = make(test::sidesScene(), tessAtlas(), test::sunStage());
  ASSERT_TRUE(engine);
  for (const double side : {1.0, -1.0}) {
    const View view = lookAt({0.3, 0.2, -5.0 + side * 5.0}, {0, 0, -5}, 60.0, kWidth, kHeight, 0.05);
    const Image forward = forwardOf(*engine, view);
    EXPECT_GT(countCovered(forward), 2000u);
    for (const DisplayMode mode : {DisplayMode::Geometry, DisplayMode::Deferred}) {
      const Image image = drawn(*engine, view, mode);
      EXPECT_EQ(countCovered(image), countCovered(forward))
          << "side " << side << " mode " << static_cast<int>(mode);
      const auto similarity = mssim(forward, image);
      ASSERT_TRUE(similarity);
      EXPECT_GT(similarity->mean, 0.95) << "side " << side << " mode " << static_cast<int>(mode);
      EXPECT_LT(meanDifference(image, forward), 0.5) << "side " << side << " mode " << static_cast<int>(mode);
    }
  }
}

TEST_F(TessFrame, GatherersAreExchangedBackAndForth) {
  auto engine = make(test::everythingScene(), tessAtlas(), test::lampStage());
  ASSERT_TRUE(engine);
  const View view = frontView();
  RectMemoryOptions memory;
  memory.width = memory.height = 1024;
  const Image tess = drawn(*engine, view);
  EXPECT_EQ(engine->atlas(), nullptr);
  ASSERT_TRUE(engine->remakeAtlas(memory));
  EXPECT_EQ(engine->tess(), nullptr);
  const Image rect = drawn(*engine, view);
  EXPECT_NE(rect.pixels, tess.pixels);
  ASSERT_TRUE(engine->remakeAtlas(tessAtlas()));
  // Slots are drawn in the order of threads, which shows in the last bit of an interpolated texel.
  EXPECT_LE(largestDifference(drawn(*engine, view), tess), 1);
  // What cannot be made leaves what there is.
  TessAtlasOptions bad = tessAtlas();
  bad.memory.width = 100;
  const auto refused = engine->remakeAtlas(bad);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("width"), std::string::npos);
  EXPECT_LE(largestDifference(drawn(*engine, view), tess), 1);
  ASSERT_TRUE(engine->remakeAtlas(memory));
  EXPECT_LE(largestDifference(drawn(*engine, view), rect), 1);
}

TEST_F(TessFrame, EachTexelOfTheStatisticsHasItsKind) {
  auto engine = make(test::whiteScene());
  ASSERT_TRUE(engine);
  const View view = cornerView();
  TessAtlasOptions options = tessAtlas();
  RectMemoryOptions rect;
  rect.width = rect.height = 1024;
  for (const float slanted : {1.5f, TessMemoryOptions::kNoneSlanted, TessMemoryOptions::kAllSlanted, 0.0f}) {
    SCOPED_TRACE(slanted);
    options.memory.slanted = slanted;
    ASSERT_TRUE(slanted > 0.0f ? engine->remakeAtlas(options) : engine->remakeAtlas(rect));
    engine->rect(view);
    const GatherStatistics statistics = engine->gatherer()->readStatistics();
    std::vector<std::uint64_t> texels(1 + statistics.kinds.size(), 0);
    for (const std::uint8_t kind : engine->gatherer()->readKinds()) ++texels.at(kind);
    std::uint64_t samples = 0;
    for (std::size_t i = 0; i < statistics.kinds.size(); ++i) {
      EXPECT_EQ(statistics.kinds[i].samples, texels[1 + i]) << statistics.kinds[i].name;
      samples += statistics.kinds[i].samples;
    }
    EXPECT_GT(samples, 100u);
    EXPECT_EQ(statistics.samples, samples);
    EXPECT_GE(statistics.usedTexels, samples);
    EXPECT_GT(statistics.visible, 0u);
  }
}

TEST_F(TessFrame, SlantIsOfTheTriangleThatAPixelShows) {
  auto engine = make(test::whiteScene());
  ASSERT_TRUE(engine);
  const View view = cornerView();
  EXPECT_TRUE(engine->readIds().empty());
  TessAtlasOptions options = tessAtlas();
  engine->findVisible({&view, 1});
  const auto ids = engine->readIds();
  ASSERT_EQ(ids.size(), std::size_t{kWidth} * kHeight);
  engine->forward(view);
  const Image picture = engine->readColor();
  std::set<std::uint32_t> shown;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_EQ(ids[i] != 0, picture.pixels[4 * i + 3] > 0) << "pixel " << i;
    if (ids[i] != 0) shown.insert(ids[i]);
  }
  ASSERT_GT(shown.size(), 4u);
  // As many are past a threshold as the gatherer oversamples by it.
  for (const float threshold : {1.5f, 2.5f, 4.0f}) {
    options.memory.slanted = threshold;
    ASSERT_TRUE(engine->remakeAtlas(options));
    engine->rect(view);
    std::uint64_t slanted = 0;
    for (const std::uint32_t id : shown)
      slanted += engine->slantOf(id, view) > static_cast<double>(threshold) ? 1 : 0;
    EXPECT_EQ(slanted, *engine->gatherer()->readStatistics().slanted) << threshold;
  }
}

TEST_F(TessFrame, OutOfMemoryLosesDetailAndNothingElse) {
  TessAtlasOptions small = tessAtlas();
  small.memory.width = small.memory.height = 256;
  auto engine = make(test::whiteScene(), small);
  ASSERT_TRUE(engine);
  const View view = frontView();
  for (const bool bias : {false, true}) {
    small.memory.pressureBias = bias;
    ASSERT_TRUE(engine->remakeAtlas(small));
    const Image image = drawn(*engine, view);
    const TessStatistics statistics = engine->tess()->memory().readStatistics();
    EXPECT_EQ(statistics.failures > 0, !bias);
    EXPECT_EQ(darkPixels(image), 0u);
    EXPECT_EQ(countCovered(image), countCovered(forwardOf(*engine, view)));
  }
}

}  // namespace
}  // namespace tessera
