// What a viewer decodes is what the server shaded: the same view is shaded here, and the blocks of both
// atlases hold the same colours. Places may differ, so sums over blocks are compared.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <map>
#include <thread>

#include <gtest/gtest.h>

#include "codec/transport/client.hpp"
#include "codec/video.hpp"
#include "codec/wire/framing.hpp"
#include "codec/wire/handshake.hpp"
#include "codec/wire/visible_mirror.hpp"
#include "engine/scene/gltf.hpp"
#include "engine/stream/feed.hpp"
#include "tests/serve/program.hpp"

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;
const std::string kAssets = TESSERA_SOURCE_DIR "/assets/";
constexpr int kSeconds = 60;  // that anything may take on a busy machine

View view() { return lookAt({10.2, 1.75, 4.1}, {0.0, 2.4, -0.4}, 60.0, 320, 180, 0.05); }

/// Of blocks of an atlas whose rows are the texture's, as video has them.
struct Mean {
  glm::dvec3 color{0.0};
  double texels = 0.0;
  std::size_t blocks = 0;
  void add(const Image& atlas, std::uint32_t origin, std::uint32_t level) {
    const std::uint32_t x = origin & 0xffffu;
    const std::uint32_t y = origin >> 16u;
    const std::uint32_t width = 1u << glsl::levelWidth(level);
    const std::uint32_t height = 1u << glsl::levelHeight(level);
    ASSERT_LE(x + width, static_cast<std::uint32_t>(atlas.width));
    ASSERT_LE(y + height, static_cast<std::uint32_t>(atlas.height));
    for (std::uint32_t row = y; row < y + height; ++row)
      for (std::uint32_t column = x; column < x + width; ++column) {
        const std::size_t at = (std::size_t{row} * static_cast<std::size_t>(atlas.width) + column) * 4;
        for (int i = 0; i < 3; ++i) color[i] += atlas.pixels[at + static_cast<std::size_t>(i)];
      }
    texels += width * height;
    ++blocks;
  }
  [[nodiscard]] glm::dvec3 mean() const { return color / texels; }
};

/// What the engine gathers from the stream's view.
void shadeHere(int width, int height, Mean& mean) {
  auto context = gl::Context::createOsMesa();
  ASSERT_TRUE(context) << context.error().message;
  auto scene = loadGltf(kAssets + "atrium.glb", {.loadImages = true, .progress = {}});
  ASSERT_TRUE(scene) << scene.error().message;
  auto stage = loadStage(kAssets + "stages/atrium.json");
  ASSERT_TRUE(stage) << stage.error().message;
  EngineOptions options;
  options.request = {.rect = true, .displayGeometry = true, .displayDeferred = false, .forward = false};
  options.atlas.memory.width = width;
  options.atlas.memory.height = height;
  auto engine = Engine::create(**context, std::move(*scene), std::move(*stage), options);
  ASSERT_TRUE(engine) << engine.error().message;
  (*engine)->update(0.0);
  const View one = view();
  (*engine)->findVisible(std::span(&one, 1));
  ASSERT_TRUE((*engine)->place(std::span(&one, 1)));
  (*engine)->shade(one);
  const Image top = (*engine)->readAtlas();
  Image atlas = top;
  const std::size_t row = static_cast<std::size_t>(top.width) * 4;
  for (std::size_t y = 0; y < static_cast<std::size_t>(top.height); ++y)
    std::copy_n(top.pixels.end() - static_cast<std::ptrdiff_t>((y + 1) * row), row,
                atlas.pixels.begin() + static_cast<std::ptrdiff_t>(y * row));
  for (const glsl::PatchState& state : (*engine)->atlas()->memory().readVisible())
    if (glsl::levelTexels(state.level) > 1) mean.add(atlas, state.origin, state.level);
}

