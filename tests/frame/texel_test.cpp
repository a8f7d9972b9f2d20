// Texel Shading end to end on scenes made in code: against forward, on triangles that are hard to sample,
// from frame to frame, and out of memory.
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "engine/measure/metrics.hpp"
#include "tests/frame/pictures.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using TexelFrame = test::GlTest;
using test::blackenAtlas;
using test::countCovered;
using test::darkPixels;
using test::largestDifference;
using test::meanDifference;

constexpr int kWidth = 320;
constexpr int kHeight = 240;

TexelAtlasOptions texelAtlas(AtlasFormat format = AtlasFormat::Srgb8) {
  TexelAtlasOptions options;
  options.width = options.height = 1024;
  options.pressureBias = false;
  options.format = format;
  return options;
}

std::unique_ptr<Engine> make(Scene scene, const TexelAtlasOptions& texel = texelAtlas(),
                             std::optional<Stage> stage = {}) {
  EngineOptions options;
  options.gatherer = GathererKind::Texel;
  options.texel = texel;
  options.atlas.memory.width = options.atlas.memory.height = 1024;
  options.atlas.memory.pressureBias = false;
  options.atlas.format = texel.format;
  options.splitEdges = 0.0;
  options.shadowSize = 256;
  options.request.displayDeferred = true;
  auto engine = Engine::create(test::context(), std::move(scene), std::move(stage), options);
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

/// Slots by patch and tile.
std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> slotsOf(const Engine& engine) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> slots;
  std::set<std::uint32_t> taken;
  for (const glsl::TexelTile& tile : engine.texel()->readTiles()) {
    EXPECT_TRUE(slots.emplace(std::pair(tile.patchId, tile.tile), tile.slot).second) << "a tile twice";
    EXPECT_TRUE(taken.insert(tile.slot).second) << "slot " << tile.slot << " twice";
    EXPECT_LT(tile.slot, engine.texel()->readCounts().slots);
  }
  return slots;
}

std::size_t shadedTexels(const Engine& engine) {
  gl::api().MemoryBarrier(GL_ALL_BARRIER_BITS);
  const auto texels = gl::readTexture(engine.gatherer()->atlas().display(), GL_RGBA, GL_UNSIGNED_BYTE, 4);
  std::size_t shaded = 0;
  for (std::size_t i = 3; i < texels.size(); i += 4) shaded += texels[i] != 0 ? 1 : 0;
  return shaded;
}

TEST_F(TexelFrame, PicturesLookLikeForward) {
  auto engine = make(test::everythingScene(), texelAtlas(), test::lampStage());
  ASSERT_TRUE(engine);
  const View view = frontView();
  const Image forward = forwardOf(*engine, view);
  blackenAtlas(*engine);
  const Image image = drawn(*engine, view);
  EXPECT_EQ(countCovered(image), countCovered(forward));
  const auto similarity = mssim(forward, image);
  ASSERT_TRUE(similarity);
  const TexelStatistics statistics = engine->texel()->readCounts();
  std::printf("MSSIM %.4f, %u tiles, %llu samples, %.0f %% of the threads without one\n", similarity->mean,
              statistics.tiles, static_cast<unsigned long long>(statistics.samples),
              100.0 * statistics.wasted());
  EXPECT_GT(similarity->mean, 0.93);
  // What is counted is what was written, once each.
  EXPECT_EQ(shadedTexels(*engine), statistics.samples);
  EXPECT_EQ(statistics.visible, engine->visibleSet()->read().size());
  EXPECT_EQ(statistics.tiles, slotsOf(*engine).size());
  EXPECT_EQ(statistics.tiles, statistics.marked);
}

