// The visible set of several views: one pass over layers gives what a pass a view gives.
#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <set>

#include "engine/frame/engine.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using VisibleViews = test::GlTest;

/// Boards at several depths: several instances of one mesh, one of them mirrored, one with holes by alpha,
/// and one of glass.
Scene boards() {
  Scene scene = test::emptyScene();
  Material holes;
  holes.alphaMode = AlphaMode::Mask;
  holes.alphaCutoff = 0.5f;
  holes.doubleSided = true;
  Image dots{2, 2, std::vector<std::uint8_t>(16, 255)};
  dots.pixels[3] = dots.pixels[15] = 0;
  scene.images.push_back({"dots", dots});
  holes.baseColor.image = static_cast<std::uint32_t>(scene.images.size() - 1);
  const auto masked = test::addMaterial(scene, holes);
  const auto board = test::addGrid(scene, {-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}, 8, 8);
  const auto sieve = test::addGrid(scene, {-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}, 6, 6, masked);
  Material glass;
  glass.alphaMode = AlphaMode::Blend;
  const auto pane =
      test::addGrid(scene, {-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}, 5, 5, test::addMaterial(scene, glass));
  const auto wall = test::addGrid(scene, {-6, -4, -8}, {12, 0, 0}, {0, 8, 0}, 40, 30);
  for (int i = 0; i < 5; ++i) {
    Node node;
    node.translation = {-2.0 + i, 0.2 * i - 0.4, -3.0 - 0.4 * i};
    if (i == 3) node.scale = {-1, 1, 1};
    scene.nodes.push_back(node);
    test::place(scene,
                i == 2   ? sieve
                : i == 1 ? pane
                         : board,
                static_cast<std::uint32_t>(scene.nodes.size() - 1));
  }
  test::place(scene, wall, 0);
  test::finish(scene);
  return scene;
}

std::unique_ptr<Engine> make(bool layers, Scene scene = boards(), EngineOptions options = {}) {
  options.atlas.memory.width = options.atlas.memory.height = 1024;
  options.splitEdges = 0.0;
  options.request.displayDeferred = true;
  options.request.blended = true;
  options.idLayers = layers;
  auto engine = Engine::create(test::context(), std::move(scene), {}, options);
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return nullptr;
  }
  (*engine)->update(0.0);
  return std::move(*engine);
}

std::set<std::uint32_t> seenBy(Engine& engine, std::span<const View> views) {
  engine.findVisible(views);
  const auto list = engine.visibleSet()->read();
  std::set<std::uint32_t> seen(list.begin(), list.end());
  EXPECT_EQ(seen.size(), list.size()) << "a patch is listed twice";
  return seen;
}

std::vector<View> eyes(int count) {
  std::vector<View> views;
  for (int i = 0; i < count; ++i)
    views.push_back(
        lookAt({0.8 * i - 1.0, 0.1 * i, 0}, {0.6 * i - 1.0, 0, -4}, 40.0 + 3.0 * i, 203, 151, 0.05));
  return views;
}

bool compiledLayers(const Engine& engine) {
  const auto& all = engine.permutations();
  return std::any_of(all.begin(), all.end(), [](const std::string& name) {
    return name.find("pass/id.frag") != std::string::npos && name.find("LAYERS") != std::string::npos;
  });
}

TEST_F(VisibleViews, OnePassSeesWhatOnePassAViewSees) {
  auto together = make(true);
  auto apart = make(false);
  ASSERT_TRUE(together && apart);
  for (const int count : {1, 2, 3, 8, 11}) {
    const auto views = eyes(count);
    const auto seen = seenBy(*together, views);
    EXPECT_EQ(seen, seenBy(*apart, views)) << count << " views";
    std::set<std::uint32_t> any;
    for (const View& view : views) any.merge(seenBy(*apart, {&view, 1}));
    EXPECT_EQ(seen, any) << count << " views";
    EXPECT_GE(seen.size(), seenBy(*together, {views.data(), 1}).size());
  }
  EXPECT_EQ(compiledLayers(*together), test::context().info().vertexLayers);
  EXPECT_FALSE(compiledLayers(*apart));
}

/// The boards, the third of which slides by four metres a second.
Scene slidingBoards() {
  Scene scene = boards();
  scene.meshes.emplace_back();
  scene.nodes[3].mesh = 0;
  AnimationChannel slide;
  slide.node = 3;
  slide.property = AnimatedProperty::Translation;
  slide.times = {0.0f, 1.0f};
  slide.values = {glm::vec4(-2.0f, 0.0f, -2.6f, 0.0f), glm::vec4(2.0f, 0.0f, -2.6f, 0.0f)};
  scene.animations.push_back({"slide", 1.0, {slide}});
  return scene;
}

TEST_F(VisibleViews, ObjectsAreWhereTheyAreAtEachViewsTime) {
  auto engine = make(true, slidingBoards());
  ASSERT_TRUE(engine);
  const View view = eyes(1).front();
  const auto alone = [&](double time) {
    engine->update(time);
    return seenBy(*engine, {&view, 1});
  };
  const auto early = alone(0.1);
  const auto late = alone(0.8);
  ASSERT_NE(early, late);
  std::set<std::uint32_t> both = early;
  both.insert(late.begin(), late.end());
  engine->update(0.1);
  const glm::dmat4 place = engine->state().world[3];
  const std::array<TimedView, 3> times = {{{0.1, view}, {0.8, view}, {0.8, view}}};
  engine->findVisible(times);
  const auto list = engine->visibleSet()->read();
  EXPECT_EQ(std::set<std::uint32_t>(list.begin(), list.end()), both);
  EXPECT_EQ(list.size(), both.size()) << "a patch is listed twice";
  // The scene is as of the last update again, on the CPU and on the GPU.
  EXPECT_EQ(engine->state().time, 0.1);
  EXPECT_EQ(engine->state().world[3], place);
  EXPECT_EQ(seenBy(*engine, {&view, 1}), early);
}

