// Who is let in and who is not, over real TLS: pairing, wrong tokens, strange and changed certificates,
// downgrades.
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ip/udp.hpp>
#include <asio/ssl.hpp>
#include <fstream>

#include <gtest/gtest.h>

#include "codec/transport/identity.hpp"
#include "codec/transport/pins.hpp"
#include "codec/transport/rtp_packet.hpp"
#include "tests/transport/access_units.hpp"
#include "tests/transport/folder.hpp"
#include "tests/transport/pair.hpp"
#include "tests/transport/proxy.hpp"

namespace tessera::transport {
namespace {

using namespace std::chrono_literals;
using asio::ip::tcp;
using test::Folder;
using test::TestServer;
using test::TestViewer;
using test::waitFor;

const std::string kToken = "the-token-that-both-were-given";
const std::string kOther = "a-token-that-nobody-was-given";

bool everywhere(const std::string&) { return true; }

/// A server and a viewer as on two machines: loopback counts as remote for both.
class Security : public ::testing::Test {
 protected:
  ServerOptions serverOptions() const {
    ServerOptions options;
    options.token = kToken;
    options.folder = serverFolder.path();
    options.treatAsRemote = everywhere;
    return options;
  }
  ClientOptions viewerOptions(const Address& server) const {
    ClientOptions options;
    options.server = server;
    options.token = kToken;
    options.folder = viewerFolder.path();
    options.treatAsRemote = everywhere;
    return options;
  }
  Folder serverFolder, viewerFolder, otherFolder;
};

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(Security, ATokenPairsAndTheCertificatesArePinned) {
  TestServer server(serverOptions());
  ASSERT_TRUE(server.server) << server.error;
  const Address address = server.server->address();
  {
    TestViewer viewer(viewerOptions(address));
    EXPECT_EQ(viewer.refusal(), "");
    ASSERT_EQ(viewer.connected.size(), 1u) << viewer.log.text();
    EXPECT_TRUE(viewer.connected[0].secure);
    EXPECT_TRUE(viewer.connected[0].paired);
    EXPECT_EQ(viewer.connected[0].fingerprint, server.server->fingerprint());
    ASSERT_TRUE(server.until([&] { return !server.joined.empty(); }));
    EXPECT_TRUE(server.joined[0].secure);
    ASSERT_TRUE(server.server->send(server.joined[0].viewer, Bytes(2'000'000, 7)).has_value());
    ASSERT_TRUE(viewer.client->send(Bytes{1, 2}).has_value());
    EXPECT_TRUE(
        viewer.until([&] { return viewer.messages.size() == 1 && viewer.messages[0].size() == 2'000'000; }));
    EXPECT_TRUE(server.until([&] { return server.messages.size() == 1; }));
  }
  const auto viewerPins = Pins::load(viewerFolder.path() / "paired");
  const auto serverPins = Pins::load(serverFolder.path() / "paired");
  ASSERT_TRUE(viewerPins && serverPins);
  EXPECT_EQ(viewerPins->serverAt(describe(address)), loadOrMakeIdentity(serverFolder.path())->fingerprint);
  EXPECT_TRUE(serverPins->knowsViewer(loadOrMakeIdentity(viewerFolder.path())->fingerprint));
  // Again: known by now.
  TestViewer viewer(viewerOptions(address));
  EXPECT_EQ(viewer.refusal(), "");
  EXPECT_FALSE(viewer.connected.at(0).paired);
}

TEST_F(Security, AWrongTokenIsRefusedAndPinsNothing) {
  TestServer server(serverOptions());
  ASSERT_TRUE(server.server) << server.error;
  ClientOptions options = viewerOptions(server.server->address());
  options.token = kOther;
  TestViewer viewer(options);
  EXPECT_EQ(
      viewer.refusal(),
      "the server refused: the pairing token is not the same on both sides, or someone sits between them");
  EXPECT_TRUE(waitFor([&] { return server.log.has("refused: the pairing token is not the same"); }));
  EXPECT_FALSE(std::filesystem::exists(viewerFolder.path() / "paired"));
  EXPECT_FALSE(std::filesystem::exists(serverFolder.path() / "paired"));
}

TEST_F(Security, AnUnpairedCertificateIsRefusedByTheServer) {
  ServerOptions options = serverOptions();
  TestServer first(options);
  ASSERT_TRUE(first.server) << first.error;
  TestViewer paired(viewerOptions(first.server->address()));
  ASSERT_EQ(paired.refusal(), "");
  options.pairNew = false;
  TestServer server(options);
  ASSERT_TRUE(server.server) << server.error;
  // The right token, and a certificate that nobody paired with.
  ClientOptions strange = viewerOptions(server.server->address());
  strange.folder = otherFolder.path();
  TestViewer viewer(strange);
  const std::string why = viewer.refusal();
  EXPECT_TRUE(contains(why, "the server refused: the viewer's certificate ")) << why;
  EXPECT_TRUE(contains(why, " is not paired with this server")) << why;
  // The one that was paired is let in.
  TestViewer again(viewerOptions(server.server->address()));
  EXPECT_EQ(again.refusal(), "");
}

TEST_F(Security, AnUnpairedCertificateIsRefusedByTheViewer) {
  TestServer server(serverOptions());
  ASSERT_TRUE(server.server) << server.error;
  ClientOptions options = viewerOptions(server.server->address());
  options.pairNew = false;
  TestViewer viewer(options);
  const std::string why = viewer.refusal();
  EXPECT_TRUE(contains(why, " is not paired with this viewer")) << why;
  EXPECT_TRUE(server.joined.empty());
}

TEST_F(Security, AChangedCertificateIsRefused) {
  ServerOptions options = serverOptions();
  {
    TestServer server(options);
    ASSERT_TRUE(server.server) << server.error;
    options.listen = server.server->address();
    TestViewer viewer(viewerOptions(options.listen));
    ASSERT_EQ(viewer.refusal(), "");
  }
  // Another server at the same address, with the right token.
  options.folder = otherFolder.path();
  TestServer server(options);
  ASSERT_TRUE(server.server) << server.error;
  TestViewer viewer(viewerOptions(options.listen));
  const std::string why = viewer.refusal();
  EXPECT_TRUE(contains(why, "the certificate of " + describe(options.listen) + " changed: paired with "))
      << why;
  EXPECT_TRUE(contains(why, server.server->fingerprint())) << why;
  server.poll();
  EXPECT_TRUE(server.joined.empty());
}

TEST_F(Security, APlainServerOrViewerIsRefusedAtARemoteAddress) {
  ServerOptions plainServer;
  plainServer.treatAsRemote = everywhere;
  EXPECT_TRUE(contains(TestServer(plainServer).error, "listening there needs a pairing token"));
  // Truly remote ones need no test's rule.
  plainServer.treatAsRemote = {};
  plainServer.listen.host = "0.0.0.0";
  EXPECT_TRUE(contains(TestServer(plainServer).error, "listening there needs a pairing token"));

  TestServer server(serverOptions());
  ASSERT_TRUE(server.server) << server.error;
  ClientOptions plainViewer;
  plainViewer.server = server.server->address();
  plainViewer.treatAsRemote = everywhere;
  {
    TestViewer viewer(plainViewer);
    EXPECT_TRUE(contains(viewer.refusal(), "plain TCP is refused, connecting there needs a pairing token"));
  }
  plainViewer.treatAsRemote = {};
  plainViewer.server.host = "192.0.2.1";
  {
    TestViewer viewer(plainViewer);
    EXPECT_TRUE(contains(viewer.refusal(), "plain TCP is refused, connecting there needs a pairing token"));
  }
}

TEST_F(Security, APlainViewerIsRefusedByASecureServer) {
  TestServer server(serverOptions());
  ASSERT_TRUE(server.server) << server.error;
  ClientOptions plain;
  plain.server = server.server->address();
  TestViewer viewer(plain);
  EXPECT_EQ(viewer.refusal(),
            "the server refused: plain TCP is refused: this server asks for TLS and a pairing token");
  EXPECT_TRUE(waitFor(
      [&] { return server.log.has("plain TCP is refused: TLS and a pairing token are a must here"); }));
}

TEST_F(Security, APlainServerIsRefusedByASecureViewer) {
  TestServer server(ServerOptions{});
  ASSERT_TRUE(server.server) << server.error;
  ClientOptions options = viewerOptions(server.server->address());
  options.reconnect = false;
  TestViewer viewer(options);
  const std::string why = viewer.refusal();
  EXPECT_TRUE(contains(why, "TLS handshake refused: ")) << why;
  EXPECT_TRUE(waitFor([&] { return server.log.has("the peer speaks TLS, this side plain TCP"); }));
}

/// A TLS context of OpenSSL's own defaults, with a certificate, at one version.
asio::ssl::context rawContext(asio::ssl::context::method method, const Identity* identity) {
  asio::ssl::context context(method);
  context.set_verify_mode(asio::ssl::verify_none);
  if (identity != nullptr) {
    context.use_certificate(asio::buffer(identity->certificate), asio::ssl::context::pem);
    context.use_private_key(asio::buffer(identity->key), asio::ssl::context::pem);
  }
  return context;
}

TEST_F(Security, TlsBelow13IsRefusedByTheServer) {
  TestServer server(serverOptions());
  ASSERT_TRUE(server.server) << server.error;
  const auto identity = makeIdentity();
  ASSERT_TRUE(identity.has_value());
  asio::io_context io;
  auto context = rawContext(asio::ssl::context::tlsv12_client, &*identity);
  asio::ssl::stream<tcp::socket> old(io, context);
  old.next_layer().connect({asio::ip::make_address("127.0.0.1"), server.server->address().port});
  asio::error_code error;
  old.handshake(asio::ssl::stream_base::client, error);
  EXPECT_TRUE(error);
  EXPECT_TRUE(waitFor([&] { return server.log.has("TLS 1.3 with certificates on both sides is a must"); }));
  EXPECT_TRUE(server.log.has("unsupported protocol")) << server.log.text();
}

TEST_F(Security, AViewerWithoutACertificateIsRefused) {
  TestServer server(serverOptions());
  ASSERT_TRUE(server.server) << server.error;
  asio::io_context io;
  auto context = rawContext(asio::ssl::context::tlsv13_client, nullptr);
  asio::ssl::stream<tcp::socket> bare(io, context);
  bare.next_layer().connect({asio::ip::make_address("127.0.0.1"), server.server->address().port});
  asio::error_code error;
  bare.handshake(asio::ssl::stream_base::client, error);
  EXPECT_TRUE(waitFor([&] { return server.log.has("peer did not return a certificate"); }))
      << server.log.text();
}

TEST_F(Security, TlsBelow13IsRefusedByTheViewer) {
  const auto identity = makeIdentity();
  ASSERT_TRUE(identity.has_value());
  asio::io_context io;
  tcp::acceptor acceptor(io, {asio::ip::make_address("127.0.0.1"), 0});
  ClientOptions options = viewerOptions({"127.0.0.1", acceptor.local_endpoint().port()});
  options.reconnect = false;
  TestViewer viewer(options);
  auto context = rawContext(asio::ssl::context::tlsv12_server, &*identity);
  asio::ssl::stream<tcp::socket> old(io, context);
  acceptor.accept(old.next_layer());
  asio::error_code error;
  old.handshake(asio::ssl::stream_base::server, error);
  EXPECT_TRUE(error);
  const std::string why = viewer.refusal();
  EXPECT_TRUE(contains(why, "TLS 1.3 with certificates on both sides is a must")) << why;
}

// Someone who sits between two TLS connections and passes every byte on: certificates differ, and so do the
// exporters, so that the first proof is refused although both sides have the token.
TEST_F(Security, ARelayInBetweenIsRefused) {
  TestServer server(serverOptions());
  ASSERT_TRUE(server.server) << server.error;
  const auto identity = makeIdentity();
  ASSERT_TRUE(identity.has_value());
  asio::io_context io;
  tcp::acceptor acceptor(io, {asio::ip::make_address("127.0.0.1"), 0});
  TestViewer viewer(viewerOptions({"127.0.0.1", acceptor.local_endpoint().port()}));
  auto front = rawContext(asio::ssl::context::tlsv13_server, &*identity);
  front.set_verify_mode(asio::ssl::verify_peer);
  front.set_verify_callback([](bool, asio::ssl::verify_context&) { return true; });
  auto back = rawContext(asio::ssl::context::tlsv13_client, &*identity);
  asio::ssl::stream<tcp::socket> toViewer(io, front), toServer(io, back);
  acceptor.accept(toViewer.next_layer());
  toViewer.handshake(asio::ssl::stream_base::server);
  toServer.next_layer().connect({asio::ip::make_address("127.0.0.1"), server.server->address().port});
  toServer.handshake(asio::ssl::stream_base::client);
  // Hello there, welcome back, proof there, refusal back.
  const auto relay = [](auto& from, auto& to) {
    Bytes buffer(4096);
    asio::error_code error;
    const std::size_t size = from.read_some(asio::buffer(buffer), error);
    if (!error) asio::write(to, asio::buffer(buffer, size), error);
  };
  relay(toViewer, toServer);
  relay(toServer, toViewer);
  relay(toViewer, toServer);
  relay(toServer, toViewer);
  EXPECT_EQ(
      viewer.refusal(),
      "the server refused: the pairing token is not the same on both sides, or someone sits between them");
  server.poll();
  EXPECT_TRUE(server.joined.empty());
}

TEST_F(Security, VideoIsEncryptedAndComesWhole) {
  ServerOptions options = serverOptions();
  options.frameInterval = 5ms;
  TestServer server(options);
  ASSERT_TRUE(server.server) << server.error;
  TestViewer viewer(viewerOptions(server.server->address()));
  ASSERT_TRUE(server.until([&] { return !server.videoOpen.empty(); }))
      << server.log.text() << viewer.log.text();
  std::mt19937 random(1);
  std::vector<Bytes> sent;
  for (std::uint32_t frame = 1; frame <= 20; ++frame) {
    sent.push_back(test::accessUnit(random, {20, 9000}));
    ASSERT_TRUE(
        server.server->sendVideo(server.joined[0].viewer, frame, std::make_shared<const Bytes>(sent.back()))
            .has_value());
    std::this_thread::sleep_for(5ms);
  }
  ASSERT_TRUE(viewer.until([&] { return viewer.frames.size() == 20; })) << viewer.frames.size();
  for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(viewer.frames[i].bytes, sent[i]);
  const SendStatistics statistics = server.server->viewers().at(0).video;
  // The tag is what SRTP adds to each packet.
  EXPECT_EQ(statistics.bytes, viewer.client->status().video.bytes + 16 * statistics.packets);
}

TEST_F(Security, ATokenNeedsAFolderAndALength) {
  ServerOptions server = serverOptions();
  server.folder.clear();
  EXPECT_TRUE(contains(TestServer(server).error, "needs a folder"));
  server = serverOptions();
  server.token = "short";
  EXPECT_TRUE(contains(TestServer(server).error, "5 letters, expected 20 to 256"));
  ClientOptions viewer = viewerOptions({"127.0.0.1", 1});
  viewer.folder.clear();
  EXPECT_TRUE(contains(TestViewer(viewer).error, "needs a folder"));
}

TEST_F(Security, ABrokenListOfPairingsStopsTheStart) {
  std::ofstream(serverFolder.path() / "paired") << "what?\n";
  EXPECT_TRUE(contains(TestServer(serverOptions()).error, "paired: line 1: expected"));
}

}  // namespace
}  // namespace tessera::transport
