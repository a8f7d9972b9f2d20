#include "codec/transport/record.hpp"

#include <algorithm>

#include "codec/wire/bytes.hpp"

namespace tessera::transport {

namespace {

using wire::ByteReader;
using wire::ByteWriter;

constexpr std::size_t kMostReasonBytes = 512;

ByteWriter begin(RecordKind kind) {
  ByteWriter out;
  out.u32(0);
  out.u8(static_cast<std::uint8_t>(kind));
  for (int i = 0; i < 3; ++i) out.u8(0);
  return out;
}

Bytes end(ByteWriter& out) {
  Bytes bytes = out.take();
  const std::size_t length = bytes.size() - kRecordHeaderBytes;
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(length >> (8 * i));
  return bytes;
}

template <std::size_t N>
std::array<std::uint8_t, N> array(ByteReader& in) {
  std::array<std::uint8_t, N> value{};
  const auto bytes = in.raw(N);
  std::copy(bytes.begin(), bytes.end(), value.begin());
  return value;
}

Result<void> wholly(const ByteReader& in, RecordKind kind, std::size_t size) {
  if (in.failed()) return fail("{}: {} bytes are too few", nameOf(kind), size);
  if (in.left() != 0) return fail("{}: {} of its {} bytes are too many", nameOf(kind), in.left(), size);
  return {};
}

bool zero(ByteReader& in, int count) {
  bool all = true;
  for (int i = 0; i < count; ++i) all = in.u8() == 0 && all;
  return all;
}

Result<void> checkVersions(const Versions& versions, RecordKind kind) {
  if (versions.oldest > versions.newest || versions.oldest == 0)
    return fail("{}: versions {} to {}", nameOf(kind), versions.oldest, versions.newest);
  return {};
}

}  // namespace

std::string nameOf(RecordKind kind) {
  switch (kind) {
    case RecordKind::Hello:
      return "hello";
    case RecordKind::Refusal:
      return "refusal";
    case RecordKind::Welcome:
      return "welcome";
    case RecordKind::Proof:
      return "proof";
    case RecordKind::Ready:
      return "ready";
    case RecordKind::Ping:
      return "ping";
    case RecordKind::Pong:
      return "pong";
    case RecordKind::Message:
      return "message";
  }
  return fmt::format("unknown ({})", static_cast<int>(kind));
}

bool isFinal(RefusalReason reason) {
  return reason == RefusalReason::Version || reason == RefusalReason::Token ||
         reason == RefusalReason::Certificate || reason == RefusalReason::Security;
}

Bytes encode(const Hello& hello) {
  ByteWriter out = begin(RecordKind::Hello);
  out.u32(kMagic);
  out.u16(hello.versions.oldest);
  out.u16(hello.versions.newest);
  out.u8(hello.secure ? 1 : 0);
  for (int i = 0; i < 3; ++i) out.u8(0);
  out.raw(hello.nonce);
  return end(out);
}

Bytes encode(const Refusal& refusal) {
  ByteWriter out = begin(RecordKind::Refusal);
  out.u8(static_cast<std::uint8_t>(refusal.reason));
  out.u8(0);
  out.u16(refusal.versions.oldest);
  out.u16(refusal.versions.newest);
  out.text(std::string_view(refusal.why).substr(0, kMostReasonBytes));
  return end(out);
}

Bytes encode(const Welcome& welcome) {
  ByteWriter out = begin(RecordKind::Welcome);
  out.u16(welcome.version);
  out.u16(0);
  out.raw(welcome.nonce);
  return end(out);
}

Bytes encodeProof(const Tag& proof) {
  ByteWriter out = begin(RecordKind::Proof);
  out.raw(proof);
  return end(out);
}

Bytes encode(const Ready& ready) {
  ByteWriter out = begin(RecordKind::Ready);
  out.u64(ready.session);
  out.raw(ready.helloKey);
  out.u32(ready.source);
  out.u8(ready.srtpKey ? 1 : 0);
  for (int i = 0; i < 3; ++i) out.u8(0);
  if (ready.srtpKey) out.raw(*ready.srtpKey);
  return end(out);
}

Bytes encodePing(std::uint64_t number) {
  ByteWriter out = begin(RecordKind::Ping);
  out.u64(number);
  return end(out);
}

Bytes encodePong(std::uint64_t number) {
  ByteWriter out = begin(RecordKind::Pong);
  out.u64(number);
  return end(out);
}

Bytes encodeMessage(std::span<const std::uint8_t> message) {
  ByteWriter out = begin(RecordKind::Message);
  out.raw(message);
  return end(out);
}

Result<Hello> readHello(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  if (const std::uint32_t magic = in.u32(); magic != kMagic)
    return fail("hello: begins with {:#010x}, expected {:#010x}: this is no peer of tessera", magic, kMagic);
  Hello hello;
  hello.versions.oldest = in.u16();
  hello.versions.newest = in.u16();
  const int secure = in.u8();
  const bool zeroes = zero(in, 3);
  hello.nonce = array<32>(in);
  hello.secure = secure == 1;
  // A later version may have said more after this; what it says then is decided by the version.
  if (in.failed()) return fail("hello: {} bytes are too few", body.size());
  if (const auto checked = checkVersions(hello.versions, RecordKind::Hello); !checked)
    return tl::unexpected(checked.error());
  if (secure > 1 || !zeroes) return fail("hello: secure is {}, or a byte that is to be zero is not", secure);
  return hello;
}

Result<Refusal> readRefusal(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  const int reason = in.u8();
  const bool zeroes = zero(in, 1);
  Refusal refusal;
  refusal.versions.oldest = in.u16();
  refusal.versions.newest = in.u16();
  refusal.why = in.text();
  if (const auto whole = wholly(in, RecordKind::Refusal, body.size()); !whole)
    return tl::unexpected(whole.error());
  if (reason < 1 || reason > static_cast<int>(RefusalReason::Closing) || !zeroes)
    return fail("refusal: of reason {}", reason);
  if (const auto checked = checkVersions(refusal.versions, RecordKind::Refusal); !checked)
    return tl::unexpected(checked.error());
  refusal.reason = static_cast<RefusalReason>(reason);
  // It goes to a terminal: nothing that steers one.
  for (char& letter : refusal.why)
    if (letter < ' ' || letter > '~') letter = '?';
  return refusal;
}

Result<Welcome> readWelcome(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  Welcome welcome;
  welcome.version = in.u16();
  const bool zeroes = zero(in, 2);
  welcome.nonce = array<32>(in);
  if (const auto whole = wholly(in, RecordKind::Welcome, body.size()); !whole)
    return tl::unexpected(whole.error());
  if (!zeroes) return fail("welcome: a byte that is to be zero is not");
  return welcome;
}

Result<Tag> readProof(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  const Tag proof = array<32>(in);
  if (const auto whole = wholly(in, RecordKind::Proof, body.size()); !whole)
    return tl::unexpected(whole.error());
  return proof;
}

Result<Ready> readReady(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  Ready ready;
  ready.session = in.u64();
  ready.helloKey = array<32>(in);
  ready.source = in.u32();
  const int profile = in.u8();
  const bool zeroes = zero(in, 3);
  if (profile == 1) ready.srtpKey = array<28>(in);
  if (const auto whole = wholly(in, RecordKind::Ready, body.size()); !whole)
    return tl::unexpected(whole.error());
  if (profile > 1 || !zeroes) return fail("ready: SRTP profile {} is none", profile);
  if (ready.source == 0) return fail("ready: the video's source is 0");
  return ready;
}

Result<std::uint64_t> readPing(std::span<const std::uint8_t> body) {
  ByteReader in(body);
  const std::uint64_t number = in.u64();
  if (const auto whole = wholly(in, RecordKind::Ping, body.size()); !whole)
    return tl::unexpected(whole.error());
  return number;
}

void RecordParser::feed(std::span<const std::uint8_t> bytes) {
  if (lost_) return;
  // What was read is dropped once it is the larger part, so that a byte is moved a bounded number of times.
  if (at_ > bytes_.size() / 2) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ = 0;
  }
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

Result<std::optional<Record>> RecordParser::lose(Error error) {
  lost_ = std::move(error);
  bytes_ = {};
  at_ = 0;
  return tl::unexpected(*lost_);
}

Result<std::optional<Record>> RecordParser::next() {
  if (lost_) return tl::unexpected(*lost_);
  const auto waiting = std::span<const std::uint8_t>(bytes_).subspan(at_);
  if (fresh_ && waiting.size() >= 2 && waiting[0] == 0x16 && waiting[1] == 0x03)
    return lose(
        {"the peer speaks TLS, this side plain TCP: give the pairing token on both sides or on neither"});
  if (waiting.size() < kRecordHeaderBytes) return std::optional<Record>();
  ByteReader in(waiting);
  const std::size_t length = in.u32();
  const int kind = in.u8();
  if (kind < 1 || kind > static_cast<int>(RecordKind::Message) || !zero(in, 3))
    return lose({fmt::format("record of kind {}: there is none, or its header is malformed", kind)});
  Record record;
  record.kind = static_cast<RecordKind>(kind);
  const bool message = record.kind == RecordKind::Message;
  if (message && !messages_) return lose({"message: before the handshake's end"});
  if (const std::size_t most = message ? mostMessageBytes_ : kMostControlBytes; length > most)
    return lose({fmt::format("{}: its {} bytes are more than {}", nameOf(record.kind), length, most)});
  if (in.left() < length) return std::optional<Record>();
  const auto body = waiting.subspan(kRecordHeaderBytes, length);
  record.body.assign(body.begin(), body.end());
  at_ += kRecordHeaderBytes + length;
  fresh_ = false;
  return std::optional<Record>(std::move(record));
}

}  // namespace tessera::transport
