// Messages over real sockets: both ways, several viewers, slow and malformed peers, silence, reconnection.
#include <asio/connect.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>

#include <fmt/core.h>
#include <gtest/gtest.h>

#include "tests/transport/pair.hpp"
#include "tests/transport/proxy.hpp"

namespace tessera::transport {
namespace {

using namespace std::chrono_literals;
using test::TestServer;
using test::TestViewer;
using test::waitFor;

Bytes pattern(std::size_t size, std::uint8_t seed) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(seed + i * 7 + i / 251);
  return bytes;
}

/// A peer that says whatever the test wants.
class RawPeer {
 public:
  explicit RawPeer(const Address& server) : socket_(io_) {
    socket_.connect({asio::ip::make_address(server.host), server.port});
  }
  void write(const Bytes& bytes) {
    asio::error_code ignored;
    asio::write(socket_, asio::buffer(bytes), ignored);
  }
  /// Says hello as a viewer would.
  void join() {
    write(encode(Hello{}));
    Bytes answers(8 + 36 + 8 + 48);  // welcome and ready
    asio::read(socket_, asio::buffer(answers));
  }
  /// The refusal that the server ends with; what comes before is skipped.
  std::optional<Refusal> refusal() {
    RecordParser parser(std::size_t{1} << 26);
    parser.allowMessages();
    Bytes buffer(1 << 16);
    asio::error_code error;
    while (true) {
      const std::size_t size = socket_.read_some(asio::buffer(buffer), error);
      if (error) return std::nullopt;
      parser.feed(std::span(buffer).first(size));
      while (true) {
        const auto record = parser.next();
        if (!record || !*record) break;
        if ((*record)->kind == RecordKind::Refusal) return *readRefusal((*record)->body);
      }
    }
  }
  asio::ip::tcp::socket& socket() { return socket_; }