TEST_F(VisibleViews, ViewsOfSeveralSizesAreOneSet) {
  auto together = make(true);
  auto apart = make(false);
  ASSERT_TRUE(together && apart);
  auto views = eyes(5);
  views[1].width = views[2].width = 300;
  views[4].height = 77;
  EXPECT_EQ(seenBy(*together, views), seenBy(*apart, views));
  std::set<std::uint32_t> any;
  for (const View& view : views) any.merge(seenBy(*apart, {&view, 1}));
  EXPECT_EQ(seenBy(*together, views), any);
}

TEST_F(VisibleViews, OneViewAfterSeveralIsItsOwn) {
  auto engine = make(true);
  ASSERT_TRUE(engine);
  const auto views = eyes(3);
  const auto alone = seenBy(*engine, {views.data(), 1});
  seenBy(*engine, views);
  EXPECT_EQ(seenBy(*engine, {views.data(), 1}), alone);
  // The draw of other passes steps its instances as before.
  engine->rect(views[0]);
  const Image before = engine->readColor();
  seenBy(*engine, views);
  engine->rect(views[0]);
  EXPECT_EQ(engine->readColor().pixels, before.pixels);
}

TEST_F(VisibleViews, IdsOfTheLastViewAreShown) {
  auto together = make(true);
  auto apart = make(false);
  ASSERT_TRUE(together && apart);
  const auto views = eyes(3);
  std::vector<Image> shown;
  for (Engine* engine : {together.get(), apart.get()}) {
    engine->findVisible(views);
    ASSERT_TRUE(engine->place(views));
    engine->shade(views[1]);
    engine->display(views[2], DisplayMode::Deferred);
    shown.push_back(engine->readColor());
    auto ids = engine->debugView(DebugView::Ids, views[2]);
    ASSERT_TRUE(ids) << ids.error().message;
    shown.push_back(*ids);
  }
  EXPECT_EQ(shown[0].pixels, shown[2].pixels);
  EXPECT_EQ(shown[1].pixels, shown[3].pixels);
  // Not the first view's, nor empty.
  together->findVisible({views.data(), 1});
  auto first = together->debugView(DebugView::Ids, views[0]);
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_NE(first->pixels, shown[1].pixels);
}

TEST_F(VisibleViews, AViewThatComesAgainIsDrawnOnce) {
  EngineOptions options;
  options.visiblePixels = true;
  auto engine = make(false, boards(), options);
  ASSERT_TRUE(engine);
  const auto views = eyes(2);
  const auto pixels = [&](const std::vector<View>& of) {
    engine->findVisible(of);
    const auto counts = engine->readVisiblePixels();
    return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  };
  const auto once = pixels({views[0], views[1]});
  EXPECT_GT(once, 1000u);
  EXPECT_EQ(pixels({views[0], views[0], views[0], views[1], views[1]}), once);
  // Only of neighbours, as predicted views are: the first again counts.
  EXPECT_GT(pixels({views[0], views[1], views[0]}), once);
}

TEST_F(VisibleViews, PixelsAreCountedOverAllViews) {
  for (const GathererKind kind : {GathererKind::Rect, GathererKind::Tess})
    for (const bool layers : {true, false}) {
      EngineOptions options;
      options.visiblePixels = true;
      options.gatherer = kind;
      auto engine = make(layers, boards(), options);
      ASSERT_TRUE(engine);
      auto views = eyes(3);
      for (View& view : views) view.fovY = 2.4;  // past the boards' edges
      std::map<std::uint32_t, std::uint32_t> expected;
      std::uint32_t empty = 0;
      for (const View& view : views) {
        engine->findVisible({&view, 1});
        for (const std::uint32_t id : engine->readIds())
          if (id != 0)
            ++expected[kind == GathererKind::Tess ? id - 4 : (id >> 2U) - 1];
          else
            ++empty;
      }
      engine->findVisible(views);
      EXPECT_GT(empty, 100u);
      EXPECT_NEAR(engine->readBackgroundShare() * 3 * views[0].width * views[0].height, empty, 0.01);
      const auto numbers = engine->visibleSet()->read();
      const auto pixels = engine->readVisiblePixels();
      ASSERT_EQ(pixels.size(), numbers.size());
      std::map<std::uint32_t, std::uint32_t> counted;
      std::uint32_t blended = 0;
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        const DrawScene& draw = engine->drawScene();
        const std::uint32_t patch = kind == GathererKind::Tess ? numbers[i] / 4 : numbers[i];
        const Instance& instance = draw.instances[draw.instanceOfPatch[patch]];
        const std::uint32_t material = engine->scene().primitives[instance.primitive].material;
        // Ids are of what is opaque.
        if (engine->scene().materials[material].alphaMode == AlphaMode::Blend)
          blended += pixels[i];
        else
          counted[numbers[i]] = pixels[i];
      }
      EXPECT_GT(blended, 100u);
      EXPECT_EQ(counted, expected);
      EXPECT_GT(expected.size(), 20u);
    }
  auto without = make(true);
  ASSERT_TRUE(without);
  auto wide = eyes(1);
  wide[0].fovY = 2.4;
  without->findVisible(wide);
  EXPECT_TRUE(without->readVisiblePixels().empty());
  const auto ids = without->readIds();
  const auto empty = static_cast<double>(std::count(ids.begin(), ids.end(), 0u));
  EXPECT_GT(empty, 100.0);
  EXPECT_NEAR(without->readBackgroundShare() * static_cast<double>(ids.size()), empty, 0.01);
}

}  // namespace
}  // namespace tessera
