// How many bytes the geometry of real camera paths takes, and how far its vertices are off.
#include "tests/wire/rates.hpp"

#include <cstdlib>
#include <filesystem>

#include "codec/wire/visible_mirror.hpp"
#include "engine/scene/gltf.hpp"
#include "tests/gl_test.hpp"
#include "tests/wire/engine_feed.hpp"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using WireRates = test::GlTest;

int framesWanted() {
  const char* frames = std::getenv("TESSERA_WIRE_FRAMES");
  return frames != nullptr ? std::atoi(frames) : 8;
}

// Frames of the tour at 30 a second, as a server shades them.
test::Recording record(const fs::path& file, const fs::path& stageFile, GathererKind gatherer, int frames) {
  test::Recording recording;
  auto stage = loadStage(stageFile);
  auto scene = loadGltf(file);
  if (!stage || !scene) {
    ADD_FAILURE() << (stage ? scene.error().message : stage.error().message);
    return recording;
  }
  const CameraPath path = stage->paths.front();
  const double zNear = defaultNear(*scene);
  EngineOptions options;
  options.gatherer = gatherer;
  options.request.forward = false;
  auto engine = Engine::create(test::context(), std::move(*scene), std::move(*stage), options);
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return recording;
  }
  (*engine)->update(0.0);
  const GeometryFeed feed(**engine);
  recording.source = feed.source();
  for (int i = 0; i < frames; ++i) {
    const double time = path.keys.front().time + 1.0 + i / 30.0;
    (*engine)->update(time);
    const View view = viewOf(sampleCamera(path, time), 1280, 720, zNear);
    (*engine)->findVisible({&view, 1});
    if (auto placed = (*engine)->place({&view, 1}); !placed) ADD_FAILURE() << placed.error().message;
    recording.frames.push_back({feed.visible(**engine), feed.objects(**engine), cameraOf(view)});
  }
  return recording;
}

void measure(const char* name, const fs::path& file, const char* stage, GathererKind gatherer) {
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
  const auto recording =
      record(file, fs::path(TESSERA_SOURCE_DIR) / "assets/stages" / stage, gatherer, framesWanted());
  if (testing::Test::HasFailure()) return;
  // Codecs are compared where all say the same; what a viewer remembers saves is apart.
  const test::Rates rates = test::ratesOf(recording, 0);
  const test::Rates remembering = test::ratesOf(recording, wire::DeltaOptions().keepFrames);
  const double plain = rates.first.plain + rates.rest.plain;
  const double sent = remembering.first.sent + remembering.rest.sent;
  std::printf(
      "%s, %zu frames\n%s  remembering: %.0f bytes a frame after the first, %.2f of plain, error %.4f\n",
      name, rates.frames, test::table(rates).c_str(),
      remembering.rest.sent / static_cast<double>(rates.frames - 1), plain / sent, remembering.largestError);
  EXPECT_LT(rates.largestError, 0.1) << "pixels";
  EXPECT_LT(remembering.largestError, 0.1) << "pixels";
  EXPECT_GT(rates.together(), 4.0);
  EXPECT_LE(sent, rates.first.sent + rates.rest.sent);
}

TEST_F(WireRates, AtriumRect) {
  measure("atrium, rect", fs::path(TESSERA_SOURCE_DIR) / "assets/atrium.glb", "atrium.json",
          GathererKind::Rect);
}
TEST_F(WireRates, AtriumTess) {
  measure("atrium, tess", fs::path(TESSERA_SOURCE_DIR) / "assets/atrium.glb", "atrium.json",
          GathererKind::Tess);
}
TEST_F(WireRates, SponzaRect) {
  measure("sponza, rect", fs::path(TESSERA_SHARED_DIR) / "scenes/sponza.glb", "sponza.json",
          GathererKind::Rect);
}
TEST_F(WireRates, SponzaTess) {
  measure("sponza, tess", fs::path(TESSERA_SHARED_DIR) / "scenes/sponza.glb", "sponza.json",
          GathererKind::Tess);
}

}  // namespace
}  // namespace tessera
