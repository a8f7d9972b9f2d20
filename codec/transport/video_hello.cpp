#include "codec/transport/video_hello.hpp"

#include <algorithm>

#include "codec/transport/crypto.hpp"
#include "codec/wire/bytes.hpp"

namespace tessera::transport {

namespace {

constexpr std::uint32_t kHelloMagic = 0x48565354;  // "TSVH"
constexpr std::size_t kSignedBytes = 20;
constexpr std::size_t kTagBytes = kVideoHelloBytes - kSignedBytes;

Sha256 tagOf(std::span<const std::uint8_t> text, std::span<const std::uint8_t, 32> key) {
  const std::span<const std::uint8_t> parts[] = {text};
  return hmac(key, parts);
}

}  // namespace

VideoHelloBytes encode(const VideoHello& hello, std::span<const std::uint8_t, 32> key) {
  wire::ByteWriter out;
  out.u32(kHelloMagic);
  out.u64(hello.session);
  out.u64(hello.number);
  const Sha256 tag = tagOf(out.bytes(), key);
  out.raw(std::span(tag).first(kTagBytes));
  VideoHelloBytes bytes{};
  std::copy(out.bytes().begin(), out.bytes().end(), bytes.begin());
  return bytes;
}

Result<VideoHello> readVideoHello(std::span<const std::uint8_t> datagram) {
  if (datagram.size() != kVideoHelloBytes)
    return fail("video hello: {} bytes, expected {}", datagram.size(), kVideoHelloBytes);
  wire::ByteReader in(datagram);
  if (const std::uint32_t magic = in.u32(); magic != kHelloMagic)
    return fail("video hello: begins with {:#010x}", magic);
  VideoHello hello;
  hello.session = in.u64();
  hello.number = in.u64();
  return hello;
}

bool isSigned(std::span<const std::uint8_t> datagram, std::span<const std::uint8_t, 32> key) {
  if (!readVideoHello(datagram)) return false;
  const Sha256 tag = tagOf(datagram.first(kSignedBytes), key);
  return same(std::span(tag).first(kTagBytes), datagram.subspan(kSignedBytes));
}

}  // namespace tessera::transport
