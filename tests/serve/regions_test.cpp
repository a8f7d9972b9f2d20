// Blocks with the pixels that show them, of a running engine: none is lost, none lies outside of the atlas.
#include "engine/stream/regions.hpp"

#include <numeric>

#include "engine/stream/feed.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using RegionsGl = test::GlTest;

/// A floor of two triangles right below the eye, which the tessellation gatherer splits, and a corner.
Scene floorScene() {
  Scene scene = test::cornerScene();
  test::place(scene, test::addGrid(scene, {-20, -0.5f, 20}, {40, 0, 0}, {0, 0, -40}, 1, 1));
  test::finish(scene);
  return scene;
}

void expectAllPixels(GathererKind kind) {
  EngineOptions options;
  options.gatherer = kind;
  options.visiblePixels = true;
  options.splitEdges = 0.0;
  options.atlas.memory.width = options.atlas.memory.height = 2048;
  auto made = Engine::create(test::context(), floorScene(), std::nullopt, options);
  ASSERT_TRUE(made) << made.error().message;
  Engine& engine = **made;
  engine.update(0.0);
  const std::array<View, 2> views = {lookAt({3.0, 1.5, 2.0}, {1.8, 0.5, -2.0}, 60.0, 320, 240, 0.05),
                                     lookAt({2.8, 1.5, 2.0}, {1.8, 0.5, -2.0}, 60.0, 320, 240, 0.05)};
  // Pieces are found from the frame on after the one that splits their triangle.
  for (int frame = 0; frame < 4; ++frame) {
    engine.findVisible(views);
    ASSERT_TRUE(engine.place(views));
  }
  const GeometryFeed feed(engine);
  const auto elements = feed.visible(engine);
  const auto blocks = shownBlocks(engine, elements);
  const auto pixels = engine.readVisiblePixels();
  const double all = std::accumulate(pixels.begin(), pixels.end(), 0.0);
  const gl::Texture& atlas = engine.gatherer()->atlas().encoded;
  double sum = 0.0;
  double pieces = 0.0;
  for (const ShownBlock& block : blocks) {
    sum += block.pixels;
    EXPECT_LE(block.x + block.width, static_cast<std::uint32_t>(atlas.width()));
    EXPECT_LE(block.y + block.height, static_cast<std::uint32_t>(atlas.height()));
  }
  for (const wire::VisibleElement& element : elements) pieces += element.parent != wire::kNone ? 1.0 : 0.0;
  EXPECT_GT(all, 100'000.0);
  EXPECT_NEAR(sum, all, 1e-6 * all);
  if (kind == GathererKind::Tess) {
    EXPECT_GE(pieces, 8.0);
  }
}

TEST_F(RegionsGl, PatchesHaveAllPixels) { expectAllPixels(GathererKind::Rect); }
TEST_F(RegionsGl, TrianglesAndPiecesHaveAllPixels) { expectAllPixels(GathererKind::Tess); }

}  // namespace
}  // namespace tessera
