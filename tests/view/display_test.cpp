// The viewer's picture against the engine's own display of the same atlas.
#include "engine/view/display.hpp"

#include "codec/video.hpp"
#include "engine/measure/metrics.hpp"
#include "engine/stream/feed.hpp"
#include "engine/view/camera.hpp"
#include "engine/yuv/packer.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using ViewDisplay = test::GlTest;

struct Pictures {
  Image engine;
  Image viewer;
  std::uint64_t uncovered = 0;
};

double psnrOf(const Pictures& pictures) {
  const auto value = psnr(pictures.engine, pictures.viewer);
  if (!value) ADD_FAILURE() << value.error().message;
  return value.value_or(0.0);
}

/// Through H.264, with little loss.
YuvImage coded(const YuvImage& planes) {
  EncoderOptions options;
  options.width = planes.width;
  options.height = planes.height;
  options.chroma = planes.chroma;
  options.rate = RateControl::ConstantQuality;
  options.quality = 12.0;
  options.encoders = {"libx264"};
  auto encoder = VideoEncoder::create(options);
  auto decoder = VideoDecoder::create();
  if (!encoder || !decoder) {
    ADD_FAILURE() << (encoder ? decoder.error().message : encoder.error().message);
    return planes;
  }
  const auto packet = encoder->encode(planes.view(), 1);
  if (!packet) {
    ADD_FAILURE() << packet.error().message;
    return planes;
  }
  const Decoded decoded = decoder->decode(packet->bytes);
  if (!decoded.picture) {
    ADD_FAILURE() << decoded.detail;
    return planes;
  }
  auto rgb = toRgb(*decoded.picture);
  return std::move(*toYuv(*rgb, planes.chroma));
}

/// Shaded for one view, displayed for another.
Pictures drawn(Scene scene, GathererKind gatherer, const View& shaded, const View& shown) {
  Pictures pictures;
  EngineOptions options;
  options.gatherer = gatherer;
  options.request.forward = false;
  options.atlas.memory.width = options.atlas.memory.height = 1024;
  // Before the engine takes the scene, which keeps no pixels.
  auto masks = std::make_shared<const std::vector<wire::MaskImage>>(masksOf(scene));
  auto engine = Engine::create(test::context(), std::move(scene), std::nullopt, options);
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return pictures;
  }
  Engine& e = **engine;
  e.update(0.0);
  e.findVisible({&shaded, 1});
  if (auto placed = e.place({&shaded, 1}); !placed) ADD_FAILURE() << placed.error().message;
  e.shade(shaded);
  e.display(shown);
  pictures.engine = e.readColor();

  const GeometryFeed feed(e);
  wire::VisibleDelta delta(feed.source());
  const auto elements = feed.visible(e);
  const auto objects = feed.objects(e);
  const wire::Camera camera = cameraOf(shaded);
  const auto message = delta.next({elements, objects, {}, wire::boundOf(camera, 0.01, 0.0), camera.eye});
  const gl::Texture& atlas = e.gatherer()->atlas().encoded;
  auto packer = YuvPacker::create(test::context(), atlas.width(), atlas.height(), Chroma::Yuv444);
  if (!packer || !packer->pack(atlas, 1)) {
    ADD_FAILURE() << "the atlas gives no planes";
    return pictures;
  }
  const YuvImage planes = packer->read()->planes;
  view::ShadedFrame frame;
  frame.atlas = coded(planes);
  frame.header.camera = camera;
  wire::VisibleMirror mirror(feed.source().method, {static_cast<std::uint32_t>(planes.width),
                                                    static_cast<std::uint32_t>(planes.height)});
  if (auto applied = mirror.apply(message); !applied) ADD_FAILURE() << applied.error().message;
  frame.masks = std::move(masks);
  frame.take(mirror);

  auto display = view::StreamedDisplay::create(test::context());
  if (!display) {
    ADD_FAILURE() << display.error().message;
    return pictures;
  }
  if (auto uploaded = display->upload(frame); !uploaded) ADD_FAILURE() << uploaded.error().message;
  display->draw(cameraOf(shown));
  pictures.viewer = display->read();
  pictures.uncovered = display->uncovered().value_or(0);
  return pictures;
}

View corner(const glm::dvec3& eye) { return lookAt(eye, {1.8, 1.0, -2.0}, 60.0, 320, 240, 0.05); }

void compare(GathererKind gatherer) {
  const View shaded = corner({3.0, 2.0, 2.0});
  for (const glm::dvec3& eye : {glm::dvec3(3.0, 2.0, 2.0), glm::dvec3(2.7, 2.1, 1.8)}) {
    const Pictures pictures = drawn(test::cornerScene(), gatherer, shaded, corner(eye));
    const double quality = psnrOf(pictures);
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
  EXPECT_GE(psnrOf(pictures), 35.0);
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
