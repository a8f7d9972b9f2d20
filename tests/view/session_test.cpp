// A session against servers of the test's own, over real sockets.
#include "engine/view/session.hpp"

#include <thread>

#include <gtest/gtest.h>

#include "codec/transport/server.hpp"
#include "codec/video.hpp"
#include "codec/wire/handshake.hpp"
#include "tests/view/one_patch.hpp"

namespace tessera {
namespace {

using view::Condition;

constexpr std::chrono::seconds kPatience{20};

template <class Holds>
bool waitFor(const Holds& holds) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

std::unique_ptr<transport::Server> serverAt(std::uint16_t port) {
  transport::ServerOptions options;
  options.listen.port = port;
  auto server = transport::Server::start(options);
  EXPECT_TRUE(server) << server.error().message;
  return server ? std::move(*server) : nullptr;
}

std::unique_ptr<view::Session> sessionAt(const transport::Address& address,
                                         view::SessionOptions options = {}) {
  options.client.server = address;
  options.client.longestBackoff = std::chrono::milliseconds(200);
  options.stalled = std::chrono::milliseconds(200);
  auto session = view::Session::start(options);
  EXPECT_TRUE(session) << session.error().message;
  return session ? std::move(*session) : nullptr;
}

/// Greets each viewer as told.
struct Greeter {
  std::unique_ptr<transport::Server> server;
  std::vector<std::vector<std::uint8_t>> greeting;
  int joined = 0;
  int poses = 0;
  std::uint32_t lastPose = 0;
  void poll() {
    for (const transport::ServerEvent& event : server->poll()) {
      // The kind follows the length.
      const auto* said = std::get_if<transport::ViewerMessage>(&event);
      if (said != nullptr && said->bytes.at(4) == static_cast<std::uint8_t>(wire::Kind::Pose)) {
        ++poses;
        const auto body = std::span(said->bytes).subspan(wire::kHeaderBytes);
        lastPose = std::get<wire::Pose>(*wire::decode(wire::Kind::Pose, body)).number;
      }
      const auto* one = std::get_if<transport::ViewerJoined>(&event);
      if (one == nullptr) continue;
      ++joined;
      for (const auto& bytes : greeting) (void)server->send(one->viewer, bytes);
    }
  }
};

std::vector<std::uint8_t> bytesOf(const wire::Message& message) { return *wire::encode(message); }

TEST(ViewSession, SaysThatNobodyIsThere) {
  // A port that was free a moment ago.
  transport::Address address;
  { address = serverAt(0)->address(); }
  auto session = sessionAt(address);
  EXPECT_TRUE(waitFor([&] { return session->figures().why.find(": ") != std::string::npos; }));
  EXPECT_EQ(session->figures().condition, Condition::Connecting);
}

TEST(ViewSession, GarbageIsNamedAndTriedAgain) {
  Greeter greeter;
  greeter.server = serverAt(0);
  greeter.greeting = {{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
  auto session = sessionAt(greeter.server->address());
  bool named = false;
  EXPECT_TRUE(waitFor([&] {
    greeter.poll();
    named = named || session->figures().condition == Condition::StreamBroken;
    return named && greeter.joined >= 2;
  }));
}

TEST(ViewSession, GeometryThatIsNoneEndsTheStream) {
  Greeter greeter;
  greeter.server = serverAt(0);
  test::OnePatch source;
  greeter.greeting = {bytesOf(wire::Hello{wire::kSpoken, wire::Role::Server, ""}),
                      bytesOf(test::OnePatch::setup()), bytesOf(test::OnePatch::header(1)),
                      bytesOf(wire::Geometry{1, {9, 9, 9, 9}})};
  for (int i = 2; i < 700; ++i) {  // more than may wait for an atlas
    greeter.greeting.push_back(bytesOf(test::OnePatch::header(static_cast<std::uint32_t>(i))));
    greeter.greeting.push_back(bytesOf(wire::Geometry{static_cast<std::uint32_t>(i), {9}}));
  }
  auto session = sessionAt(greeter.server->address());
  std::string why;
  EXPECT_TRUE(waitFor([&] {
    greeter.poll();
    const auto figures = session->figures();
    if (figures.condition == Condition::StreamBroken) why = figures.why;
    return !why.empty();
  }));
  EXPECT_NE(why.find("geometry of frame 1"), std::string::npos) << why;
  EXPECT_FALSE(session->take());
}

TEST(ViewSession, CamerasOfTheStageAreOfferedWhole) {
  Greeter greeter;
  greeter.server = serverAt(0);
  wire::StreamSetup setup = test::OnePatch::setup();
  setup.paths = 2;
  setup.start.eye = {1, 2, 3};
  const auto path = [](const std::string& name) {
    return bytesOf(wire::Path{name, {{0.0, {0, 0, 5}, {}, 50.0}}});
  };
  greeter.greeting = {bytesOf(wire::Hello{wire::kSpoken, wire::Role::Server, ""}), bytesOf(setup),
                      path("tour")};
  auto session = sessionAt(greeter.server->address());
  EXPECT_TRUE(waitFor([&] {
    greeter.poll();
    return session->figures().metaBytes > 200;
  }));
  EXPECT_FALSE(session->offer()) << "a path is still to come";
  greeter.greeting.push_back(path("walk"));
  // Cut off, it comes back and is told all.
  const transport::Address address = greeter.server->address();
  greeter.server.reset();
  greeter.server = serverAt(address.port);
  ASSERT_TRUE(waitFor([&] {
    greeter.poll();
    return session->offer().has_value();
  }));
  const auto offer = *session->offer();
  EXPECT_EQ(offer.start.eye, glm::dvec3(1, 2, 3));
  ASSERT_EQ(offer.paths.size(), 2u);
  EXPECT_EQ(offer.paths[1].name, "walk");
  EXPECT_EQ(offer.paths[1].keys.front().fovY, 50.0);
}

// Two viewers share a frame, whose camera is one's: each knows by the number which of its poses it answers.
TEST(ViewSession, LatencyIsMeasuredByThePosesNumber) {
  Greeter greeter;
  greeter.server = serverAt(0);
  greeter.greeting = {bytesOf(wire::Hello{wire::kSpoken, wire::Role::Server, ""}),
                      bytesOf(test::OnePatch::setup())};
  auto session = sessionAt(greeter.server->address());
  const auto stands = [&] {
    greeter.poll();
    session->pose(wire::Camera());
    return greeter.lastPose;
  };
  ASSERT_TRUE(waitFor([&] { return stands() >= 3; }));
  const auto answer = [&](std::uint32_t frame, std::uint32_t pose) {
    wire::FrameHeader header = test::OnePatch::header(frame);
    header.camera.eye = {9, 9, 9};  // another viewer's
    header.pose = pose;
    (void)greeter.server->send(1, bytesOf(header));
    (void)greeter.server->send(1, bytesOf(wire::Geometry{frame, {}}));
    return waitFor([&] {
      greeter.poll();
      return session->figures().frames == frame;
    });
  };
  // Numbers that no pose had say nothing.
  ASSERT_TRUE(answer(1, 0));
  ASSERT_TRUE(answer(2, 1'000'000));
  EXPECT_LT(session->latency().median(view::Stage::Server), 0.0);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_TRUE(answer(3, 2));
  EXPECT_GE(session->latency().median(view::Stage::Server), 50.0);
}

/// An I-frame of OnePatch's atlas.
std::shared_ptr<const transport::Bytes> iFrame(std::uint32_t frame) {
  EncoderOptions options;
  options.width = options.height = 64;
  auto encoder = VideoEncoder::create(options);
  const YuvImage grey(64, 64, Chroma::Yuv420);
  auto coded = encoder->encode(grey.view(), frame, {.iFrame = true});
  EXPECT_TRUE(coded) << coded.error().message;
  return std::make_shared<const transport::Bytes>(std::move(coded->bytes));
}

TEST(ViewSession, AnAtlasWithoutItsGeometryIsNamed) {
  Greeter greeter;
  greeter.server = serverAt(0);
  greeter.greeting = {bytesOf(wire::Hello{wire::kSpoken, wire::Role::Server, ""}),
                      bytesOf(test::OnePatch::setup())};
  auto session = sessionAt(greeter.server->address());
  std::uint32_t frame = 0;
  EXPECT_TRUE(waitFor([&] {
    greeter.poll();
    ++frame;
    if (greeter.joined > 0) (void)greeter.server->sendVideo(1, frame, iFrame(frame));
    const view::Figures figures = session->figures();
    EXPECT_NE(figures.condition, Condition::Live);
    return figures.condition == Condition::Stalled && figures.why.find("no geometry") != std::string::npos;
  })) << session->figures().why;
}

TEST(ViewSession, WhatWaitedTooLongIsNotDecoded) {
  Greeter greeter;
  greeter.server = serverAt(0);
  greeter.greeting = {bytesOf(wire::Hello{wire::kSpoken, wire::Role::Server, ""}),
                      bytesOf(test::OnePatch::setup())};
  view::SessionOptions options;
  options.longestBacklog = std::chrono::milliseconds(0);  // all of it
  auto session = sessionAt(greeter.server->address(), options);
  std::uint32_t frame = 0;
  EXPECT_TRUE(waitFor([&] {
    greeter.poll();
    ++frame;
    if (greeter.joined > 0) (void)greeter.server->sendVideo(1, frame, iFrame(frame));
    const view::Figures figures = session->figures();
    return figures.condition == Condition::WaitingForIFrame && figures.askedIFrames > 1 &&
           figures.why.find("behind") != std::string::npos;
  })) << session->figures().why;
  EXPECT_EQ(session->figures().atlasFrames, 0u);
}

TEST(ViewSession, ARefusalIsFinalAndQuoted) {
  Greeter greeter;
  greeter.server = serverAt(0);
  greeter.greeting = {
      bytesOf(wire::Refusal{wire::RefusalReason::Version, {7, 9}, "this server speaks versions 7 to 9"})};
  auto session = sessionAt(greeter.server->address());
  EXPECT_TRUE(waitFor([&] {
    greeter.poll();
    return session->figures().condition == Condition::Refused;
  }));
  EXPECT_NE(session->figures().why.find("versions 7 to 9"), std::string::npos) << session->figures().why;
}

TEST(ViewSession, WaitsForVideoSendsPosesAndComesBack) {
  Greeter greeter;
  greeter.server = serverAt(0);
  greeter.greeting = {bytesOf(wire::Hello{wire::kSpoken, wire::Role::Server, ""}),
                      bytesOf(test::OnePatch::setup())};
  const transport::Address address = greeter.server->address();
  auto session = sessionAt(address);
  wire::Camera camera;
  const auto poll = [&] {
    greeter.poll();
    camera.eye.x += 0.001;
    session->pose(camera);
    return session->figures().condition;
  };
  EXPECT_TRUE(waitFor([&] { return poll() == Condition::NoVideoYet && greeter.poses > 5; }));
  greeter.server.reset();
  EXPECT_TRUE(waitFor([&] { return session->figures().condition == Condition::ServerGone; }));
  greeter.server = serverAt(address.port);
  EXPECT_TRUE(waitFor([&] { return poll() == Condition::NoVideoYet && greeter.joined == 2; }));
  EXPECT_EQ(session->figures().reconnects, 1u);
}

}  // namespace
}  // namespace tessera
