// The server as a process: what it refuses, and what it does while nobody watches and when it ends.
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "codec/transport/client.hpp"
#include "codec/wire/framing.hpp"
#include "codec/wire/handshake.hpp"
#include "tests/serve/program.hpp"

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;
const std::string kScene = TESSERA_SOURCE_DIR "/assets/atrium.glb";
constexpr int kSeconds = 60;  // that anything may take on a busy machine

std::vector<std::string> arguments(const std::vector<std::string>& more) {
  std::vector<std::string> all = {"serve", kScene, "--context", "osmesa", "--atlas-mpix", "0.5"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

void expectRefused(const std::vector<std::string>& more, const std::string& named) {
  test::Program program(arguments(more));
  EXPECT_TRUE(program.waitFor(named, kSeconds)) << named << " is not in: " << program.said();
  EXPECT_EQ(program.end(0), 2) << program.said();
}

/// A connection that says only what it is told to, and keeps why it ended.
class Peer {
 public:
  explicit Peer(const std::string& address) {
    transport::ClientOptions options;
    options.server = *transport::parseAddress(address);
    options.reconnect = false;
    auto client = transport::Client::start(options);
    EXPECT_TRUE(client);
    if (client) client_ = std::move(*client);
  }
  void say(const wire::Message& message) {
    const auto bytes = wire::encode(message);
    ASSERT_TRUE(bytes);
    ASSERT_TRUE(client_->send(*bytes));
  }
  /// Takes what comes until `done`; false where it takes too long.
  template <class Done>
  bool until(const Done& done) {
    const Clock::time_point end = Clock::now() + std::chrono::seconds(kSeconds);
    while (!done()) {
      if (Clock::now() > end) return false;
      for (const transport::ClientEvent& event : client_->poll()) {
        connected = connected || std::holds_alternative<transport::Connected>(event);
        if (std::holds_alternative<transport::ServerMessage>(event)) ++messages;
        if (const auto* lost = std::get_if<transport::Disconnected>(&event)) {
          ended = true;
          reason = lost->reason;
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
  }

  bool connected = false, ended = false;
  int messages = 0;
  std::string reason;

 private:
  std::unique_ptr<transport::Client> client_;
};

TEST(ServeEdges, BadArgumentsAreNamed) {
  expectRefused({"--listen", "nowhere"}, "--listen");
  expectRefused({"--fps", "0"}, "--fps");
  expectRefused({"--bitrate", "much"}, "--bitrate");
  expectRefused({"--quality", "52"}, "--quality");
  expectRefused({"--quality", "20", "--bitrate", "4M"}, "--bitrate excludes --quality");
  expectRefused({"--prediction", "reference"}, "nobody knows");
  expectRefused({"--token", "correct horse battery"}, "--keys");
}

// A scene may take minutes to load: what needs none is said before it is looked for.
TEST(ServeEdges, WhatNeedsNoSceneIsRefusedFirst) {
  const auto expect = [](const std::vector<std::string>& more, const std::string& named) {
    std::vector<std::string> all = {"serve", "no_such_scene.glb", "--context", "osmesa"};
    all.insert(all.end(), more.begin(), more.end());
    test::Program program(all);
    EXPECT_TRUE(program.waitFor(named, kSeconds)) << named << " is not in: " << program.said();
    EXPECT_EQ(program.said().find("no_such_scene"), std::string::npos) << program.said();
    EXPECT_EQ(program.end(0), 2) << program.said();
  };
  expect({"--listen", "0.0.0.0:0"}, "listening there needs a pairing token");
  expect({"--listen", "0.0.0.0:0", "--token", "short", "--keys", testing::TempDir() + "serve_keys"}, "token");
  expect({"--listen", "127.0.0.1:0", "--encoder", "no_such_encoder"}, "no_such_encoder");
  expect({"--listen", "127.0.0.1:0", "--atlas-format", "rgb10a2"}, "--atlas-format rgb10a2: ");
  // Else it is the scene that is missing.
  test::Program program({"serve", "no_such_scene.glb", "--listen", "127.0.0.1:0"});
  EXPECT_TRUE(program.waitFor("no_such_scene", kSeconds)) << program.said();
  EXPECT_EQ(program.end(0), 2);
}

TEST(ServeEdges, WhoSaysNoHelloIsDismissedAndNothingIsShadedForIt) {
  const std::string file = testing::TempDir() + "serve_nobody.json";
  std::remove(file.c_str());
  test::Program server(arguments({"--listen", "127.0.0.1:0", "--stats", file}));
  ASSERT_TRUE(server.waitFor("libx264", kSeconds)) << server.said();
  Peer mute(server.after("listening on "));
  ASSERT_TRUE(mute.until([&] { return mute.connected; }));
  const Clock::time_point before = Clock::now();
  EXPECT_TRUE(mute.until([&] { return mute.ended; })) << server.said();
  EXPECT_GT(Clock::now() - before, std::chrono::seconds(4));
  EXPECT_NE(mute.reason.find("no hello"), std::string::npos) << mute.reason;
  EXPECT_TRUE(server.waitFor("no hello within 5 s", kSeconds)) << server.said();
  ASSERT_EQ(server.end(SIGINT), 0) << server.said();
  const auto json = nlohmann::json::parse(std::ifstream(file));
  EXPECT_EQ(json.at("frames"), 0);
  EXPECT_EQ(json.at("viewers"), 0);
}

TEST(ServeEdges, ViewersAreToldOfTheEnd) {
  test::Program server(arguments({"--listen", "127.0.0.1:0"}));
  ASSERT_TRUE(server.waitFor("libx264", kSeconds)) << server.said();
  const std::string address = server.after("listening on ");
  // The port is taken now.
  expectRefused({"--listen", address}, address);
  Peer peer(address);
  ASSERT_TRUE(peer.until([&] { return peer.connected; }));
  peer.say(wire::Hello{wire::kSpoken, wire::Role::Viewer, ""});
  ASSERT_TRUE(peer.until([&] { return peer.messages >= 2; })) << server.said();
  EXPECT_EQ(server.end(SIGINT), 0) << server.said();
  ASSERT_TRUE(peer.until([&] { return peer.ended; }));
  EXPECT_NE(peer.reason.find("the server stops"), std::string::npos) << peer.reason;
}

TEST(ServeEdges, OtherVersionsAreToldWhichMeet) {
  test::Program server(arguments({"--listen", "127.0.0.1:0"}));
  ASSERT_TRUE(server.waitFor("libx264", kSeconds)) << server.said();
  Peer peer(server.after("listening on "));
  ASSERT_TRUE(peer.until([&] { return peer.connected; }));
  peer.say(wire::Hello{{1000, 1001}, wire::Role::Viewer, ""});
  ASSERT_TRUE(peer.until([&] { return peer.ended; })) << server.said();
  EXPECT_EQ(peer.messages, 1) << "the refusal";
  EXPECT_NE(peer.reason.find("1000"), std::string::npos) << peer.reason;
}

}  // namespace
}  // namespace tessera
