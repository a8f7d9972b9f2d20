// The viewer's picture against the engine's own display of the same atlas.
#include "engine/view/display.hpp"

#include "engine/measure/metrics.hpp"
#include "engine/stream/feed.hpp"
#include "engine/view/camera.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"
#include "tests/view/streamed.hpp"

namespace tessera {
namespace {

using ViewDisplay = test::GlTest;

struct Pictures {
  Image engine;
  Image viewer;
  std::uint64_t uncovered = 0;
};

/// Shaded for one view, displayed for another.
Pictures drawn(Scene scene, GathererKind gatherer, const View& shaded, const View& shown) {
  Pictures pictures;
  test::Streamed both = test::streamed(std::move(scene), gatherer, shaded);
  if (!both) return pictures;
  both.engine->display(shown);
  pictures.engine = both.engine->readColor();
  both.display->draw(cameraOf(shown));
  pictures.viewer = both.display->read();
  pictures.uncovered = both.display->uncovered().value_or(0);
  return pictures;
}

View corner(const glm::dvec3& eye) { return lookAt(eye, {1.8, 1.0, -2.0}, 60.0, 320, 240, 0.05); }

void compare(GathererKind gatherer) {
  const View shaded = corner({3.0, 2.0, 2.0});
  for (const glm::dvec3& eye : {glm::dvec3(3.0, 2.0, 2.0), glm::dvec3(2.7, 2.1, 1.8)}) {
    const Pictures pictures = drawn(test::cornerScene(), gatherer, shaded, corner(eye));
    const double quality = test::psnrOf(pictures.engine, pictures.viewer);
    std::printf("PSNR %.2f dB, %llu pixels uncovered\n", quality,
                static_cast<unsigned long long>(pictures.uncovered));
    EXPECT_GE(quality, 40.0);
    std::uint64_t holes = 0;
    for (std::size_t i = 3; i < pictures.engine.pixels.size(); i += 4)
      holes += pictures.engine.pixels[i] == 0;
    EXPECT_NEAR(static_cast<double>(pictures.uncovered), static_cast<double>(holes), 40.0);
    EXPECT_GT(holes, 0u);
  }
}

TEST_F(ViewDisplay, EqualsTheEnginesRect) { compare(GathererKind::Rect); }
TEST_F(ViewDisplay, EqualsTheEnginesTess) { compare(GathererKind::Tess); }

/// The corner behind a leaf with a checkered mask.
Scene leafScene() {
  Scene scene = test::cornerScene();
  Material leaf = test::unlit();
  leaf.alphaMode = AlphaMode::Mask;
  leaf.doubleSided = true;
  leaf.baseColor.image = test::addCheckers(scene, 64, 4, true);
  const auto material = test::addMaterial(scene, leaf);
  test::place(scene, test::addGrid(scene, {2.0f, 0.8f, -0.5f}, {0.8f, 0, 0}, {0, 0.8f, 0}, 2, 2, material));
  test::finish(scene);
  return scene;
}

void compareMasked(GathererKind gatherer) {
  const View view = corner({3.0, 2.0, 2.0});
  const Pictures pictures = drawn(leafScene(), gatherer, view, view);
  EXPECT_GE(test::psnrOf(pictures.engine, pictures.viewer), 35.0);
  // Holes show what is behind, and what is behind was not hidden when it was shaded.
  const Pictures without = drawn(test::cornerScene(), gatherer, view, view);
  std::size_t leaf = 0;
  std::size_t holes = 0;
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) {
      const auto differs = [&](const Image& a, const Image& b) {
        int most = 0;
        for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(a.at(x, y)[c] - b.at(x, y)[c]));
        return most > 24;
      };
      const bool engine = differs(pictures.engine, without.engine);
      leaf += engine ? 1 : 0;
      holes += engine != differs(pictures.viewer, without.viewer) ? 1 : 0;
    }
  EXPECT_GT(leaf, 500u);
  EXPECT_LT(holes, leaf / 20);
}

TEST_F(ViewDisplay, MasksHaveTheirHolesRect) { compareMasked(GathererKind::Rect); }
TEST_F(ViewDisplay, MasksHaveTheirHolesTess) { compareMasked(GathererKind::Tess); }

TEST_F(ViewDisplay, TheLensIsTheEnginesForEachEye) {
  const View view = corner({3.0, 2.0, 2.0});
  const Lens lens{0.5, 0.3, {0.98, 1.0, 1.03}};
  test::Streamed both = test::streamed(test::cornerScene(), GathererKind::Rect, view, {.lens = lens});
  ASSERT_TRUE(both);
  const auto engines = [&](const View& shown) {
    both.engine->display(shown);
    auto bent = both.engine->distort(lens);
    EXPECT_TRUE(bent) << bent.error().message;
    return both.engine->readColor();
  };
  both.display->draw(cameraOf(view));
  const Image one = both.display->read();
  EXPECT_GE(test::psnrOf(engines(view), one), 40.0);
  both.engine->display(view);
  const auto straight = psnr(both.engine->readColor(), one);
  ASSERT_TRUE(straight);
  EXPECT_LT(*straight, 25.0) << "no lens";

  // An odd width: the last column belongs to no eye.
  constexpr double kEyeDistance = 0.3;
  View wide = view;
  wide.width = 2 * view.width + 1;
  wire::Camera camera = view::resized(cameraOf(view), static_cast<std::uint32_t>(wide.width),
                                      static_cast<std::uint32_t>(view.height));
  both.display->drawStereo(camera, kEyeDistance);
  const Image pair = both.display->read();
  ASSERT_EQ(pair.width, wide.width);
  const auto eyes = stereoViews(view, kEyeDistance);
  for (int side = 0; side < 2; ++side) {
    Image half{view.width, view.height, std::vector<std::uint8_t>(one.pixels.size())};
    for (int y = 0; y < half.height; ++y)
      std::copy_n(pair.at(side * view.width, y), static_cast<std::size_t>(4 * half.width), half.at(0, y));
    EXPECT_GE(test::psnrOf(engines(eyes[static_cast<std::size_t>(side)]), half), 40.0) << side;
  }
  EXPECT_EQ(pair.at(pair.width - 1, 7)[3], 0);
}

TEST_F(ViewDisplay, RefusesALensThatFolds) {
  const auto display = view::StreamedDisplay::create(test::context(), {.lens = Lens{-1.0, 0.0, {1, 1, 1}}});
  ASSERT_FALSE(display);
  EXPECT_NE(display.error().message.find("lens"), std::string::npos) << display.error().message;
}

TEST_F(ViewDisplay, ShowsTheBackgroundBeforeTheFirstFrame) {
  auto display = view::StreamedDisplay::create(test::context());
  ASSERT_TRUE(display) << display.error().message;
  EXPECT_FALSE(display->uncovered());
  display->draw(view::lookAt({0, 0, 0}, {0, 0, -1}, 60.0, 32, 16, 0.1));
  EXPECT_EQ(display->uncovered(), 32u * 16u);
  EXPECT_EQ(display->read().pixels[3], 0);
}

}  // namespace
}  // namespace tessera
