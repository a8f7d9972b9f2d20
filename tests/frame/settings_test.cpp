// What an engine changes without being made anew: the atlas' format by every gatherer, and shadow maps.
#include <cstdio>

#include "engine/frame/engine.hpp"
#include "engine/measure/metrics.hpp"
#include "tests/frame/pictures.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using Settings = test::GlTest;

View frontView() { return lookAt({0, 0, 0}, {0, 0, -1}, 60.0, 320, 240, 0.01); }

std::unique_ptr<Engine> make() {
  EngineOptions options;
  options.atlas.memory.width = options.atlas.memory.height = 1024;
  options.splitEdges = 0.0;
  options.shadowSize = 256;
  options.request.displayDeferred = true;
  auto engine = Engine::create(test::context(), test::everythingScene(), test::lampStage(), options);
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return nullptr;
  }
  (*engine)->update(0.0);
  return std::move(*engine);
}

Result<void> useFormat(Engine& engine, GathererKind kind, AtlasFormat format) {
  if (kind == GathererKind::Tess) {
    TessAtlasOptions tess;
    tess.memory.width = tess.memory.height = 1024;
    tess.format = format;
    return engine.remakeAtlas(tess);
  }
  if (kind == GathererKind::Texel) return engine.remakeAtlas(TexelAtlasOptions{.format = format});
  RectAtlasOptions rect;
  rect.memory.width = rect.memory.height = 1024;
  rect.format = format;
  return engine.remakeAtlas(rect);
}

TEST_F(Settings, EveryFormatShowsThePictureThatHalfFloatsDo) {
  auto engine = make();
  ASSERT_TRUE(engine);
  const View view = frontView();
  const std::pair<AtlasFormat, const char*> formats[] = {{AtlasFormat::Rgb10a2, "rgb10a2"},
                                                         {AtlasFormat::R11g11b10f, "r11g11b10f"},
                                                         {AtlasFormat::Srgb8, "srgb8"}};
  for (const GathererKind kind : {GathererKind::Rect, GathererKind::Tess, GathererKind::Texel})
    for (const DisplayMode mode : {DisplayMode::Geometry, DisplayMode::Deferred}) {
      ASSERT_TRUE(useFormat(*engine, kind, AtlasFormat::Rgba16f));
      engine->rect(view, mode);
      const Image exact = engine->readColor();
      const std::size_t bytes = engine->gatherer()->bytes();
      for (const auto& [format, name] : formats) {
        ASSERT_TRUE(useFormat(*engine, kind, format));
        engine->rect(view, mode);
        const auto quality = psnr(exact, engine->readColor());
        ASSERT_TRUE(quality);
        std::printf("gatherer %d, %s, %s: %.1f dB\n", static_cast<int>(kind),
                    mode == DisplayMode::Geometry ? "geometry" : "deferred", name, *quality);
        // Mixing up what is encoded and what is linear costs far more than any format's steps.
        EXPECT_GT(*quality, 36.0) << name;
        EXPECT_EQ(engine->nonFiniteTexels(), 0u) << name;
        EXPECT_LT(engine->gatherer()->bytes(), bytes) << name << " is half as large";
      }
    }
}

TEST_F(Settings, ShadowMapsChangeAndComeBack) {
  auto engine = make();
  ASSERT_TRUE(engine);
  const View view = frontView();
  const auto forward = [&] {
    engine->update(0.0);
    engine->forward(view);
    return engine->readColor().pixels;
  };
  const auto first = forward();
  engine->setShadowFilter(false);
  EXPECT_NE(forward(), first) << "edges of texels show";
  engine->setShadowFilter(true);
  EXPECT_EQ(forward(), first);
  ASSERT_TRUE(engine->setShadowSize(64));
  EXPECT_NE(forward(), first);
  engine->setShadowFilter(false);
  ASSERT_TRUE(engine->setShadowSize(256));
  EXPECT_NE(forward(), first) << "a new map has the filter that was set before";
  engine->setShadowFilter(true);
  EXPECT_EQ(forward(), first);
  for (const int bad : {0, -1, 63, 8193}) {
    const auto refused = engine->setShadowSize(bad);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find(std::to_string(bad)), std::string::npos)
        << refused.error().message;
  }
  EXPECT_EQ(forward(), first);
}

}  // namespace
}  // namespace tessera