TEST(ServeAtlas, WhatIsDecodedIsWhatWasShaded) {
  test::Program server({"serve", kAssets + "atrium.glb", "--listen", "127.0.0.1:0", "--context", "osmesa",
                        "--atlas-mpix", "1", "--bitrate", "40M", "--fps", "10", "--prediction", "none",
                        "--margin-deg", "0"});
  ASSERT_TRUE(server.waitFor("libx264", kSeconds)) << server.said();
  transport::ClientOptions connecting;
  connecting.server = *transport::parseAddress(server.after("listening on "));
  auto client = transport::Client::start(connecting);
  ASSERT_TRUE(client) << client.error().message;
  const auto say = [&](const wire::Message& message) {
    const auto bytes = wire::encode(message);
    ASSERT_TRUE(bytes);
    (void)(*client)->send(*bytes);
  };
  wire::MessageParser parser(wire::Role::Server);
  std::optional<wire::VisibleMirror> mirror;
  std::optional<wire::StreamSetup> setup;
  auto decoder = VideoDecoder::create();
  ASSERT_TRUE(decoder);
  std::map<std::uint32_t, Mean> byFrame;  // of frames whose geometry and picture have come
  std::map<std::uint32_t, std::vector<glsl::StreamedPatch>> geometry;
  std::map<std::uint32_t, Image> pictures;
  std::uint32_t poses = 0;
  const Clock::time_point end = Clock::now() + std::chrono::seconds(kSeconds);
  while (byFrame.size() < 4 && Clock::now() < end) {
    for (transport::ClientEvent& event : (*client)->poll()) {
      if (std::holds_alternative<transport::Connected>(event)) {
        say(wire::Hello{wire::kSpoken, wire::Role::Viewer, ""});
      } else if (auto* bytes = std::get_if<transport::ServerMessage>(&event)) {
        parser.feed(bytes->bytes);
        while (true) {
          auto next = parser.next();
          ASSERT_TRUE(next) << next.error().message;
          if (!*next) break;
          if (const auto* said = std::get_if<wire::StreamSetup>(&**next)) {
            setup = *said;
            mirror.emplace(said->method, wire::AtlasSize{said->width, said->height});
          } else if (const auto* changes = std::get_if<wire::Geometry>(&**next)) {
            ASSERT_TRUE(mirror);
            ASSERT_TRUE(mirror->apply(changes->changes));
            auto& patches = geometry[changes->frame];
            std::vector<bool> taken(mirror->patches().size());
            for (const glsl::StreamedTriangle& triangle : mirror->triangles()) {
              if (triangle.owner == glsl::kNoOwner) continue;
              const std::uint32_t element = glsl::ownerElement(triangle.owner);
              if (!taken[element]) patches.push_back(mirror->patches()[element]);
              taken[element] = true;
            }
          }
        }
      } else if (auto* video = std::get_if<transport::VideoFrame>(&event)) {
        const Decoded decoded = decoder->decode(video->frame.bytes);
        if (decoded.wantsIFrame) say(wire::AskIFrame{});
        if (!decoded.picture) continue;
        auto picture = toRgb(*decoded.picture);
        ASSERT_TRUE(picture) << picture.error().message;
        pictures[static_cast<std::uint32_t>(decoded.frame)] = std::move(*picture);
      }
    }
    for (const auto& [frame, patches] : geometry) {
      const auto picture = pictures.find(frame);
      if (picture == pictures.end() || byFrame.contains(frame)) continue;
      for (const glsl::StreamedPatch& patch : patches)
        if (glsl::levelTexels(patch.level) > 1)
          byFrame[frame].add(picture->second, patch.origin, patch.level);
    }
    if (setup) {
      wire::Pose pose;
      pose.number = ++poses;
      pose.time = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
      pose.camera = cameraOf(view());
      say(pose);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_GE(byFrame.size(), 4u) << server.said();
  EXPECT_EQ(server.end(SIGTERM), 0) << server.said();
  // Below the blocks lies a texel for each patch instance.
  Mean here;
  ASSERT_NO_FATAL_FAILURE(shadeHere(1024, 1024, here));
  ASSERT_GT(here.blocks, 100u);
  ASSERT_EQ(setup->width, 1024u);
  for (const auto& [frame, there] : byFrame) {
    SCOPED_TRACE(frame);
    // Some things in the scene move.
    EXPECT_NEAR(double(there.blocks), double(here.blocks), 0.05 * double(here.blocks));
    EXPECT_NEAR(there.texels, here.texels, 0.05 * here.texels);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(there.mean()[i], here.mean()[i], 2.0) << i;
  }
}

}  // namespace
}  // namespace tessera
