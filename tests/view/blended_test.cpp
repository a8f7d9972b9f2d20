// Glass in a stream: the viewer's picture against the engine's own, which shades glass as it draws it.
#include <algorithm>
#include <cstdlib>

#include "engine/stream/feed.hpp"
#include "engine/view/camera.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"
#include "tests/view/streamed.hpp"

namespace tessera {
namespace {

using Blended = test::GlTest;

Material glass(const glm::vec4& color) {
  Material material = test::unlit();
  material.alphaMode = AlphaMode::Blend;
  material.doubleSided = true;
  material.baseColorFactor = color;
  return material;
}

View from(const glm::dvec3& eye) { return lookAt(eye, {0, 0, -2.5}, 50.0, 320, 240, 0.05); }

/// A wall on either side, and in between a red pane and a blue one, half a metre apart; the red one is in
/// front for who looks along -z. With `sheet`, one more pane before them whose alpha is an image's.
Scene panes(bool sheet = false) {
  Scene scene = test::emptyScene();
  Material solid = test::unlit();
  solid.doubleSided = true;
  const auto wall = test::addMaterial(scene, solid);
  test::place(scene, test::addGrid(scene, {-3, -2, -5}, {6, 0, 0}, {0, 4, 0}, 6, 4, wall, true));
  test::place(scene, test::addGrid(scene, {-0.3f, -2, -1.2f}, {0.2f, 0, 0}, {0, 1.2f, 0}, 1, 2, wall, true));
  const auto red = test::addMaterial(scene, glass({0.9f, 0.1f, 0.1f, 0.6f}));
  const auto blue = test::addMaterial(scene, glass({0.1f, 0.1f, 0.9f, 0.6f}));
  test::place(scene, test::addGrid(scene, {-0.8f, -0.8f, -2.5f}, {1.2f, 0, 0}, {0, 1.4f, 0}, 3, 3, red));
  test::place(scene, test::addGrid(scene, {-0.4f, -0.5f, -3.0f}, {1.4f, 0, 0}, {0, 1.4f, 0}, 3, 3, blue));
  if (sheet) {
    Material material = glass({0.9f, 1.0f, 0.4f, 0.8f});
    material.baseColor.image = test::addCheckers(scene, 64, 4, true);
    test::place(scene, test::addGrid(scene, {-0.2f, -0.2f, -2.0f}, {0.7f, 0, 0}, {0, 0.6f, 0}, 2, 2,
                                     test::addMaterial(scene, material)));
  }
  // A part of the red pane's alpha is its corners'.
  Primitive& own = scene.primitives[2];
  own.hasColor = true;
  for (std::uint32_t i = 0; i < own.vertexCount; ++i) scene.vertices.color[own.firstVertex + i].a = 0.8f;
  test::finish(scene);
  return scene;
}

/// Pixels of which a channel differs by more than `most`.
int differing(const Image& a, const Image& b, int most) {
  int count = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      int worst = 0;
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(a.at(x, y)[c] - b.at(x, y)[c]));
      count += worst > most ? 1 : 0;
    }
  return count;
}

void compare(GathererKind gatherer, bool sheet, double bound) {
  const View front = from({0.2, 0.2, 0.5});
  const View beside = from({-0.1, 0.3, 0.4});
  const View back = from({0.1, -0.2, -4.9});
  for (const auto& [shaded, shown] :
       {std::pair(front, front), std::pair(front, beside), std::pair(back, back)}) {
    test::Streamed both = test::streamed(panes(sheet), gatherer, shaded);
    ASSERT_TRUE(both);
    both.engine->display(shown);
    const Image engine = both.engine->readColor();
    both.display->draw(cameraOf(shown));
    const Image viewer = both.display->read();
    const double quality = test::psnrOf(engine, viewer);
    std::printf("PSNR %.2f dB\n", quality);
    EXPECT_GE(quality, bound);
    // In a wrong order, or not blended, whole panes are of another colour.
    EXPECT_LT(differing(engine, viewer, 24), engine.width * engine.height / 100);
  }
}

TEST_F(Blended, PanesEqualTheEnginesRect) { compare(GathererKind::Rect, false, 45.0); }
TEST_F(Blended, PanesEqualTheEnginesTess) { compare(GathererKind::Tess, false, 45.0); }
TEST_F(Blended, SheetsWithAnImagesAlphaRect) { compare(GathererKind::Rect, true, 42.0); }
TEST_F(Blended, SheetsWithAnImagesAlphaTess) { compare(GathererKind::Tess, true, 42.0); }

}  // namespace
}  // namespace tessera
