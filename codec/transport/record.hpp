// What lies on the TCP channel: records, each a header and a body, little-endian.
//
//   header     u32 bytes that follow it, u8 kind, u8[3] zero
//   1 hello    u32 kMagic, u16 oldest, u16 newest version spoken, u8 secure, u8[3] zero, u8[32] nonce
//   2 refusal  u8 reason, u8 zero, u16 oldest, u16 newest version that the refusing side speaks, text why
//   3 welcome  u16 version, u16 zero, u8[32] nonce
//   4 proof    u8[32]; see pairing.hpp
//   5 ready    u64 session, u8[32] key of the video hello, u32 SSRC, u8 SRTP profile (0 none, 1
//   AEAD_AES_128_GCM),
//              u8[3] zero, u8[28] master key and salt where the profile is 1
//   6 ping     u64 any number
//   7 pong     the ping's number
//   8 message  bytes of the layer above
//
// A viewer sends hello; the server refusal or welcome; on a secure channel both proof, the viewer's first;
// then the server ready. From then on 2 and 6 to 8 go both ways.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "codec/wire/versions.hpp"
#include "engine/core/result.hpp"

namespace tessera::transport {

inline constexpr std::uint32_t kMagic = 0x50545354;  // "TSTP" as it lies in bytes
inline constexpr std::size_t kRecordHeaderBytes = 8;
/// Longest body of anything but a message.
inline constexpr std::size_t kMostControlBytes = 1024;

using Bytes = std::vector<std::uint8_t>;
using Nonce = std::array<std::uint8_t, 32>;
using Tag = std::array<std::uint8_t, 32>;
using SrtpKey = std::array<std::uint8_t, 28>;

enum class RecordKind : std::uint8_t {
  Hello = 1,
  Refusal = 2,
  Welcome = 3,
  Proof = 4,
  Ready = 5,
  Ping = 6,
  Pong = 7,
  Message = 8
};
/// "hello", or "unknown (9)".
std::string nameOf(RecordKind kind);

/// Of this channel, whatever is spoken on it.
using wire::Versions;

struct Hello {
  Versions versions;
  bool secure = false;
  Nonce nonce{};
};
enum class RefusalReason : std::uint8_t {
  Version = 1,
  Token = 2,        // a wrong one, or a channel that someone sits in
  Certificate = 3,  // not paired
  Security = 4,     // plain TCP where TLS is a must
  Protocol = 5,     // malformed, oversized, out of order
  Busy = 6,
  Closing = 7
};
/// Whether trying again cannot help: versions, token, certificate, security.
bool isFinal(RefusalReason reason);
struct Refusal {
  RefusalReason reason = RefusalReason::Protocol;
  Versions versions;
  std::string why;  // one line for a user; printable ASCII, anything else is shown as '?'
};
struct Welcome {
  std::uint16_t version = 1;
  Nonce nonce{};
};
struct Ready {
  std::uint64_t session = 0;
  std::array<std::uint8_t, 32> helloKey{};
  std::uint32_t source = 0;        // SSRC of the video
  std::optional<SrtpKey> srtpKey;  // on a secure channel
};

Bytes encode(const Hello& hello);
Bytes encode(const Refusal& refusal);
Bytes encode(const Welcome& welcome);
Bytes encodeProof(const Tag& proof);
Bytes encode(const Ready& ready);
Bytes encodePing(std::uint64_t number);
Bytes encodePong(std::uint64_t number);
Bytes encodeMessage(std::span<const std::uint8_t> message);

/// Bodies. Each fails for a wrong length and for any value that is none.
Result<Hello> readHello(std::span<const std::uint8_t> body);
Result<Refusal> readRefusal(std::span<const std::uint8_t> body);
Result<Welcome> readWelcome(std::span<const std::uint8_t> body);
Result<Tag> readProof(std::span<const std::uint8_t> body);
Result<Ready> readReady(std::span<const std::uint8_t> body);
Result<std::uint64_t> readPing(std::span<const std::uint8_t> body);

struct Record {
  RecordKind kind = RecordKind::Hello;
  Bytes body;
};

/// Cuts a stream into records.
class RecordParser {
 public:
  /// mostMessageBytes: longest body of a message. Until allowMessages() a message is refused by its header,
  /// so that a peer that proved nothing costs no more than a control record.
  explicit RecordParser(std::size_t mostMessageBytes) : mostMessageBytes_(mostMessageBytes) {}
  void allowMessages() { messages_ = true; }
  /// Bytes as they came. Whole records wait for next().
  void feed(std::span<const std::uint8_t> bytes);
  /// The next whole record; none while more bytes are needed. Fails for a header that is none or a body that
  /// is too long; then the stream is lost, and every later call fails with the same message.
  Result<std::optional<Record>> next();

 private:
  Result<std::optional<Record>> lose(Error error);

  std::size_t mostMessageBytes_;
  bool messages_ = false;
  bool fresh_ = true;  // no record yet: what comes may be another protocol
  Bytes bytes_;
  std::size_t at_ = 0;
  std::optional<Error> lost_;
};

}  // namespace tessera::transport
