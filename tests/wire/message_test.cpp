// Messages, their framing and their order.
#include <random>

#include <gtest/gtest.h>

#include "codec/wire/bytes.hpp"
#include "codec/wire/framing.hpp"
#include "codec/wire/handshake.hpp"
#include "codec/wire/message_order.hpp"
#include "tests/wire/some_messages.hpp"

namespace tessera::wire {
namespace {

TEST(Bytes, LieLittleEndian) {
  ByteWriter out;
  out.u16(0x0201);
  out.u32(0x06050403);
  out.u64(0x0e0d0c0b0a090807ull);
  out.f32(1.0f);
  out.f64(-2.0);
  out.text("ab");
  const std::vector<std::uint8_t> expected = {1, 2,    3,    4, 5, 6, 7, 8, 9, 10, 11,   12, 13, 14,  0,
                                              0, 0x80, 0x3f, 0, 0, 0, 0, 0, 0, 0,  0xc0, 2,  0,  'a', 'b'};
  EXPECT_EQ(out.bytes(), expected);
  ByteReader in(expected);
  EXPECT_EQ(in.u16(), 0x0201);
  EXPECT_EQ(in.u32(), 0x06050403u);
  EXPECT_EQ(in.u64(), 0x0e0d0c0b0a090807ull);
  EXPECT_EQ(in.f32(), 1.0f);
  EXPECT_EQ(in.f64(), -2.0);
  EXPECT_EQ(in.text(), "ab");
  EXPECT_FALSE(in.failed());
  EXPECT_EQ(in.u8(), 0);
  EXPECT_TRUE(in.failed());
}

// The layout is a promise to other builds: one message byte by byte.
TEST(Messages, LieAsDocumented) {
  Hello hello;
  hello.versions = {2, 5};
  hello.role = Role::Viewer;
  hello.token = "key";
  const auto bytes = encode(hello);
  ASSERT_TRUE(bytes);
  const std::vector<std::uint8_t> expected = {14,  0, 0, 0, 1, 0, 0, 0, 'T', 'S', 'R',
                                              'A', 2, 0, 5, 0, 2, 3, 0, 'k', 'e', 'y'};
  EXPECT_EQ(*bytes, expected);
}

/// Two messages are the same where they encode to the same bytes.
void expectSame(const Message& a, const Message& b) {
  EXPECT_EQ(a.index(), b.index());
  EXPECT_EQ(*encode(a), *encode(b));
}

TEST(Messages, ComeBackThroughChunksOfAnySize) {
  const auto messages = test::someMessages();
  std::vector<std::uint8_t> stream;
  for (const Message& message : messages) {
    const auto bytes = encode(message);
    ASSERT_TRUE(bytes) << bytes.error().message;
    stream.insert(stream.end(), bytes->begin(), bytes->end());
  }
  std::mt19937 random(1);
  for (const std::size_t largest :
       {std::size_t{1}, std::size_t{3}, std::size_t{17}, std::size_t{400}, stream.size()}) {
    MessageParser parser;
    std::size_t at = 0;
    std::vector<Message> came;
    while (at < stream.size()) {
      const std::size_t count = std::min(stream.size() - at, 1 + random() % largest);
      parser.feed(std::span(stream).subspan(at, count));
      at += count;
      for (;;) {
        auto message = parser.next();
        ASSERT_TRUE(message) << message.error().message;
        if (!*message) break;
        came.push_back(std::move(**message));
      }
      if (parser.pending() > 0) {
        EXPECT_GT(parser.lacking(), 0u);
      }
    }
    ASSERT_EQ(came.size(), messages.size());
    for (std::size_t i = 0; i < came.size(); ++i) expectSame(came[i], messages[i]);
    EXPECT_EQ(parser.pending(), 0u);
  }
}

TEST(Messages, KeepTheirValues) {
  const auto through = [](const Message& message) {
    const auto bytes = encode(message);
    return *decode(kindOf(message), std::span(*bytes).subspan(kHeaderBytes));
  };
  const FrameHeader frame = test::someFrame(77);
  const auto back = std::get<FrameHeader>(through(frame));
  EXPECT_EQ(back.frame, 77u);
  EXPECT_TRUE(back.iFrame);
  EXPECT_FALSE(back.atlasReset);
  EXPECT_EQ(back.pose, 8u);
  EXPECT_EQ(back.camera.eye, frame.camera.eye);
  EXPECT_EQ(back.camera.orientation, frame.camera.orientation);
  EXPECT_EQ(back.camera.slopes, frame.camera.slopes);
  EXPECT_EQ(back.camera.height, frame.camera.height);
  ASSERT_EQ(back.lights.size(), frame.lights.size());
  EXPECT_EQ(back.lights[1].radiance, frame.lights[1].radiance);
  EXPECT_EQ(back.lights[1].outerCone, frame.lights[1].outerCone);
  const auto setup = std::get<StreamSetup>(through(test::someSetup()));
  EXPECT_EQ(setup.method, Method::Tess);
  EXPECT_EQ(setup.chroma, Chroma::C444);
  EXPECT_EQ(setup.video, test::someSetup().video);
  EXPECT_EQ(setup.fpsDenominator, 1001u);
  EXPECT_EQ(setup.paths, 1);
  EXPECT_EQ(setup.start.zNear, test::someCamera().zNear);
  const auto path = std::get<Path>(through(test::somePath()));
  EXPECT_EQ(path.name, "tour");
  ASSERT_EQ(path.keys.size(), 2u);
  EXPECT_EQ(path.keys[0].time, -1.0);
  EXPECT_EQ(path.keys[1].eye, glm::dvec3(7, 8, 9));
  EXPECT_EQ(path.keys[1].target, glm::dvec3(7, 8, -9));
  EXPECT_EQ(path.keys[1].fovY, 45.0);
}

// Where the numbers lie that a viewer times itself by.
TEST(Messages, FramesNameTheirPose) {
  const auto bytes = *encode(test::someFrame(0x04030201));
  const std::vector<std::uint8_t> start(bytes.begin() + kHeaderBytes, bytes.begin() + kHeaderBytes + 12);
  EXPECT_EQ(start, (std::vector<std::uint8_t>{1, 2, 3, 4, 1, 0, 0, 0, 8, 0, 0, 0}));
}

TEST(Messages, PathsThatAreNoneAreRefused) {
  const auto errorOf = [](const auto& change) {
    Path path = test::somePath();
    change(path);
    const auto bytes = *encode(path);
    const auto back = decode(Kind::Path, std::span(bytes).subspan(kHeaderBytes));
    return back ? std::string() : back.error().message;
  };
  EXPECT_EQ(errorOf([](Path&) {}), "");
  EXPECT_EQ(errorOf([](Path& p) { p.keys.clear(); }), "path: 0 as number of keys");
  EXPECT_EQ(errorOf([](Path& p) { p.keys[1].time = -1.0; }), "path: -1 as time of a key after another");
  EXPECT_EQ(errorOf([](Path& p) { p.keys[1].fovY = 180.0; }), "path: 180 as angle of view");
  EXPECT_EQ(errorOf([](Path& p) { p.keys[0].eye.x = INFINITY; }), "path: inf as eye");
  EXPECT_EQ(errorOf([](Path& p) { p.keys[0].eye = p.keys[0].target; }),
            "path: 4 as target and eye on axis x alike");
  // A number of keys far beyond the bytes that came is an error before it is memory.
  std::vector<std::uint8_t> few = {0xa0, 0x86, 1, 0, 1, 2, 3};
  EXPECT_EQ(decode(Kind::Path, few).error().message, "path: it ends early");
  few[0] = 0xa1;
  EXPECT_EQ(decode(Kind::Path, few).error().message.find("path: "), 0u);
  StreamSetup setup = test::someSetup();
  setup.paths = kMostPaths + 1;
  const auto many = *encode(setup);
  EXPECT_EQ(decode(Kind::Setup, std::span(many).subspan(kHeaderBytes)).error().message,
            "setup: 257 as number of paths");
}

// Every length but the right one, of every message.
TEST(Messages, CutOrLengthenedBodiesAreErrors) {
  for (const Message& message : test::someMessages()) {
    const Kind kind = kindOf(message);
    const auto bytes = *encode(message);
    const std::span<const std::uint8_t> body = std::span(bytes).subspan(kHeaderBytes);
    // Of geometry any length is one to the framing; what is in it is VisibleMirror's to judge.
    const std::size_t least = kind == Kind::Geometry ? 4 : body.size();
    for (std::size_t size = 0; size < least; ++size) {
      const auto cut = decode(kind, body.first(size));
      ASSERT_FALSE(cut) << nameOf(kind) << " of " << size << " bytes";
      EXPECT_EQ(cut.error().message.find(nameOf(kind)), 0u) << cut.error().message;
    }
    if (kind == Kind::Geometry) continue;
    std::vector<std::uint8_t> longer(body.begin(), body.end());
    longer.push_back(0);
    EXPECT_FALSE(decode(kind, longer)) << nameOf(kind);
  }
}

std::string errorOf(MessageParser& parser, std::span<const std::uint8_t> bytes) {
  parser.feed(bytes);
  for (;;) {
    const auto message = parser.next();
    if (!message) return message.error().message;
    if (!*message) return "";
  }
}

TEST(Framing, RefusesByTheHeaderAlone) {
  const auto refusal = [](std::vector<std::uint8_t> header) {
    MessageParser parser;
    return errorOf(parser, header);
  };
  EXPECT_EQ(refusal({0, 0, 0, 0, 99, 0, 0, 0}), "message of kind 99: there is none");
  EXPECT_EQ(refusal({255, 255, 255, 255, 17, 0, 0, 0}), "pose: its 4294967295 bytes are more than 120");
  EXPECT_EQ(refusal({0, 0, 0, 4, 5, 0, 0, 0}), "");  // 64 MiB of geometry may come
  EXPECT_EQ(refusal({1, 0, 0, 4, 5, 0, 0, 0}), "geometry: its 67108865 bytes are more than 67108864");
  EXPECT_EQ(refusal({4, 0, 0, 0, 18, 0, 7, 0}),
            "ask for an I-frame: 7 as a byte of its header that is to be zero");
}

TEST(Framing, HoldsNothingThatAPeerMayNotSend) {
  // 64 MiB of geometry are about to come: from a viewer, and from a server before its hello.
  const std::vector<std::uint8_t> header = {0, 0, 0, 4, 5, 0, 0, 0};
  MessageParser fromViewer(Role::Viewer);
  EXPECT_EQ(errorOf(fromViewer, header), "geometry: from a viewer");
  MessageParser fromServer(Role::Server);
  EXPECT_EQ(errorOf(fromServer, header), "geometry: before a hello");
  MessageParser greeted(Role::Server);
  EXPECT_EQ(errorOf(greeted, *encode(Hello{{1, 1}, Role::Server, ""})), "");
  EXPECT_EQ(errorOf(greeted, header), "");
}

TEST(Framing, StaysLostAndSaysWhy) {
  MessageParser parser;
  const std::vector<std::uint8_t> bad = {0, 0, 0, 0, 99, 0, 0, 0};
  const std::string first = errorOf(parser, bad);
  const auto good = *encode(test::someMessages()[0]);
  EXPECT_EQ(errorOf(parser, good), first);
  EXPECT_EQ(parser.pending(), 0u);
}

TEST(Framing, ShowsWhatIsPending) {
  const auto bytes = *encode(AskIFrame{3});
  MessageParser parser;
  EXPECT_EQ(parser.lacking(), kHeaderBytes);
  parser.feed(std::span(bytes).first(5));
  ASSERT_TRUE(parser.next());
  EXPECT_EQ(parser.pending(), 5u);
  EXPECT_EQ(parser.lacking(), 3u);
  parser.feed(std::span(bytes).subspan(5, 4));
  EXPECT_EQ(parser.pending(), 9u);
  EXPECT_EQ(parser.lacking(), 3u);
  parser.feed(std::span(bytes).subspan(9));
  ASSERT_TRUE(*parser.next());
  EXPECT_EQ(parser.pending(), 0u);
}

TEST(SendQueue, HoldsWhatASlowPeerLeaves) {
  SendQueue queue(64);
  ASSERT_TRUE(queue.push(AskIFrame{1}));
  ASSERT_TRUE(queue.push(Acknowledge{2, 3, 4.0}));
  EXPECT_EQ(queue.pending(), 12u + 24u);
  const auto full = queue.push(test::someFrame(1));
  ASSERT_FALSE(full);
  EXPECT_NE(full.error().message.find("36 bytes wait"), std::string::npos) << full.error().message;
  MessageParser parser;
  std::vector<Message> came;
  while (!queue.front().empty()) {
    const auto part = queue.front().first(std::min<std::size_t>(queue.front().size(), 5));
    parser.feed(part);
    queue.sent(part.size());
    auto message = parser.next();
    ASSERT_TRUE(message);
    if (*message) came.push_back(std::move(**message));
  }
  EXPECT_EQ(queue.pending(), 0u);
  ASSERT_EQ(came.size(), 2u);
  EXPECT_EQ(std::get<Acknowledge>(came[1]).atlasFrame, 3u);
}

TEST(Messages, ValuesThatAreNoneAreNamed) {
  const auto refusal = [](const Message& message) {
    const auto bytes = *encode(message);
    const auto back = decode(kindOf(message), std::span(bytes).subspan(kHeaderBytes));
    return back ? std::string() : back.error().message;
  };
  Pose pose = test::somePose(4);
  EXPECT_EQ(refusal(pose), "");
  pose.camera.eye.y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(pose), "pose: nan as eye");
  pose = test::somePose(4);
  pose.camera.orientation = {0, 0, 0, 2};
  EXPECT_EQ(refusal(pose), "pose: 4 as squared length of an orientation");
  pose = test::somePose(4);
  pose.camera.zNear = 0.0;
  EXPECT_EQ(refusal(pose), "pose: 0 as near plane");
  pose = test::somePose(4);
  std::swap(pose.camera.slopes.x, pose.camera.slopes.y);
  EXPECT_NE(refusal(pose), "");
  pose = test::somePose(0);
  EXPECT_EQ(refusal(pose), "pose: 0 as number of a pose");
  FrameHeader frame = test::someFrame(1);
  frame.background = 1.5f;
  EXPECT_EQ(refusal(frame), "frame: 1.5 as share of the background");
  StreamSetup setup = test::someSetup();
  setup.width = 40000;
  EXPECT_EQ(refusal(setup), "setup: 40000 as width of the atlas");
  Hello hello;
  hello.versions = {3, 2};
  EXPECT_EQ(refusal(hello), "hello: 3 as oldest version");
  MaskImage mask = test::someMask();
  mask.alpha.pop_back();
  EXPECT_NE(refusal(mask).find("as bytes of alpha that are not those of its size"), std::string::npos);
  mask.alpha.clear();
  EXPECT_NE(refusal(mask).find("as bytes of alpha that are not those of its size"), std::string::npos);
}

TEST(Messages, MasksArePackedAndCorruptOnesRefused) {
  MaskImage mask = test::someMask();
  mask.width = mask.height = 2048;
  mask.alpha.assign(std::size_t{2048} * 2048, 255);
  std::fill(mask.alpha.begin() + 1'000'000, mask.alpha.begin() + 3'000'000, std::uint8_t{0});
  const auto bytes = encode(mask);
  ASSERT_TRUE(bytes);
  EXPECT_LT(bytes->size(), 10'000u);
  const auto body = std::span(*bytes).subspan(kHeaderBytes);
  EXPECT_EQ(std::get<MaskImage>(*decode(Kind::Mask, body)).alpha, mask.alpha);
  for (std::size_t cut = 0; cut < body.size(); ++cut)
    EXPECT_FALSE(decode(Kind::Mask, body.first(cut))) << cut;
  // Says that it is larger than it is, and the other way round.
  for (const std::uint8_t side : {4, 16}) {
    std::vector<std::uint8_t> other(body.begin(), body.end());
    other[5] = side;  // second byte of the width: 1024, 4096
    EXPECT_FALSE(decode(Kind::Mask, other)) << int{side};
  }
}

TEST(Handshake, FindsTheVersionOrSaysWhichMeet) {
  EXPECT_EQ(commonVersion({1, 3}, {2, 5}), 3);
  EXPECT_EQ(commonVersion({2, 5}, {1, 3}), 3);
  EXPECT_EQ(commonVersion({4, 4}, {4, 4}), 4);
  EXPECT_FALSE(commonVersion({1, 2}, {3, 5}));
  EXPECT_FALSE(commonVersion({3, 5}, {1, 2}));

  const auto good = answer({{1, 9}, Role::Viewer, "secret"}, Role::Server, {2, 3}, "secret");
  EXPECT_EQ(good.version, 3);
  const auto old = answer({{7, 9}, Role::Viewer, "secret"}, Role::Server, {2, 3}, "secret");
  EXPECT_FALSE(old.version);
  EXPECT_EQ(old.refusal.reason, RefusalReason::Version);
  EXPECT_EQ(old.refusal.versions, (Versions{2, 3}));
  EXPECT_EQ(old.refusal.why,
            "this server speaks versions 2 to 3, the other side versions 7 to 9: none is common");
  for (const char* wrong : {"", "Secret", "secre", "secret2"}) {
    const auto refused = answer({{1, 9}, Role::Viewer, wrong}, Role::Server, {2, 3}, "secret");
    EXPECT_FALSE(refused.version) << wrong;
    EXPECT_EQ(refused.refusal.reason, RefusalReason::Token);
  }
  EXPECT_TRUE(answer({{1, 9}, Role::Viewer, "whatever"}, Role::Server, {2, 3}, "").version);
  EXPECT_EQ(answer({{1, 9}, Role::Server, "secret"}, Role::Server, {2, 3}, "secret").refusal.reason,
            RefusalReason::Role);
}

std::string orderError(Role peer, std::vector<Message> messages) {
  MessageOrder order(peer);
  for (std::size_t i = 0; i < messages.size(); ++i)
    if (const auto good = order.accept(messages[i]); !good)
      return fmt::format("{} at {}", good.error().message, i);
  return "";
}

TEST(MessageOrder, TakesAStreamAndNothingElse) {
  const Hello server{{1, 1}, Role::Server, ""};
  const Hello viewer{{1, 1}, Role::Viewer, ""};
  const StreamSetup setup = test::someSetup();
  StreamSetup alone = setup;
  alone.paths = 0;
  const auto frame = [](std::uint32_t number) { return test::someFrame(number); };
  const auto geometry = [](std::uint32_t number) { return Geometry{number, {}}; };
  EXPECT_EQ(orderError(Role::Server, {server, setup, test::somePath(), test::someMask(), frame(3),
                                      geometry(3), frame(9), geometry(9)}),
            "");
  EXPECT_EQ(
      orderError(Role::Viewer, {viewer, test::somePose(1), AskIFrame{0}, Acknowledge{}, test::somePose(2)}),
      "");
  EXPECT_EQ(orderError(Role::Server, {setup}), "setup: before a hello at 0");
  EXPECT_EQ(orderError(Role::Server, {server, server}), "hello: a second one at 1");
  EXPECT_EQ(orderError(Role::Server, {viewer}), "hello: from a viewer at 0");
  EXPECT_EQ(orderError(Role::Server, {server, frame(1)}), "frame: before the setup at 1");
  EXPECT_EQ(orderError(Role::Server, {server, setup, setup}), "setup: a second one at 2");
  EXPECT_EQ(orderError(Role::Server, {server, alone, geometry(1)}),
            "geometry: of frame 1, after frame 0, which has its own at 2");
  EXPECT_EQ(orderError(Role::Server, {server, alone, frame(2), geometry(1)}),
            "geometry: of frame 1, after frame 2 at 3");
  EXPECT_EQ(orderError(Role::Server, {server, alone, frame(2), frame(3)}),
            "frame 3: frame 2 had no geometry at 3");
  EXPECT_EQ(orderError(Role::Server, {server, alone, frame(2), geometry(2), frame(2)}),
            "frame 2: after frame 2 at 4");
  EXPECT_EQ(orderError(Role::Server, {server, setup, frame(1)}), "frame 1: 1 paths are still to come at 2");
  EXPECT_EQ(orderError(Role::Server, {server, setup, test::somePath(), test::somePath()}),
            "path: more of them than the setup said at 3");
  EXPECT_EQ(orderError(Role::Viewer, {viewer, test::somePath()}), "path: from a viewer at 1");
  EXPECT_EQ(orderError(Role::Server, {server, test::somePose(1)}), "pose: from a server at 1");
  EXPECT_EQ(orderError(Role::Viewer, {viewer, setup}), "setup: from a viewer at 1");
  EXPECT_EQ(orderError(Role::Viewer, {viewer, test::somePose(2), test::somePose(2)}),
            "pose 2: after pose 2 at 2");
  EXPECT_EQ(orderError(Role::Viewer, {viewer, Refusal{}, test::somePose(1)}), "pose: after a refusal at 2");
  EXPECT_EQ(orderError(Role::Viewer, {Refusal{}}), "");
}

}  // namespace
}  // namespace tessera::wire
