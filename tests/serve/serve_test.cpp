// The server as a process: what viewers are sent, and that no viewer can end it.
#include <chrono>
#include <csignal>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/transport/client.hpp"
#include "codec/video.hpp"
#include "codec/wire/framing.hpp"
#include "codec/wire/handshake.hpp"
#include "codec/wire/message_order.hpp"
#include "codec/wire/visible_mirror.hpp"
#include "engine/stream/feed.hpp"
#include "tests/serve/program.hpp"

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;
const std::string kScene = TESSERA_SOURCE_DIR "/assets/atrium.glb";
constexpr int kSeconds = 60;  // that anything may take on a busy machine

/// A viewer without pictures: it keeps what it was sent.
class Watcher {
 public:
  explicit Watcher(const std::string& address) {
    transport::ClientOptions options;
    options.server = *transport::parseAddress(address);
    auto client = transport::Client::start(options);
    EXPECT_TRUE(client);
    if (client) client_ = std::move(*client);
    view_ = lookAt({-4, 1.7, 0}, {4, 1.5, 0}, 60.0, 320, 180, 0.05);
  }

  /// Takes what has come, moves a little, and says where it is.
  void step() {
    for (transport::ClientEvent& event : client_->poll()) {
      if (std::holds_alternative<transport::Connected>(event)) {
        ++connections;
        poses_ = lastPose = 0;
        parser_ = wire::MessageParser(wire::Role::Server);
        order_ = wire::MessageOrder(wire::Role::Server);
        mirror_.reset();
        say(wire::Hello{wire::kSpoken, wire::Role::Viewer, ""});
      } else if (auto* message = std::get_if<transport::ServerMessage>(&event)) {
        parser_.feed(message->bytes);
        while (true) {
          auto next = parser_.next();
          ASSERT_TRUE(next) << next.error().message;
          if (!*next) break;
          const auto allowed = order_.accept(**next);
          ASSERT_TRUE(allowed) << allowed.error().message;
          take(**next);
        }
      } else if (auto* video = std::get_if<transport::VideoFrame>(&event)) {
        const Decoded decoded = decoder_.decode(video->frame.bytes);
        if (decoded.picture) decodedFrames.push_back(static_cast<std::uint32_t>(decoded.frame));
        if (decoded.wantsIFrame) say(wire::AskIFrame{});
        if (decoded.picture && setup) {
          EXPECT_EQ(static_cast<std::uint32_t>(decoded.picture->height), setup->height);
        }
      }
    }
    if (!setup) return;
    view_.eye.x += stride;
    wire::Pose pose;
    pose.number = ++poses_;
    pose.time = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
    pose.camera = cameraOf(view_);
    say(pose);
  }
  void say(const wire::Message& message) {
    const auto bytes = wire::encode(message);
    ASSERT_TRUE(bytes);
    (void)client_->send(*bytes);
  }
  void shout(const std::string& text) {
    (void)client_->send(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  }
  [[nodiscard]] std::uint32_t elements() const { return mirror_ ? mirror_->liveElements() : 0; }

  std::optional<wire::StreamSetup> setup;
  std::vector<std::uint32_t> geometryFrames, decodedFrames;
  std::vector<wire::MaskImage> masks;
  std::vector<wire::Path> paths;
  double stride = 0.002;  // metres from pose to pose
  bool sawIFrame = false;
  int resets = 0;
  std::uint32_t lastPose = 0;
  std::vector<wire::SentLight> lights;
  int connections = 0;

 private:
  void take(const wire::Message& message) {
    if (const auto* said = std::get_if<wire::StreamSetup>(&message)) {
      setup = *said;
      mirror_.emplace(said->method, wire::AtlasSize{said->width, said->height});
    } else if (const auto* mask = std::get_if<wire::MaskImage>(&message)) {
      masks.push_back(*mask);
    } else if (const auto* path = std::get_if<wire::Path>(&message)) {
      paths.push_back(*path);
    } else if (const auto* frame = std::get_if<wire::FrameHeader>(&message)) {
      sawIFrame = sawIFrame || frame->iFrame;
      EXPECT_LE(frame->pose, poses_) << "a pose that was not sent";
      EXPECT_LE(lastPose, frame->pose) << "poses of frames go on";
      lastPose = frame->pose;
      resets += frame->atlasReset ? 1 : 0;
      EXPECT_TRUE(!frame->atlasReset || frame->iFrame) << frame->frame;
      lights = frame->lights;
    } else if (const auto* geometry = std::get_if<wire::Geometry>(&message)) {
      ASSERT_TRUE(mirror_);
      const auto applied = mirror_->apply(geometry->changes);
      ASSERT_TRUE(applied) << applied.error().message;
      geometryFrames.push_back(geometry->frame);
    }
  }

  std::unique_ptr<transport::Client> client_;
  wire::MessageParser parser_{wire::Role::Server};
  wire::MessageOrder order_{wire::Role::Server};
  std::optional<wire::VisibleMirror> mirror_;
  VideoDecoder decoder_ = std::move(*VideoDecoder::create());
  View view_;
  std::uint32_t poses_ = 0;
};

/// Steps all until `done`; false where it takes too long.
template <class Done>
bool stepUntil(std::initializer_list<Watcher*> watchers, const Done& done) {
  const Clock::time_point end = Clock::now() + std::chrono::seconds(kSeconds);
  while (!done()) {
    if (Clock::now() > end || testing::Test::HasFatalFailure()) return false;
    for (Watcher* watcher : watchers) watcher->step();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

std::vector<std::string> arguments(const std::string& listen, std::vector<std::string> more = {}) {
  std::vector<std::string> all = {"serve", kScene, "--listen", listen, "--context", "osmesa", "--fps", "10"};
  if (std::find(more.begin(), more.end(), "--quality") == more.end())
    all.insert(all.end(), {"--bitrate", "4M"});
  if (std::find(more.begin(), more.end(), "--atlas-mpix") == more.end())
    more.insert(more.end(), {"--atlas-mpix", "0.5"});
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

struct Served {
  explicit Served(const std::string& listen = "127.0.0.1:0", std::vector<std::string> more = {})
      : program(arguments(listen, std::move(more))) {
    EXPECT_TRUE(program.waitFor("listening on ", kSeconds)) << program.said();
    EXPECT_TRUE(program.waitFor("x264", kSeconds)) << program.said();
    address = program.after("listening on ");
  }
  test::Program program;
  std::string address;
};

void expectStream(const std::vector<std::string>& more, wire::Method method) {
  Served server("127.0.0.1:0", more);
  Watcher watcher(server.address);
  ASSERT_TRUE(stepUntil({&watcher}, [&] { return watcher.decodedFrames.size() >= 8; }))
      << server.program.said();
  ASSERT_TRUE(watcher.setup);
  EXPECT_EQ(watcher.setup->method, method);
  EXPECT_TRUE(watcher.sawIFrame);
  EXPECT_GT(watcher.elements(), 100u);
  EXPECT_GT(watcher.lastPose, 0u);
  // The atrium has a sun and lamps.
  const auto is = [&](wire::FrameLight type) {
    return std::any_of(watcher.lights.begin(), watcher.lights.end(),
                       [&](const wire::SentLight& light) { return light.type == type; });
  };
  EXPECT_TRUE(is(wire::FrameLight::Directional));
  EXPECT_TRUE(is(wire::FrameLight::Spot) || is(wire::FrameLight::Point));
  ASSERT_EQ(watcher.setup->paths, 1);
  ASSERT_EQ(watcher.paths.size(), 1u);
  EXPECT_EQ(watcher.paths.front().name, "tour");
  EXPECT_EQ(watcher.paths.front().keys.front().eye, glm::dvec3(10.2, 1.75, 4.1));
  // The atrium's leaves: with holes.
  ASSERT_FALSE(watcher.masks.empty());
  const std::vector<std::uint8_t>& alpha = watcher.masks.front().alpha;
  EXPECT_EQ(*std::min_element(alpha.begin(), alpha.end()), 0);
  EXPECT_EQ(*std::max_element(alpha.begin(), alpha.end()), 255);
  // Each decoded atlas has the geometry of its number.
  for (const std::uint32_t frame : watcher.decodedFrames)
    EXPECT_NE(std::find(watcher.geometryFrames.begin(), watcher.geometryFrames.end(), frame),
              watcher.geometryFrames.end())
        << frame;
  EXPECT_EQ(server.program.end(SIGINT), 0) << server.program.said();
}

TEST(Serve, StreamsPatches) { expectStream({}, wire::Method::Rect); }
TEST(Serve, StreamsTriangles) { expectStream({"--method", "tess", "--chroma", "444"}, wire::Method::Tess); }

TEST(Serve, TwoViewersAndOneThatVanishes) {
  Served server;
  Watcher first(server.address);
  auto second = std::make_unique<Watcher>(server.address);
  ASSERT_TRUE(stepUntil({&first, second.get()}, [&] {
    return first.decodedFrames.size() >= 3 && second->decodedFrames.size() >= 3;
  })) << server.program.said();
  second.reset();
  const std::size_t before = first.decodedFrames.size();
  ASSERT_TRUE(stepUntil({&first}, [&] { return first.decodedFrames.size() >= before + 5; }))
      << server.program.said();
  Watcher again(server.address);
  ASSERT_TRUE(stepUntil({&first, &again}, [&] { return again.decodedFrames.size() >= 3; }))
      << server.program.said();
  EXPECT_GT(again.elements(), 100u);
}

TEST(Serve, GarbageEndsOneViewerAlone) {
  Served server;
  Watcher good(server.address);
  Watcher bad(server.address);
  ASSERT_TRUE(stepUntil({&good, &bad}, [&] { return bad.setup && good.decodedFrames.size() >= 2; }))
      << server.program.said();
  bad.shout("this is no message of anybody");
  const std::size_t before = good.decodedFrames.size();
  ASSERT_TRUE(stepUntil({&good}, [&] { return good.decodedFrames.size() >= before + 5; }))
      << server.program.said();
  EXPECT_TRUE(server.program.waitFor("dismissed", kSeconds)) << server.program.said();
  wire::Pose pose;
  pose.number = 1'000'000;
  pose.camera.width = 1'000'000;
  good.say(pose);
  EXPECT_TRUE(stepUntil({&good}, [&] {
    return good.connections >= 1 && server.program.waitFor("1000000", 1);
  })) << server.program.said();
  EXPECT_EQ(server.program.end(SIGTERM), 0);
}

// The atlas is too small for the view: it is reset under pressure. Without regular I-frames nobody but the
// reset asks for one.
void expectResets(const std::string& method, const std::string& megapixels) {
  Served server("127.0.0.1:0", {"--i-frames", "0", "--method", method, "--atlas-mpix", megapixels});
  Watcher watcher(server.address);
  watcher.stride = 0.1;
  EXPECT_TRUE(stepUntil({&watcher}, [&] { return watcher.resets >= 2; })) << server.program.said();
}
TEST(Serve, AResetOfPatchesGetsItsIFrame) { expectResets("rect", "0.0625"); }
TEST(Serve, AResetOfTrianglesGetsItsIFrame) { expectResets("tess", "0.25"); }

TEST(Serve, AServerThatReturnsIsFoundAgain) {
  auto server = std::make_unique<Served>();
  const std::string address = server->address;
  Watcher watcher(address);
  ASSERT_TRUE(stepUntil({&watcher}, [&] { return !watcher.decodedFrames.empty(); }));
  server->program.end(SIGKILL);
  server = std::make_unique<Served>(address);
  const std::size_t before = watcher.decodedFrames.size();
  ASSERT_TRUE(stepUntil({&watcher}, [&] {
    return watcher.connections >= 2 && watcher.geometryFrames.size() > 2 &&
           watcher.decodedFrames.size() >= before;
  })) << server->program.said();
}

TEST(Serve, QualityIsWhatItIsAskedFor) {
  std::map<std::string, double> bytes;
  for (const std::string quality : {"12", "45"}) {
    const std::string file = testing::TempDir() + "serve_quality.json";
    std::remove(file.c_str());
    Served server("127.0.0.1:0",
                  {"--frames", "3", "--stats", file, "--quality", quality, "--latency-ms", "0"});
    Watcher watcher(server.address);
    ASSERT_TRUE(stepUntil({&watcher}, [&] { return std::ifstream(file).good(); })) << server.program.said();
    ASSERT_EQ(server.program.end(0), 0) << server.program.said();
    bytes[quality] = nlohmann::json::parse(std::ifstream(file)).at("video_bytes");
  }
  EXPECT_GT(bytes["12"], 4.0 * bytes["45"]);
  EXPECT_GT(bytes["45"], 0.0);
}

TEST(Serve, StatisticsNameTheStages) {
  const std::string file = testing::TempDir() + "serve_stats.json";
  std::remove(file.c_str());
  const std::string csv = testing::TempDir() + "serve_frames.csv";
  Served server("127.0.0.1:0", {"--frames", "6", "--stats", file, "--csv", csv});
  Watcher watcher(server.address);
  ASSERT_TRUE(stepUntil({&watcher}, [&] { return std::ifstream(file).good(); })) << server.program.said();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const auto json = nlohmann::json::parse(std::ifstream(file));
  EXPECT_EQ(json.at("frames"), 6);
  for (const char* stage : {"visible", "place", "shade", "convert", "read", "meta", "encode"})
    EXPECT_GT(json.at("ms").at(stage).get<double>(), 0.0) << stage;
  EXPECT_GT(json.at("video_bytes").get<double>(), 0.0);
  EXPECT_GT(json.at("meta_bytes").get<double>(), 0.0);
  std::ifstream rows(csv);
  std::string line;
  ASSERT_TRUE(std::getline(rows, line));
  const auto columns = std::count(line.begin(), line.end(), ',');
  std::size_t videoBytes = 0;
  int frames = 0;
  while (std::getline(rows, line)) {
    ++frames;
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns) << line;
    std::istringstream row(line);
    std::vector<double> values;
    for (std::string value; std::getline(row, value, ',');) values.push_back(std::stod(value));
    EXPECT_EQ(values[0], frames);
    EXPECT_EQ(values[1] == 1.0, values[2] == values[0]) << line;
    videoBytes += static_cast<std::size_t>(values[3]);
    for (std::size_t i = 7; i < values.size(); ++i) EXPECT_GT(values[i], 0.0) << line;
  }
  EXPECT_EQ(frames, 6);
  EXPECT_EQ(videoBytes, json.at("video_bytes"));
}

}  // namespace
}  // namespace tessera
