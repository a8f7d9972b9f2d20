// Records, the two ends of the handshake, tokens, certificates and pairings, without a socket.
#include "codec/transport/handshake.hpp"

#include <filesystem>
#include <fstream>
#include <functional>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "codec/transport/identity.hpp"
#include "codec/transport/pins.hpp"
#include "codec/transport/srtp.hpp"
#include "codec/transport/video_hello.hpp"
#include "tests/transport/folder.hpp"

namespace tessera::transport {
namespace {

const std::string kToken = "a-token-of-more-than-20-letters";

PairingKey keyOf(const std::string& token) {
  const auto key = PairingKey::make(token);
  EXPECT_TRUE(key.has_value());
  return *key;
}

Binding bindingOf(std::uint8_t mark) {
  Binding binding;
  binding.exporter.fill(mark);
  return binding;
}

Ready readyOf(bool secure) {
  Ready ready{42, {}, 77, {}};
  ready.helloKey.fill(9);
  if (secure) ready.srtpKey = makeSrtpKey();
  return ready;
}

Bytes bodyOf(const Bytes& record) { return {record.begin() + kRecordHeaderBytes, record.end()}; }

std::vector<Record> cut(const Bytes& bytes) {
  RecordParser parser(1000);
  parser.feed(bytes);
  std::vector<Record> records;
  while (true) {
    auto next = parser.next();
    EXPECT_TRUE(next.has_value()) << next.error().message;
    if (!next || !*next) return records;
    records.push_back(std::move(**next));
  }
}

/// How a handshake ended on both sides.
struct Outcome {
  bool viewerDone = false, serverDone = false;
  std::optional<Refusal> viewerRefused, serverRefused;
  bool viewerByPeer = false, serverByPeer = false;
};

/// Carries records back and forth until neither says more. tamper may change what the server sends.
Outcome shakeHands(
    ClientHandshake& viewer, ServerHandshake& server,
    const std::function<void(Record&)>& tamper = [](Record&) {}) {
  Outcome outcome;
  std::vector<Record> toServer = cut(viewer.begin());
  while (!toServer.empty()) {
    std::vector<Record> toViewer;
    for (const Record& record : toServer) {
      const auto step = server.receive(record);
      outcome.serverDone = outcome.serverDone || step.done;
      if (step.refused) outcome.serverRefused = step.refused, outcome.serverByPeer = step.byPeer;
      for (Record& answer : cut(step.send)) toViewer.push_back(std::move(answer));
      if (step.refused) break;
    }
    toServer.clear();
    for (Record& record : toViewer) {
      tamper(record);
      const auto step = viewer.receive(record);
      outcome.viewerDone = outcome.viewerDone || step.done;
      if (step.refused) outcome.viewerRefused = step.refused, outcome.viewerByPeer = step.byPeer;
      for (Record& answer : cut(step.send)) toServer.push_back(std::move(answer));
      if (step.refused) break;
    }
    // What a side says to one that hung up is not heard.
    if (outcome.serverRefused || outcome.viewerRefused) break;
  }
  return outcome;
}

TEST(Handshake, PlainOnesAgreeOnTheNewestCommonVersion) {
  ClientHandshake viewer({1, 4}, {});
  const Ready ready = readyOf(false);
  ServerHandshake server({2, 7}, {}, ready);
  const Outcome outcome = shakeHands(viewer, server);
  EXPECT_TRUE(outcome.viewerDone && outcome.serverDone);
  EXPECT_EQ(viewer.version(), 4);
  EXPECT_EQ(server.version(), 4);
  EXPECT_EQ(viewer.ready().session, ready.session);
  EXPECT_EQ(viewer.ready().helloKey, ready.helloKey);
  EXPECT_EQ(viewer.ready().source, ready.source);
}

TEST(Handshake, AnIncompatiblePeerIsToldWhichVersionsAreSpoken) {
  ClientHandshake viewer({1, 2}, {});
  ServerHandshake server({3, 5}, {}, readyOf(false));
  const Outcome outcome = shakeHands(viewer, server);
  EXPECT_FALSE(outcome.viewerDone || outcome.serverDone);
  ASSERT_TRUE(outcome.viewerRefused.has_value());
  EXPECT_TRUE(outcome.viewerByPeer);
  EXPECT_EQ(outcome.viewerRefused->reason, RefusalReason::Version);
  EXPECT_EQ(outcome.viewerRefused->versions, (Versions{3, 5}));
  EXPECT_EQ(outcome.viewerRefused->why,
            "this server speaks versions 3 to 5, the viewer versions 1 to 2: none is common");
}

TEST(Handshake, SecureOnesProveTheTokenBothWays) {
  const SecureTerms terms{keyOf(kToken), bindingOf(3)};
  ClientHandshake viewer({}, terms);
  const Ready ready = readyOf(true);
  ServerHandshake server({}, terms, ready);
  const Outcome outcome = shakeHands(viewer, server);
  EXPECT_TRUE(outcome.viewerDone && outcome.serverDone);
  EXPECT_EQ(viewer.ready().srtpKey, ready.srtpKey);
}

TEST(Handshake, AWrongTokenIsRefused) {
  ClientHandshake viewer({}, SecureTerms{keyOf("another-token-of-over-20-letters"), bindingOf(3)});
  ServerHandshake server({}, SecureTerms{keyOf(kToken), bindingOf(3)}, readyOf(true));
  const Outcome outcome = shakeHands(viewer, server);
  EXPECT_FALSE(outcome.viewerDone || outcome.serverDone);
  ASSERT_TRUE(outcome.viewerRefused.has_value());
  EXPECT_EQ(outcome.viewerRefused->reason, RefusalReason::Token);
}

// Whoever sits in between has a TLS connection with each side, and so two exporters, however faithfully it
// passes records on.
TEST(Handshake, AProofRelayedFromAnotherConnectionIsRefused) {
  ClientHandshake viewer({}, SecureTerms{keyOf(kToken), bindingOf(3)});
  ServerHandshake server({}, SecureTerms{keyOf(kToken), bindingOf(4)}, readyOf(true));
  const Outcome outcome = shakeHands(viewer, server);
  EXPECT_FALSE(outcome.viewerDone || outcome.serverDone);
  ASSERT_TRUE(outcome.serverRefused.has_value());
  EXPECT_EQ(outcome.serverRefused->reason, RefusalReason::Token);
}

TEST(Handshake, TheProofCoversBothCertificates) {
  Binding other = bindingOf(3);
  other.serverCertificate.fill(1);
  ClientHandshake viewer({}, SecureTerms{keyOf(kToken), other});
  ServerHandshake server({}, SecureTerms{keyOf(kToken), bindingOf(3)}, readyOf(true));
  EXPECT_FALSE(shakeHands(viewer, server).serverDone);
}

TEST(Handshake, AServerThatDoesNotKnowTheTokenIsRefused) {
  const SecureTerms terms{keyOf(kToken), bindingOf(3)};
  {
    // It answers whatever comes with a proof of its own making.
    ClientHandshake viewer({}, terms);
    ServerHandshake server({}, terms, readyOf(true));
    const Outcome outcome = shakeHands(viewer, server, [](Record& record) {
      if (record.kind == RecordKind::Proof) record.body[5] ^= 1;
    });
    EXPECT_FALSE(outcome.viewerDone);
    ASSERT_TRUE(outcome.viewerRefused.has_value());
    EXPECT_EQ(outcome.viewerRefused->reason, RefusalReason::Token);
  }
  {
    // It sends the viewer's own proof back.
    ClientHandshake viewer({}, terms);
    const auto step = viewer.receive(cut(encode(Welcome{1, {}}))[0]);
    const auto mirrored = viewer.receive(cut(step.send)[0]);
    ASSERT_TRUE(mirrored.refused.has_value());
    EXPECT_EQ(mirrored.refused->reason, RefusalReason::Token);
  }
  {
    // It leaves the proof out.
    ClientHandshake viewer({}, terms);
    (void)viewer.receive(cut(encode(Welcome{1, {}}))[0]);
    const auto step = viewer.receive(cut(encode(readyOf(true)))[0]);
    EXPECT_FALSE(step.done);
    ASSERT_TRUE(step.refused.has_value());
    EXPECT_EQ(step.refused->why, "the server did not prove that it has the pairing token");
  }
}

TEST(Handshake, OneSideSecureIsRefused) {
  const SecureTerms terms{keyOf(kToken), bindingOf(3)};
  {
    ClientHandshake viewer({}, {});
    ServerHandshake server({}, terms, readyOf(true));
    const Outcome outcome = shakeHands(viewer, server);
    ASSERT_TRUE(outcome.viewerRefused.has_value());
    EXPECT_EQ(outcome.viewerRefused->reason, RefusalReason::Security);
  }
  {
    ClientHandshake viewer({}, terms);
    ServerHandshake server({}, {}, readyOf(false));
    EXPECT_EQ(shakeHands(viewer, server).viewerRefused->reason, RefusalReason::Security);
  }
  {
    // A server that gives no key for the video would have it sent in the clear.
    ClientHandshake viewer({}, terms);
    ServerHandshake server({}, terms, readyOf(false));
    EXPECT_EQ(shakeHands(viewer, server).viewerRefused->reason, RefusalReason::Security);
  }
}

TEST(Handshake, RecordsOutOfTurnAreRefused) {
  for (const Bytes& bytes : {encodePing(1), encodeProof({}), encode(Welcome{}), encode(readyOf(false))}) {
    ServerHandshake server({}, {}, readyOf(false));
    const auto step = server.receive(cut(bytes)[0]);
    EXPECT_FALSE(step.done);
    ASSERT_TRUE(step.refused.has_value());
    EXPECT_EQ(step.refused->reason, RefusalReason::Protocol);
  }
  ClientHandshake viewer({}, {});
  EXPECT_TRUE(viewer.receive(cut(encode(readyOf(false)))[0]).refused.has_value());
  ClientHandshake other({3, 3}, {});
  EXPECT_EQ(other.receive(cut(encode(Welcome{2, {}}))[0]).refused->reason, RefusalReason::Version);
}

TEST(Record, ComeOutOfAnyPieces) {
  RecordParser parser(100);
  parser.allowMessages();
  const Bytes all = [] {
    Bytes bytes = encodePing(7);
    for (const Bytes& more : {encodeMessage(Bytes{1, 2, 3}), encodeMessage({}), encodePong(8)})
      bytes.insert(bytes.end(), more.begin(), more.end());
    return bytes;
  }();
  std::vector<Record> records;
  for (const std::uint8_t byte : all) {
    parser.feed({&byte, 1});
    auto next = parser.next();
    ASSERT_TRUE(next.has_value());
    if (*next) records.push_back(std::move(**next));
  }
  ASSERT_EQ(records.size(), 4u);
  EXPECT_EQ(*readPing(records[0].body), 7u);
  EXPECT_EQ(records[1].kind, RecordKind::Message);
  EXPECT_EQ(records[1].body, (Bytes{1, 2, 3}));
  EXPECT_TRUE(records[2].body.empty());
  EXPECT_EQ(records[3].kind, RecordKind::Pong);
}

TEST(Record, HeadersThatAreNoneLoseTheStream) {
  const auto errorOf = [](const Bytes& bytes, bool messages) {
    RecordParser parser(100);
    if (messages) parser.allowMessages();
    parser.feed(bytes);
    const auto next = parser.next();
    EXPECT_FALSE(next.has_value());
    parser.feed(encodePing(1));
    EXPECT_FALSE(parser.next().has_value()) << "lost for good";
    return next ? std::string() : next.error().message;
  };
  EXPECT_EQ(errorOf({0, 0, 0, 0, 9, 0, 0, 0}, true),
            "record of kind 9: there is none, or its header is malformed");
  EXPECT_EQ(errorOf({8, 0, 0, 0, 6, 0, 1, 0}, true),
            "record of kind 6: there is none, or its header is malformed");
  EXPECT_EQ(errorOf({1, 4, 0, 0, 6, 0, 0, 0}, true), "ping: its 1025 bytes are more than 1024");
  EXPECT_EQ(errorOf({101, 0, 0, 0, 8, 0, 0, 0}, true), "message: its 101 bytes are more than 100");
  EXPECT_EQ(errorOf({1, 0, 0, 0, 8, 0, 0, 0}, false), "message: before the handshake's end");
  EXPECT_NE(errorOf({0x16, 0x03, 0x01}, false).find("speaks TLS"), std::string::npos);
}

TEST(Record, BodiesAreCheckedToTheLastByte) {
  // What is cut short or has a byte more is none, whatever it holds.
  const auto wrongLengths = [](const Bytes& record, const auto& read) {
    const Bytes body = bodyOf(record);
    EXPECT_TRUE(read(body).has_value());
    for (std::size_t size = 0; size < body.size(); ++size)
      EXPECT_FALSE(read(std::span(body).first(size)).has_value()) << size;
    Bytes more = body;
    more.push_back(0);
    return read(more).has_value();
  };
  EXPECT_TRUE(wrongLengths(encode(Hello{}), readHello)) << "a later version's hello may be longer";
  EXPECT_FALSE(wrongLengths(encode(Refusal{RefusalReason::Busy, {}, "why"}), readRefusal));
  EXPECT_FALSE(wrongLengths(encode(Welcome{}), readWelcome));
  EXPECT_FALSE(wrongLengths(encodeProof({}), readProof));
  EXPECT_FALSE(wrongLengths(encode(readyOf(true)), readReady));
  EXPECT_FALSE(wrongLengths(encode(readyOf(false)), readReady));
  EXPECT_FALSE(wrongLengths(encodePing(3), readPing));

  Bytes hello = encode(Hello{});
  hello[8] ^= 1;
  EXPECT_FALSE(readHello(bodyOf(hello)).has_value()) << "magic";
  EXPECT_FALSE(readHello(bodyOf(encode(Hello{{2, 1}, false, {}}))).has_value()) << "versions";
  Ready none = readyOf(false);
  none.source = 0;
  EXPECT_FALSE(readReady(bodyOf(encode(none))).has_value()) << "source";
}

TEST(Record, ARefusalSteersNoTerminal) {
  const Bytes record = encode(Refusal{RefusalReason::Busy, {}, "a\x1b[31mb\n"});
  EXPECT_EQ(readRefusal(bodyOf(record))->why, "a?[31mb?");
}

TEST(Pairing, TokensThatCanBeGuessedAreRefused) {
  EXPECT_FALSE(PairingKey::make("").has_value());
  EXPECT_FALSE(PairingKey::make("nineteen-letters-xx").has_value());
  EXPECT_TRUE(PairingKey::make("twenty-letters-xxxxx").has_value());
  EXPECT_FALSE(PairingKey::make("twenty letters and a space").has_value());
  EXPECT_FALSE(PairingKey::make(std::string(257, 'x')).has_value());
  const std::string token = makeToken();
  EXPECT_TRUE(PairingKey::make(token).has_value()) << token;
  EXPECT_NE(token, makeToken());
  // The message must not give away what was typed.
  EXPECT_EQ(PairingKey::make("secret").error().message.find("secret"), std::string::npos);
}

TEST(Identity, IsMadeOnceAndKeptPrivate) {
  const test::Folder folder;
  const auto place = folder.path() / "made" / "here";
  const auto first = loadOrMakeIdentity(place);
  ASSERT_TRUE(first.has_value()) << first.error().message;
  const auto modeOf = [](const std::filesystem::path& path) {
    struct stat found {};
    EXPECT_EQ(stat(path.c_str(), &found), 0);
    return found.st_mode & 0777u;
  };
  EXPECT_EQ(modeOf(place), 0700u);
  EXPECT_EQ(modeOf(place / "key.pem"), 0600u);
  EXPECT_EQ(modeOf(place / "certificate.pem"), 0600u);
  const auto second = loadOrMakeIdentity(place);
  ASSERT_TRUE(second.has_value()) << second.error().message;
  EXPECT_EQ(second->fingerprint, first->fingerprint);
  EXPECT_EQ(second->key, first->key);
  EXPECT_NE(makeIdentity()->fingerprint, first->fingerprint);
}

TEST(Identity, RefusesAKeyThatOthersMayReadOrThatDoesNotFit) {
  const test::Folder folder;
  ASSERT_TRUE(loadOrMakeIdentity(folder.path()).has_value());
  const auto key = folder.path() / "key.pem";
  chmod(key.c_str(), 0640);
  auto loaded = loadOrMakeIdentity(folder.path());
  ASSERT_FALSE(loaded.has_value());
  EXPECT_NE(loaded.error().message.find("mode 640"), std::string::npos) << loaded.error().message;
  chmod(key.c_str(), 0600);
  ASSERT_TRUE(writePrivateFile(key, makeIdentity()->key).has_value());
  loaded = loadOrMakeIdentity(folder.path());
  ASSERT_FALSE(loaded.has_value());
  EXPECT_NE(loaded.error().message.find("not the key of"), std::string::npos) << loaded.error().message;
  ASSERT_TRUE(writePrivateFile(key, "none").has_value());
  EXPECT_FALSE(loadOrMakeIdentity(folder.path()).has_value());
  std::filesystem::remove(key);
  EXPECT_FALSE(loadOrMakeIdentity(folder.path()).has_value()) << "a certificate alone";
}

TEST(Pins, AreKeptAndReadBack) {
  const test::Folder folder;
  const auto file = folder.path() / "paired";
  Sha256 a{}, b{};
  a.fill(0xab);
  b.fill(0x01);
  auto pins = Pins::load(file);
  ASSERT_TRUE(pins.has_value());
  EXPECT_FALSE(pins->serverAt("host:1").has_value());
  ASSERT_TRUE(pins->addServer("host:1", a).has_value());
  ASSERT_TRUE(pins->addViewer(b).has_value());
  EXPECT_FALSE(pins->addServer("host:1", b).has_value()) << "a pin is not replaced";
  const auto again = Pins::load(file);
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(again->serverAt("host:1"), a);
  EXPECT_FALSE(again->serverAt("host:2").has_value());
  EXPECT_TRUE(again->knowsViewer(b));
  EXPECT_FALSE(again->knowsViewer(a));
}

TEST(Pins, NameTheLineThatIsNone) {
  const test::Folder folder;
  const auto file = folder.path() / "paired";
  const std::string good = "viewer " + std::string(64, 'a') + "\n";
  for (const std::string& bad :
       {"viewer " + std::string(63, 'a'), "viewer " + std::string(64, 'g'), "server " + std::string(64, 'a'),
        "friend " + std::string(64, 'a'), good.substr(0, good.size() - 1) + " more", std::string()}) {
    std::ofstream(file) << good << bad << '\n';
    const auto pins = Pins::load(file);
    ASSERT_FALSE(pins.has_value()) << bad;
    EXPECT_NE(pins.error().message.find("line 2"), std::string::npos) << pins.error().message;
  }
}

TEST(VideoHello, IsSignedAndOfItsLength) {
  Sha256 key{}, other{};
  key.fill(5);
  other.fill(6);
  const auto bytes = encode(VideoHello{3, 9}, key);
  const auto hello = readVideoHello(bytes);
  ASSERT_TRUE(hello.has_value());
  EXPECT_EQ(hello->session, 3u);
  EXPECT_EQ(hello->number, 9u);
  EXPECT_TRUE(isSigned(bytes, key));
  EXPECT_FALSE(isSigned(bytes, other));
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    auto altered = bytes;
    altered[i] ^= 1;
    EXPECT_FALSE(isSigned(altered, key)) << "byte " << i;
  }
  EXPECT_FALSE(isSigned(std::span(bytes).first(35), key));
}

TEST(Srtp, HidesAndSignsPackets) {
  const SrtpKey key = makeSrtpKey();
  auto sender = Srtp::make(5, key);
  auto receiver = Srtp::make(5, key);
  auto stranger = Srtp::make(5, makeSrtpKey());
  ASSERT_TRUE(sender && receiver && stranger);
  Bytes plain{0x80, 96, 0, 1, 0, 0, 0, 0, 0, 0, 0, 5};
  for (int i = 0; i < 40; ++i) plain.push_back(0x42);
  Bytes packet = plain;
  ASSERT_TRUE(sender->protect(packet).has_value());
  EXPECT_EQ(packet.size(), plain.size() + kSrtpTagBytes);
  EXPECT_TRUE(std::equal(plain.begin(), plain.begin() + 12, packet.begin())) << "the header stays readable";
  EXPECT_FALSE(std::equal(plain.begin() + 12, plain.end(), packet.begin() + 12));
  Bytes copy = packet;
  EXPECT_FALSE(stranger->unprotect(copy).has_value());
  copy = packet;
  copy[20] ^= 1;
  EXPECT_FALSE(receiver->unprotect(copy).has_value()) << "altered payload";
  copy = packet;
  copy[5] ^= 1;
  EXPECT_FALSE(receiver->unprotect(copy).has_value()) << "altered header";
  copy = packet;
  ASSERT_TRUE(receiver->unprotect(copy).has_value());
  EXPECT_EQ(copy, plain);
  EXPECT_FALSE(receiver->unprotect(packet).has_value()) << "a replay";
  Bytes small(11);
  EXPECT_FALSE(receiver->unprotect(small).has_value());
}

}  // namespace
}  // namespace tessera::transport