 private:
  asio::io_context io_;
  asio::ip::tcp::socket socket_;
};

TEST(Channel, MessagesGoBothWaysInOrder) {
  TestServer server({});
  ASSERT_TRUE(server.server) << server.error;
  ClientOptions options = TestViewer::at(server.server->address());
  options.limits.ping = 20ms;
  TestViewer viewer(options);
  ASSERT_TRUE(viewer.until([&] { return !viewer.connected.empty(); })) << viewer.log.text();
  EXPECT_FALSE(viewer.connected[0].secure);
  EXPECT_EQ(viewer.connected[0].version, 1);
  ASSERT_TRUE(server.until([&] { return !server.joined.empty(); }));
  const ViewerId id = server.joined[0].viewer;

  // An empty one, small ones, and one that takes many reads.
  std::vector<Bytes> sent;
  for (const std::size_t size : {0u, 1u, 100u, 3'000'000u, 5u}) sent.push_back(pattern(size, 3));
  for (const Bytes& message : sent) {
    ASSERT_TRUE(server.server->send(id, message).has_value());
    ASSERT_TRUE(viewer.client->send(message).has_value());
  }
  ASSERT_TRUE(viewer.until([&] { return viewer.messages.size() == sent.size(); }));
  ASSERT_TRUE(server.until([&] { return server.messages.size() == sent.size(); }));
  EXPECT_EQ(viewer.messages, sent);
  for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_EQ(server.messages[i].bytes, sent[i]);
  EXPECT_TRUE(waitFor([&] { return server.server->viewers().at(0).pendingBytes == 0; }));
  EXPECT_TRUE(waitFor([&] { return viewer.client->status().roundTripMs > 0.0; })) << "pings are answered";
}

TEST(Channel, TwoViewersAreApart) {
  TestServer server({});
  ASSERT_TRUE(server.server) << server.error;
  TestViewer a(server.server->address());
  ASSERT_TRUE(server.until([&] { return server.joined.size() == 1; }));
  TestViewer b(server.server->address());
  ASSERT_TRUE(server.until([&] { return server.joined.size() == 2; }));
  ASSERT_TRUE(server.server->send(server.joined[0].viewer, Bytes{1}).has_value());
  ASSERT_TRUE(server.server->send(server.joined[1].viewer, Bytes{2}).has_value());
  ASSERT_TRUE(a.until([&] { return !a.messages.empty(); }));
  ASSERT_TRUE(b.until([&] { return !b.messages.empty(); }));
  EXPECT_EQ(a.messages, std::vector<Bytes>{Bytes{1}});
  EXPECT_EQ(b.messages, std::vector<Bytes>{Bytes{2}});
  ASSERT_TRUE(b.client->send(Bytes{3}).has_value());
  ASSERT_TRUE(server.until([&] { return !server.messages.empty(); }));
  EXPECT_EQ(server.messages[0].viewer, server.joined[1].viewer);
  // One goes; the other stays.
  a.client.reset();
  ASSERT_TRUE(server.until([&] { return server.left.size() == 1; }));
  EXPECT_EQ(server.left[0].viewer, server.joined[0].viewer);
  EXPECT_EQ(server.left[0].reason, "the viewer left: the viewer was closed");
  EXPECT_FALSE(server.server->send(server.joined[0].viewer, Bytes{1}).has_value());
  ASSERT_TRUE(server.server->send(server.joined[1].viewer, Bytes{4}).has_value());
  ASSERT_TRUE(b.until([&] { return b.messages.size() == 2; }));
}

TEST(Channel, OneViewerTooManyIsToldSoAndTriesAgain) {
  ServerOptions options;
  options.viewers = 1;
  TestServer server(options);
  ASSERT_TRUE(server.server) << server.error;
  auto first = std::make_unique<TestViewer>(server.server->address());
  ASSERT_TRUE(server.until([&] { return server.joined.size() == 1; }));
  TestViewer second(server.server->address());
  ASSERT_TRUE(second.until([&] { return !second.disconnected.empty(); }));
  EXPECT_EQ(second.disconnected[0].reason, "the server refused: the server has 1 viewers, as many as it may");
  EXPECT_TRUE(second.disconnected[0].retrying);
  first.reset();
  EXPECT_TRUE(second.until([&] { return !second.connected.empty(); }));
}

TEST(Channel, ASlowPeerIsCutOffAndOthersGoOn) {
  ServerOptions options;
  options.limits.pendingBytes = 8 << 20;
  TestServer server(options);
  ASSERT_TRUE(server.server) << server.error;
  TestViewer other(server.server->address());
  ASSERT_TRUE(server.until([&] { return server.joined.size() == 1; }));
  RawPeer slow(server.server->address());
  slow.join();
  ASSERT_TRUE(server.until([&] { return server.joined.size() == 2; }));
  // It reads nothing from here on.
  const Bytes message = pattern(1 << 20, 1);
  bool cut = false;
  for (int i = 0; i < 200 && !cut; ++i) {
    const auto sent = server.server->send(server.joined[1].viewer, message);
    cut = !sent;
    if (cut) {
      EXPECT_NE(sent.error().message.find("too slow"), std::string::npos) << sent.error().message;
    }
    std::size_t waiting = 0;
    for (const ViewerStatus& status : server.server->viewers())
      waiting = std::max(waiting, status.pendingBytes);
    EXPECT_LE(waiting, options.limits.pendingBytes);
  }
  EXPECT_TRUE(cut);
  ASSERT_TRUE(server.until([&] { return !server.left.empty(); }));
  EXPECT_EQ(server.left[0].viewer, server.joined[1].viewer);
  EXPECT_TRUE(server.log.has("too slow: ")) << server.log.text();
  ASSERT_TRUE(server.server->send(server.joined[0].viewer, message).has_value());
  ASSERT_TRUE(other.until([&] { return !other.messages.empty(); }));
  EXPECT_EQ(other.messages[0], message);
}

TEST(Channel, MalformedAndOversizedPeersAreToldAndCutOff) {
  ServerOptions options;
  options.limits.messageBytes = 1000;
  options.limits.handshake = 300ms;
  TestServer server(options);
  ASSERT_TRUE(server.server) << server.error;
  TestViewer other(server.server->address());
  ASSERT_TRUE(server.until([&] { return server.joined.size() == 1; }));

  const auto whyOf = [&](bool join, const Bytes& bytes) {
    RawPeer peer(server.server->address());
    if (join) peer.join();
    peer.write(bytes);
    const auto refusal = peer.refusal();
    return refusal ? refusal->why : std::string("no reason");
  };
  EXPECT_EQ(whyOf(false, Bytes(4096, 0xff)), "record of kind 255: there is none, or its header is malformed");
  const std::string request = "GET / HTTP/1.1\r\nHost: x\r\n\r\n";
  EXPECT_EQ(whyOf(false, Bytes(request.begin(), request.end())),
            "record of kind 47: there is none, or its header is malformed");
  EXPECT_EQ(whyOf(false, encodeMessage(Bytes{1})), "message: before the handshake's end");
  EXPECT_EQ(whyOf(true, {0xff, 0xff, 0xff, 0xff, 8, 0, 0, 0}),
            "message: its 4294967295 bytes are more than 1000");
  EXPECT_EQ(whyOf(true, encode(Hello{})), "a hello after the handshake");
  {
    RawPeer silent(server.server->address());
    EXPECT_TRUE(waitFor([&] { return server.log.has("no handshake within 300 ms"); })) << server.log.text();
  }
  // The same of every cut, in the log; and the one that behaves is still there.
  EXPECT_TRUE(server.log.has("cut off: message: its 4294967295 bytes are more than 1000"))
      << server.log.text();
  EXPECT_TRUE(server.log.has("cut off: a hello after the handshake")) << server.log.text();
  EXPECT_FALSE(server.server->send(server.joined[0].viewer, Bytes(1001)).has_value()) << "own messages too";
  ASSERT_TRUE(server.server->send(server.joined[0].viewer, Bytes(1000)).has_value());
  EXPECT_TRUE(other.until([&] { return !other.messages.empty(); }));
}

TEST(Channel, ASilentPeerIsGivenUp) {
  ServerOptions options;
  options.limits.ping = 20ms;
  options.limits.silence = 200ms;
  TestServer server(options);
  ASSERT_TRUE(server.server) << server.error;
  // One answers pings and stays, the other never says a word again.
  TestViewer lively(server.server->address());
  ASSERT_TRUE(server.until([&] { return server.joined.size() == 1; }));
  RawPeer silent(server.server->address());
  silent.join();
  ASSERT_TRUE(server.until([&] { return !server.left.empty(); }));
  EXPECT_EQ(server.left[0].viewer, server.joined[1].viewer);
  EXPECT_EQ(server.left[0].reason, "nothing came for 200 ms");
  EXPECT_EQ(server.left.size(), 1u);
}

TEST(Channel, AHostThatDoesNotPollCostsABoundedInbox) {
  ServerOptions options;
  options.limits.inboxBytes = 1 << 20;
  options.limits.ping = 20ms;
  options.limits.silence = 200ms;
  TestServer server(options);
  ASSERT_TRUE(server.server) << server.error;
  TestViewer viewer(server.server->address());
  ASSERT_TRUE(viewer.until([&] { return !viewer.connected.empty(); }));
  const Bytes message = pattern(100'000, 5);
  for (int i = 0; i < 300; ++i) ASSERT_TRUE(viewer.client->send(message).has_value());
  // What the system's buffers do not take stays with the sender.
  std::this_thread::sleep_for(500ms);
  EXPECT_GT(viewer.client->status().pendingBytes, std::size_t{10} << 20);
  EXPECT_TRUE(server.until([&] { return server.messages.size() == 300; })) << server.messages.size();
  EXPECT_TRUE(server.left.empty()) << "its own silence is not the peer's: " << server.left[0].reason;
}

TEST(Channel, ALostConnectionIsMadeAgain) {
  TestServer server({});
  ASSERT_TRUE(server.server) << server.error;
  test::Proxy proxy(server.server->address(), {}, 1);
  TestViewer viewer(proxy.address());
  ASSERT_TRUE(viewer.until([&] { return viewer.connected.size() == 1; })) << viewer.log.text();
  proxy.cut();
  ASSERT_TRUE(viewer.until([&] { return viewer.connected.size() == 2; })) << viewer.log.text();
  ASSERT_EQ(viewer.disconnected.size(), 1u);
  EXPECT_TRUE(viewer.disconnected[0].retrying);
  ASSERT_TRUE(server.until([&] { return server.joined.size() == 2 && server.left.size() == 1; }));
  ASSERT_TRUE(viewer.client->send(Bytes{1}).has_value());
  EXPECT_TRUE(server.until([&] { return !server.messages.empty(); }));
  EXPECT_EQ(server.messages[0].viewer, server.joined[1].viewer);
}

TEST(Channel, WhoIsDismissedAgainAndAgainComesEverMoreRarely) {
  TestServer server({});
  ASSERT_TRUE(server.server) << server.error;
  TestViewer viewer(server.server->address());
  std::size_t dismissed = 0;
  ASSERT_TRUE(viewer.until([&] {
    server.poll();
    for (; dismissed < server.joined.size(); ++dismissed)
      server.server->dismiss(server.joined[dismissed].viewer, "no place");
    return viewer.disconnected.size() >= 4;
  })) << viewer.log.text();
  for (const char* wait : {"100", "200", "400", "800"})
    EXPECT_TRUE(viewer.log.has(fmt::format("next try in {} ms", wait))) << viewer.log.text();
}

TEST(Channel, AServerThatStopsSaysSoAndIsFoundAgain) {
  auto server = std::make_unique<TestServer>(ServerOptions{});
  ASSERT_TRUE(server->server) << server->error;
  const Address address = server->server->address();
  TestViewer viewer(address);
  ASSERT_TRUE(viewer.until([&] { return viewer.connected.size() == 1; }));
  server.reset();
  ASSERT_TRUE(viewer.until([&] { return !viewer.disconnected.empty(); }));
  EXPECT_EQ(viewer.disconnected[0].reason, "the server ended it: the server stops");
  EXPECT_FALSE(viewer.client->send(Bytes{1}).has_value());
  // Nobody listens: tries go on, further and further apart.
  ASSERT_TRUE(viewer.until([&] { return viewer.disconnected.size() >= 3; }));
  EXPECT_TRUE(viewer.log.has("next try in 100 ms") && viewer.log.has("next try in 200 ms"))
      << viewer.log.text();
  ServerOptions options;
  options.listen = address;
  server = std::make_unique<TestServer>(options);
  ASSERT_TRUE(server->server) << server->error;
  EXPECT_TRUE(viewer.until([&] { return viewer.connected.size() == 2; })) << viewer.log.text();
}

TEST(Channel, VersionsThatDoNotMeetEndItForGood) {
  ServerOptions options;
  options.versions = {2, 3};
  TestServer server(options);
  ASSERT_TRUE(server.server) << server.error;
  TestViewer viewer(server.server->address());
  EXPECT_EQ(viewer.refusal(),
            "the server refused: this server speaks versions 2 to 3, the viewer version 1: none is common");
}

TEST(Channel, TwoServersCannotHaveOnePort) {
  TestServer server({});
  ASSERT_TRUE(server.server) << server.error;
  ServerOptions options;
  options.listen = server.server->address();
  TestServer other(options);
  EXPECT_NE(other.error.find("in use"), std::string::npos) << other.error;
}

TEST(Address, IsReadAndWritten) {
  EXPECT_EQ(describe(*parseAddress("localhost:7400")), "localhost:7400");
  EXPECT_EQ(describe(*parseAddress("[::1]:1")), "[::1]:1");
  EXPECT_EQ(parseAddress("0.0.0.0:65535")->port, 65535);
  for (const char* bad : {"", "host", ":1", "host:", "host:65536", "host:-1", "host:1x", "::1:5"})
    EXPECT_FALSE(parseAddress(bad).has_value()) << bad;
  for (const char* here : {"127.0.0.1", "127.8.9.10", "::1", "::ffff:127.0.0.1"})
    EXPECT_TRUE(isLoopback(here)) << here;
  for (const char* there : {"0.0.0.0", "::", "10.0.0.1", "128.0.0.1", "::ffff:10.0.0.1", "localhost", ""})
    EXPECT_FALSE(isLoopback(there)) << there;
}

}  // namespace
}  // namespace tessera::transport