TEST_F(TexelFrame, LinearColoursAreReproducedAcrossLevels) {
  Scene scene = test::emptyScene();
  const auto index = test::addMaterial(scene, test::unlit());
  test::place(scene, test::addGrid(scene, {-3, -1, -1.0f}, {6, 0.2f, 0}, {0, 1.8f, -6}, 6, 9, index, true));
  // Samples outside of a single are extrapolated, and colours below 0 do not exist.
  for (glm::vec4& color : scene.vertices.color) color = glm::vec4(glm::vec3(color) * 0.5f + 0.25f, 1.0f);
  test::finish(scene);
  for (const bool pairs : {true, false}) {
    EngineOptions options;
    options.gatherer = GathererKind::Texel;
    options.texel = texelAtlas(AtlasFormat::Rgba16f);
    options.splitEdges = 0.0;
    options.patches.pair = options.patches.triple = pairs;
    auto made = Engine::create(test::context(), scene, {}, options);
    ASSERT_TRUE(made) << made.error().message;
    Engine& engine = **made;
    engine.update(0.0);
    std::set<std::uint32_t> levels;
    for (const double fov : {60.0, 44.0}) {
      const View view = lookAt({0, 0.4, 0.2}, {0, -0.2, -3}, fov, kWidth, kHeight, 0.05);
      const Image forward = forwardOf(engine, view);
      blackenAtlas(engine);
      const Image image = drawn(engine, view);
      EXPECT_EQ(countCovered(image), countCovered(forward));
      EXPECT_LE(largestDifference(image, forward), 1) << "pairs " << pairs << ", " << fov << " degrees";
      EXPECT_LT(meanDifference(image, forward), 0.05) << "pairs " << pairs << ", " << fov << " degrees";
      for (const auto& [tile, slot] : slotsOf(engine)) levels.insert(glsl::tileLevel(tile.second));
    }
    EXPECT_GE(levels.size(), 3u);
  }
}

TEST_F(TexelFrame, DeferredDisplayEqualsGeometryDisplay) {
  Scene scene = test::cornerScene();
  scene.nodes.emplace_back();
  scene.nodes.back().scale = {-1, 1, 1};
  scene.nodes.back().translation = {3.4, 0.2, 0.6};
  scene.instances.push_back({1, 3});
  test::finish(scene);
  auto engine = make(std::move(scene));
  ASSERT_TRUE(engine);
  const Image geometry = drawn(*engine, cornerView());
  engine->display(cornerView(), DisplayMode::Deferred);
  const Image deferred = engine->readColor();
  EXPECT_EQ(countCovered(geometry), countCovered(deferred));
  EXPECT_LT(meanDifference(geometry, deferred), 0.02);
  EXPECT_LE(largestDifference(geometry, deferred), 6);
}

