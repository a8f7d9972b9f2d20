// Video from a server to viewers over real sockets, with a network in between that loses, delays and mixes.
#include <algorithm>
#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <map>

#include <gtest/gtest.h>

#include "codec/transport/crypto.hpp"
#include "codec/transport/video_hello.hpp"
#include "codec/transport/viewer_video.hpp"
#include "tests/transport/access_units.hpp"
#include "tests/transport/pair.hpp"
#include "tests/transport/proxy.hpp"

namespace tessera::transport {
namespace {

using namespace std::chrono_literals;
using test::TestServer;
using test::TestViewer;
using test::waitFor;

constexpr auto kInterval = 8ms;

ServerOptions quick() {
  ServerOptions options;
  options.frameInterval = kInterval;
  return options;
}

using Units = std::map<std::uint32_t, std::shared_ptr<const Bytes>>;

/// Sends frames at their rate to all that joined, polling everybody meanwhile.
Units play(TestServer& server, const std::vector<TestViewer*>& viewers, std::uint32_t first, int count) {
  std::mt19937 random(first);
  Units units;
  auto due = std::chrono::steady_clock::now();
  for (int i = 0; i < count; ++i) {
    const std::uint32_t frame = first + static_cast<std::uint32_t>(i);
    const auto unit =
        std::make_shared<const Bytes>(test::accessUnit(random, {30, 9, 4000 + random() % 12000}));
    units[frame] = unit;
    for (const ViewerJoined& joined : server.joined)
      (void)server.server->sendVideo(joined.viewer, frame, unit);
    due += kInterval;
    std::this_thread::sleep_until(due);
    server.poll();
    for (TestViewer* viewer : viewers) viewer->poll();
  }
  return units;
}

/// Joined, and its path open.
void expectOpen(TestServer& server, std::size_t viewers) {
  ASSERT_TRUE(server.until([&] { return server.videoOpen.size() == viewers; })) << server.log.text();
}

/// Every frame handed out whole is the one that was sent, in order, and what was not whole says so.
std::size_t expectHonest(const std::vector<ReceivedFrame>& frames, const Units& units) {
  std::size_t whole = 0;
  std::uint32_t last = 0;
  for (const ReceivedFrame& frame : frames) {
    EXPECT_GT(frame.frame, last);
    EXPECT_TRUE(units.contains(frame.frame)) << frame.frame;
    EXPECT_TRUE(last == 0 || frame.lostBefore == (frame.frame != last + 1)) << frame.frame;
    last = frame.frame;
    if (!frame.complete || !units.contains(frame.frame)) continue;
    ++whole;
    EXPECT_EQ(frame.bytes, *units.at(frame.frame)) << frame.frame;
  }
  return whole;
}

TEST(Video, ComesWholeWithoutLoss) {
  TestServer server(quick());
  ASSERT_TRUE(server.server) << server.error;
  TestViewer viewer(server.server->address());
  expectOpen(server, 1);
  const Units units = play(server, {&viewer}, 1, 60);
  ASSERT_TRUE(viewer.until([&] { return viewer.frames.size() == 60; })) << viewer.frames.size();
  EXPECT_EQ(expectHonest(viewer.frames, units), 60u);
  const VideoStatistics seen = viewer.client->status().video;
  EXPECT_EQ(seen.lost + seen.malformed + seen.damaged, 0u);
  const SendStatistics sent = server.server->viewers().at(0).video;
  EXPECT_EQ(sent.frames, 60u);
  EXPECT_EQ(sent.packets, seen.packets);
  EXPECT_EQ(sent.bytes, seen.bytes);
}

/// Through a network; returns what it did.
void through(const test::Impairment& impairment, double leastWhole, double mostWhole) {
  TestServer server(quick());
  ASSERT_TRUE(server.server) << server.error;
  test::Proxy proxy(server.server->address(), {}, 7);
  TestViewer viewer(proxy.address());
  expectOpen(server, 1);
  proxy.impair(impairment);
  constexpr int kFrames = 150;
  const Units units = play(server, {&viewer}, 1, kFrames);
  // The path is clear again for the last frames, so that the end is seen.
  proxy.impair({});
  std::this_thread::sleep_for(50ms);
  Units all = play(server, {&viewer}, kFrames + 1, 5);
  all.insert(units.begin(), units.end());
  ASSERT_TRUE(
      viewer.until([&] { return !viewer.frames.empty() && viewer.frames.back().frame == kFrames + 5; }));
  const auto whole = static_cast<double>(expectHonest(viewer.frames, all));
  EXPECT_GE(whole, leastWhole * kFrames);
  EXPECT_LE(whole, mostWhole * kFrames + 5);
  const VideoStatistics seen = viewer.client->status().video;
  const SendStatistics sent = server.server->viewers().at(0).video;
  EXPECT_EQ(seen.malformed, 0u);
  // What is lost before the first frame that comes is not known to the viewer.
  EXPECT_LE(seen.packets + seen.lost, sent.packets);
  EXPECT_GE(seen.packets + seen.lost + 40, sent.packets);
}

TEST(Video, LosesFramesNotHonestyAtFivePercent) {
  test::Impairment five;
  five.loss = 0.05;
  // About ten packets a frame: 0.95^10 is 0.6.
  through(five, 0.4, 0.8);
}

TEST(Video, LosesFramesNotHonestyAtTwentyPercent) {
  test::Impairment twenty;
  twenty.loss = 0.2;
  through(twenty, 0.01, 0.35);
}

TEST(Video, MindsNoReorderingDelayOrDoubles) {
  test::Impairment mixed;
  mixed.duplicate = 0.2;
  mixed.reorder = 0.2;
  mixed.reorderMs = 3.0;
  mixed.delayMs = 20.0;
  mixed.jitterMs = 2.0;
  through(mixed, 1.0, 1.0);
}

TEST(Video, TwoViewersEachHaveTheirOwn) {
  TestServer server(quick());
  ASSERT_TRUE(server.server) << server.error;
  test::Impairment bad;
  bad.loss = 0.3;
  test::Proxy proxy(server.server->address(), bad, 3);
  TestViewer clear(server.server->address());
  TestViewer lossy(proxy.address());
  expectOpen(server, 2);
  const Units units = play(server, {&clear, &lossy}, 1, 60);
  ASSERT_TRUE(clear.until([&] { return clear.frames.size() == 60; }));
  EXPECT_EQ(expectHonest(clear.frames, units), 60u);
  ASSERT_TRUE(lossy.until([&] { return lossy.client->status().video.lost > 0; }));
  EXPECT_LT(expectHonest(lossy.frames, units), 50u);
}

TEST(Video, GoesOnAfterAReconnection) {
  TestServer server(quick());
  ASSERT_TRUE(server.server) << server.error;
  test::Proxy proxy(server.server->address(), {}, 1);
  TestViewer viewer(proxy.address());
  expectOpen(server, 1);
  Units units = play(server, {&viewer}, 1, 5);
  proxy.cut();
  ASSERT_TRUE(viewer.until([&] { return viewer.connected.size() == 2; }));
  expectOpen(server, 2);
  viewer.frames.clear();
  units = play(server, {&viewer}, 100, 5);
  ASSERT_TRUE(viewer.until([&] { return viewer.frames.size() == 5; }));
  EXPECT_EQ(expectHonest(viewer.frames, units), 5u);
}

TEST(Video, NothingIsSentToWhoDidNotAsk) {
  ServerOptions options = quick();
  TestServer server(options);
  ASSERT_TRUE(server.server) << server.error;
  // A viewer whose hellos never arrive: its video is kept back.
  test::Impairment none;
  none.loss = 1.0;
  test::Proxy proxy(server.server->address(), none, 1);
  TestViewer viewer(proxy.address());
  ASSERT_TRUE(server.until([&] { return server.joined.size() == 1; }));

  // A stranger's datagrams, one of them a hello for a session that it guessed.
  asio::io_context io;
  asio::ip::udp::socket stranger(io, {asio::ip::udp::v4(), 0});
  stranger.connect({asio::ip::make_address("127.0.0.1"), server.server->address().port});
  const auto guessed = encode(VideoHello{1, 1}, Sha256{});
  stranger.send(asio::buffer(guessed));
  stranger.send(asio::buffer(std::array<std::uint8_t, 1>{}));
  play(server, {&viewer}, 1, 10);
  ASSERT_TRUE(waitFor([&] { return server.server->viewers().at(0).video.unopened == 10; }));
  EXPECT_EQ(server.server->viewers().at(0).video.packets, 0u);
  EXPECT_TRUE(server.videoOpen.empty());
  EXPECT_EQ(stranger.available(), 0u);
}

TEST(Video, HellosAreSignedNewAndOfTheirSession) {
  Ready ready{9, {}, 5, {}};
  ready.helloKey.fill(3);
  auto video = ViewerVideo::make(ready, {kInterval});
  ASSERT_TRUE(video.has_value());
  const auto now = Clock::time_point{} + 1h;
  EXPECT_FALSE(video->open(now));
  EXPECT_FALSE(video->accept(encode(VideoHello{9, 1}, Sha256{}), now)) << "another key";
  EXPECT_FALSE(video->accept(encode(VideoHello{8, 1}, ready.helloKey), now)) << "another session";
  EXPECT_TRUE(video->accept(encode(VideoHello{9, 5}, ready.helloKey), now));
  EXPECT_FALSE(video->accept(encode(VideoHello{9, 5}, ready.helloKey), now)) << "a replay";
  EXPECT_FALSE(video->accept(encode(VideoHello{9, 4}, ready.helloKey), now)) << "an old one";
  EXPECT_TRUE(video->open(now + 4s));
  EXPECT_FALSE(video->open(now + 5s)) << "a viewer that fell silent";
}

// On a clock of its own: what leaves the server in each thirtieth of the interval.
TEST(Video, PacketsLeaveSpreadOverTheInterval) {
  auto video = ViewerVideo::make({9, {}, 5, makeSrtpKey()}, {30ms, 0.8, 1200});
  ASSERT_TRUE(video.has_value());
  std::mt19937 random(1);
  const auto start = Clock::time_point{} + 1h;
  for (std::uint32_t frame = 1; frame <= 3; ++frame) {
    const auto begin = start + 30ms * frame;
    ASSERT_TRUE(video->push(test::accessUnit(random, {90000}), frame, begin).has_value());
    std::vector<std::size_t> sent;
    for (int step = 0; step < 30; ++step) {
      std::size_t count = 0;
      while (true) {
        const auto packet = video->take(begin + step * 1ms);
        ASSERT_TRUE(packet.has_value());
        if (!*packet) break;
        EXPECT_LE((*packet)->size(), 1200u);
        ++count;
      }
      sent.push_back(count);
    }
    // About 78 packets over 24 ms: three or four a millisecond, then silence.
    for (std::size_t step = 0; step < 24; ++step) EXPECT_LE(sent[step], 4u) << step;
    EXPECT_EQ(std::count(sent.begin() + 25, sent.end(), 0u), 5);
    EXPECT_FALSE(video->nextDue().has_value());
  }
}

}  // namespace
}  // namespace tessera::transport
