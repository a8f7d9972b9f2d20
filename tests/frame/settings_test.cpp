// What an engine changes without being made anew: the atlas' format by every gatherer, and shadow maps.
#include <cstdio>
#include <limits>

#include "engine/frame/engine.hpp"
#include "engine/measure/metrics.hpp"
#include "tests/frame/pictures.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using Settings = test::GlTest;

View frontView() { return lookAt({0, 0, 0}, {0, 0, -1}, 60.0, 320, 240, 0.01); }

std::unique_ptr<Engine> make(const NumericForms& forms = {}) {
  EngineOptions options;
  options.forms = forms;
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
  engine->setShadowFilter(ShadowFilter::Nearest);
  EXPECT_NE(forward(), first) << "edges of texels show";
  engine->setShadowFilter(ShadowFilter::Linear);
  EXPECT_EQ(forward(), first);
  engine->setShadowFilter(ShadowFilter::Wide);
  EXPECT_NE(forward(), first) << "edges are soft";
  engine->setShadowFilter(ShadowFilter::Linear);
  EXPECT_EQ(forward(), first);
  ASSERT_TRUE(engine->setShadowSize(64));
  EXPECT_NE(forward(), first);
  engine->setShadowFilter(ShadowFilter::Nearest);
  ASSERT_TRUE(engine->setShadowSize(256));
  EXPECT_NE(forward(), first) << "a new map has the filter that was set before";
  engine->setShadowFilter(ShadowFilter::Linear);
  EXPECT_EQ(forward(), first);
  for (const int bad : {0, -1, 63, 8193}) {
    const auto refused = engine->setShadowSize(bad);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find(std::to_string(bad)), std::string::npos)
        << refused.error().message;
  }
  EXPECT_EQ(forward(), first);
}

/// The picture of a frame by one gatherer.
Image shot(Engine& engine, GathererKind kind, const View& view) {
  EXPECT_TRUE(useFormat(engine, kind, AtlasFormat::Srgb8));
  engine.rect(view, DisplayMode::Geometry);
  return engine.readColor();
}

// On a scene that is not hard the forms that textbooks print draw what the stable ones do, but for samples
// that are even on the surface: those blur the floor at the camera's feet.
TEST_F(Settings, EveryFormDrawsTheScene) {
  struct Form {
    const char* name;
    bool NumericForms::*field;
    double least, most;  // dB to the picture of the stable form, the worse of rect's and tess's
  };
  constexpr double kEqual = std::numeric_limits<double>::infinity();
  const Form forms[] = {{"angles", &NumericForms::anglesByCross, 50, 90},
                        {"areas", &NumericForms::areasByKahan, 50, kEqual},
                        {"samples", &NumericForms::perspectiveSamples, 15, 30},
                        {"positions", &NumericForms::cameraRelative, 50, 95},
                        {"depth", &NumericForms::reversedDepth, 50, kEqual}};
  const View view = frontView();
  auto stable = make();
  ASSERT_TRUE(stable);
  for (const Form& form : forms) {
    NumericForms other;
    other.*form.field = false;
    auto engine = make(other);
    ASSERT_TRUE(engine) << form.name;
    double worst = kEqual;
    for (const GathererKind kind : {GathererKind::Rect, GathererKind::Tess}) {
      const auto quality = psnr(shot(*stable, kind, view), shot(*engine, kind, view));
      ASSERT_TRUE(quality);
      worst = std::min(worst, *quality);
    }
    std::printf("%s: %.1f dB\n", form.name, worst);
    EXPECT_GE(worst, form.least) << form.name;
    EXPECT_LE(worst, form.most) << form.name;
  }
}

// The lengths of edges have errors of their own, so areas by either formula draw alike: what is compiled says
// which it is.
TEST_F(Settings, FormsReachTheShaders) {
  NumericForms other;
  other.anglesByCross = other.areasByKahan = other.perspectiveSamples = false;
  auto engine = make(other);
  ASSERT_TRUE(engine);
  ASSERT_FALSE(engine->permutations().empty());
  for (const std::string& program : engine->permutations())
    for (const char* define : {"ANGLES_BY_ACOS", "AREAS_BY_HERON", "SURFACE_SAMPLES"})
      EXPECT_NE(program.find(define), std::string::npos) << program;
}

TEST_F(Settings, WarpingNeedsReversedDepth) {
  EngineOptions options;
  options.request.warp = true;
  options.forms.reversedDepth = false;
  const auto engine = Engine::create(test::context(), test::everythingScene(), test::lampStage(), options);
  ASSERT_FALSE(engine);
  EXPECT_NE(engine.error().message.find("reversedDepth"), std::string::npos) << engine.error().message;
}

}  // namespace
}  // namespace tessera