TEST_F(TexelFrame, HardTrianglesHaveNoHolesAndFiniteTexels) {
  for (const AtlasFormat format : {AtlasFormat::Rgba16f, AtlasFormat::Srgb8}) {
    auto engine = make(test::hardScene(), texelAtlas(format));
    ASSERT_TRUE(engine);
    for (const glm::dvec3 eye :
         {glm::dvec3(0, 0, 0), glm::dvec3(0.01, 0.9, -0.5), glm::dvec3(0, 0.0001, -0.9)}) {
      SCOPED_TRACE(testing::Message() << "from " << eye.x << " " << eye.y);
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

TEST_F(TexelFrame, TrianglesOfAFewPixelsHaveNoHolesAndWasteMostOfATile) {
  for (const int pixels : {1, 2, 3}) {
    const float cell = 1.1547f / 240.0f * static_cast<float>(pixels);
    Scene scene = test::emptyScene();
    const auto index = test::addMaterial(scene, test::unlit());
    const int nx = 340 / pixels;
    const int ny = 260 / pixels;
    const glm::vec3 size(cell * static_cast<float>(nx), cell * static_cast<float>(ny), 0.0f);
    test::place(scene, test::addGrid(scene, {-0.5f * size.x, -0.5f * size.y, -1.0f}, {size.x, 0, 0},
                                     {0, size.y, 0}, nx, ny, index));
    test::finish(scene);
    TexelAtlasOptions options = texelAtlas();
    options.width = 4096;
    options.height = 2048;
    auto engine = make(std::move(scene), options);
    ASSERT_TRUE(engine);
    const View view = frontView();
    blackenAtlas(*engine);
    const Image image = drawn(*engine, view);
    EXPECT_EQ(countCovered(image), countCovered(forwardOf(*engine, view)));
    EXPECT_EQ(darkPixels(image), 0u);
    const TexelStatistics statistics = engine->texel()->readCounts();
    EXPECT_EQ(statistics.coarser, 0u);
    EXPECT_GT(statistics.tiles, 0u) << pixels;
    EXPECT_GT(statistics.wasted(), 0.6) << pixels;
  }
}

TEST_F(TexelFrame, WhatOneEyeSeesIsShadedForBoth) {
  auto engine = make(test::whiteScene());
  ASSERT_TRUE(engine);
  const View centre = frontView();
  const auto eyes = stereoViews(centre, 0.2);
  std::array<std::set<std::pair<std::uint32_t, std::uint32_t>>, 2> seen;
  for (std::size_t i = 0; i < 2; ++i) {
    engine->findVisible({&eyes[i], 1});
    ASSERT_TRUE(engine->place({&eyes[i], 1}));
    for (const auto& [tile, slot] : slotsOf(*engine)) seen[i].insert(tile);
  }
  EXPECT_NE(seen[0], seen[1]);
  blackenAtlas(*engine);
  engine->findVisible(eyes);
  ASSERT_TRUE(engine->place(eyes));
  const auto both = slotsOf(*engine);
  for (const auto& one : seen)
    for (const auto& tile : one) EXPECT_TRUE(both.contains(tile));
  engine->shade(centre);
  for (std::size_t i = 0; i < 2; ++i) {
    engine->display(eyes[i]);
    const Image shown = engine->readColor();
    EXPECT_EQ(darkPixels(shown), 0u) << "eye " << i;
    EXPECT_EQ(countCovered(shown), countCovered(forwardOf(*engine, eyes[i]))) << "eye " << i;
  }
}

// Another camera than the one that was shaded for asks for levels and tiles that are not there: it finds
// others.
TEST_F(TexelFrame, OtherCamerasFindNoHoles) {
  auto engine = make(test::cornerScene());
  ASSERT_TRUE(engine);
  blackenAtlas(*engine);
  drawn(*engine, cornerView());
  for (const glm::dvec3 eye :
       {glm::dvec3(3.5, 1.5, 0.5), glm::dvec3(5.5, 3.0, 2.5), glm::dvec3(4.0, 2.8, 1.9)}) {
    const View other = lookAt(eye, {1.5, 0.9, -2.0}, 55.0, kWidth, kHeight, 0.05);
    engine->display(other);
    const Image image = engine->readColor();
    const Image forward = forwardOf(*engine, other);
    EXPECT_GT(countCovered(image), countCovered(forward) * 95 / 100);
    const auto similarity = mssim(forward, image);
    ASSERT_TRUE(similarity);
    EXPECT_GT(similarity->mean, 0.93) << eye.x;
  }
}

// A floor to the horizon of two triangles: a block that holds a patch whole would be mostly out of view.
TEST_F(TexelFrame, OnlyWhatPixelsTouchIsShaded) {
  Scene scene = test::emptyScene();
  const auto index = test::addMaterial(scene, test::unlit());
  test::place(scene, test::addGrid(scene, {-4, -0.5f, -1.2f}, {8, 0, 0}, {0, 8, 0}, 1, 1, index, true));
  test::finish(scene);
  auto engine = make(std::move(scene));
  ASSERT_TRUE(engine);
  const View view = frontView();
  const Image image = drawn(*engine, view);
  const TexelStatistics statistics = engine->texel()->readCounts();
  const auto covered = static_cast<double>(countCovered(image));
  EXPECT_LT(static_cast<double>(statistics.samples), 3.0 * covered);
  EXPECT_GT(static_cast<double>(statistics.samples), 0.5 * covered);
  EXPECT_LT(meanDifference(image, forwardOf(*engine, view)), 0.5);
  // A bias of 2 takes a level: a quarter of the tiles, but for those on borders.
  TexelAtlasOptions coarse = texelAtlas();
  coarse.bias = 2.0f;
  ASSERT_TRUE(engine->remakeAtlas(coarse));
  drawn(*engine, view);
  const double share = engine->texel()->readCounts().tiles / static_cast<double>(statistics.tiles);
  EXPECT_NEAR(share, 0.25, 0.08);
}

TEST_F(TexelFrame, TilesKeepTheirSlotsWhileTheyAreUsed) {
  auto engine = make(test::cornerScene());
  ASSERT_TRUE(engine);
  const View view = cornerView();
  const Image first = drawn(*engine, view);
  const auto slots = slotsOf(*engine);
  EXPECT_EQ(engine->texel()->readCounts().kept, 0u);
  for (int frame = 0; frame < 3; ++frame) {
    blackenAtlas(*engine);
    EXPECT_EQ(drawn(*engine, view).pixels, first.pixels);
    EXPECT_EQ(slotsOf(*engine), slots);
    EXPECT_EQ(engine->texel()->readCounts().kept, slots.size());
  }
  // A camera that moves on keeps what stays, gives the rest back, and never runs out.
  for (int frame = 1; frame < 30; ++frame) {
    const double angle = 0.21 * frame;
    const View moved = lookAt({4.5 * std::cos(angle), 2.2, 1.5 + 2.0 * std::sin(angle)}, {1.5, 0.9, -2.0},
                              60.0, kWidth, kHeight, 0.05);
    const auto before = slotsOf(*engine);
    drawn(*engine, moved);
    const auto after = slotsOf(*engine);
    std::uint32_t stayed = 0;
    for (const auto& [tile, slot] : before) {
      const auto found = after.find(tile);
      if (found == after.end()) continue;
      EXPECT_EQ(found->second, slot);
      ++stayed;
    }
    EXPECT_EQ(engine->texel()->readCounts().kept, stayed);
  }
  const View away = lookAt({4.5, 2.2, 1.5}, {9.0, 2.0, 6.0}, 60.0, kWidth, kHeight, 0.05);
  EXPECT_EQ(countCovered(drawn(*engine, away)), 0u);
  EXPECT_TRUE(slotsOf(*engine).empty());
  EXPECT_EQ(engine->texel()->readCounts().samples, 0u);
  // Other slots show in the last bit of an interpolated texel.
  EXPECT_LE(largestDifference(drawn(*engine, view), first), 1);
  EXPECT_EQ(slotsOf(*engine).size(), slots.size());
}

TEST_F(TexelFrame, StagesMayRunAtTheirOwnRates) {
  auto engine = make(test::cornerScene());
  ASSERT_TRUE(engine);
  const View view = cornerView();
  const View away = lookAt({4.5, 2.2, 1.5}, {9.0, 2.0, 6.0}, 60.0, kWidth, kHeight, 0.05);
  const Image image = drawn(*engine, view);
  const auto slots = slotsOf(*engine);
  // What is found is not shown before it is placed.
  engine->findVisible({&away, 1});
  engine->findVisible({&away, 1});
  engine->display(view);
  EXPECT_EQ(engine->readColor().pixels, image.pixels);
  engine->findVisible({&view, 1});
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(engine->place({&view, 1}));
  EXPECT_EQ(slotsOf(*engine), slots);
  blackenAtlas(*engine);
  engine->shade(view);
  engine->display(view);
  EXPECT_EQ(engine->readColor().pixels, image.pixels);
}

TEST_F(TexelFrame, OutOfSlotsLosesDetailAndNothingElse) {
  TexelAtlasOptions small = texelAtlas();
  auto engine = make(test::whiteScene(), small);
  ASSERT_TRUE(engine);
  const View view = frontView();
  drawn(*engine, view);
  const auto wanted = engine->texel()->readCounts().tiles;
  EXPECT_EQ(engine->texel()->readCounts().coarser, 0u);
  for (const int side : {64, 256})
    for (const bool bias : {false, true}) {
      SCOPED_TRACE(testing::Message() << side << " texels a side, bias " << bias);
      small.width = small.height = side;
      small.pressureBias = bias;
      ASSERT_TRUE(engine->remakeAtlas(small));
      for (int frame = 0; frame < 40; ++frame) {
        blackenAtlas(*engine);
        const Image image = drawn(*engine, view);
        EXPECT_EQ(darkPixels(image), 0u);
        EXPECT_EQ(countCovered(image), countCovered(forwardOf(*engine, view)));
        const TexelStatistics statistics = engine->texel()->readCounts();
        EXPECT_LE(statistics.tiles, statistics.slots);
        if (frame == 0) {
          EXPECT_EQ(statistics.marked, wanted);
          EXPECT_GT(statistics.coarser, 0u);
        }
      }
      const TexelStatistics settled = engine->texel()->readCounts();
      EXPECT_EQ(settled.bias > 0.0f, bias);
      EXPECT_EQ(settled.coarser > 0, !bias) << "the bias is to take over from whole levels";
    }
}

TEST_F(TexelFrame, CullingMaskMirrorAndDoubleSideMatchForward) {
  auto engine = make(test::sidesScene(), texelAtlas(), test::sunStage());
  ASSERT_TRUE(engine);
  for (const double side : {1.0, -1.0}) {
    const View view = lookAt({0.3, 0.2, -5.0 + side * 5.0}, {0, 0, -5}, 60.0, kWidth, kHeight, 0.05);
    const Image forward = forwardOf(*engine, view);
    EXPECT_GT(countCovered(forward), 2000u);
    for (const DisplayMode mode : {DisplayMode::Geometry, DisplayMode::Deferred}) {
      SCOPED_TRACE(testing::Message() << "side " << side << " mode " << static_cast<int>(mode));
      const Image image = drawn(*engine, view, mode);
      EXPECT_EQ(countCovered(image), countCovered(forward));
      const auto similarity = mssim(forward, image);
      ASSERT_TRUE(similarity);
      EXPECT_GT(similarity->mean, 0.95);
      EXPECT_LT(meanDifference(image, forward), 0.5);
    }
  }
}

TEST_F(TexelFrame, WhatItCannotDoIsSaid) {
  auto engine = make(test::cornerScene());
  ASSERT_TRUE(engine);
  const View view = cornerView();
  const Image before = drawn(*engine, view);
  engine->findVisible({&view, 1});
  const auto placed = engine->place({&view, 1}, {.foveation = Foveation{}});
  ASSERT_FALSE(placed);
  EXPECT_NE(placed.error().message.find("foveation"), std::string::npos);
  EXPECT_FALSE(engine->place({&view, 1}, {.lens = Lens{}}));
  for (const auto& [name, width, height, bias, floor] :
       {std::tuple{"width", 32, 1024, 0.0f, 0.0f}, std::tuple{"height", 1024, 20000, 0.0f, 0.0f},
        std::tuple{"1028", 1028, 1024, 0.0f, 0.0f}, std::tuple{"bias", 1024, 1024, 17.0f, 0.0f},
        std::tuple{"floor", 1024, 1024, 0.0f, 1.0f}}) {
    TexelAtlasOptions bad;
    bad.width = width;
    bad.height = height;
    bad.bias = bias;
    bad.biasFloor = floor;
    const auto refused = engine->remakeAtlas(bad);
    ASSERT_FALSE(refused) << name;
    EXPECT_NE(refused.error().message.find(name), std::string::npos) << refused.error().message;
  }
  EXPECT_EQ(drawn(*engine, view).pixels, before.pixels);
  // And back and forth with another gatherer.
  RectMemoryOptions memory;
  memory.width = memory.height = 1024;
  ASSERT_TRUE(engine->remakeAtlas(memory));
  EXPECT_EQ(engine->texel(), nullptr);
  EXPECT_EQ(countCovered(drawn(*engine, view)), countCovered(before));
  ASSERT_TRUE(engine->remakeAtlas(texelAtlas()));
  EXPECT_LE(largestDifference(drawn(*engine, view), before), 1);
}

}  // namespace
}  // namespace tessera
