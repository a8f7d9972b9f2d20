// A session against servers of the test's own, over real sockets.
#include "engine/view/session.hpp"

#include <thread>

#include <gtest/gtest.h>

#include "codec/transport/server.hpp"
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

std::unique_ptr<view::Session> sessionAt(const transport::Address& address) {
  view::SessionOptions options;
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
  void poll() {
    for (const transport::ServerEvent& event : server->poll()) {
      // The kind follows the length.
      if (const auto* said = std::get_if<transport::ViewerMessage>(&event))
        poses += said->bytes.at(4) == static_cast<std::uint8_t>(wire::Kind::Pose) ? 1 : 0;
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
