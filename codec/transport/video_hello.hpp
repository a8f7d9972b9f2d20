// The datagram by which a viewer opens its path for video and keeps it open: the server sends nothing to an
// address that did not send one. It is signed with a key that only the session's TCP channel carried, and its
// number must rise: neither a stranger nor a copy can point the stream at someone else.
//
//   u32 "TSVH", u64 session, u64 number, u8[16] of HMAC-SHA-256 over those (little-endian)
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "codec/transport/record.hpp"

namespace tessera::transport {

inline constexpr std::size_t kVideoHelloBytes = 36;
using VideoHelloBytes = std::array<std::uint8_t, kVideoHelloBytes>;

struct VideoHello {
  std::uint64_t session = 0;
  std::uint64_t number = 0;  // higher than any before
};

VideoHelloBytes encode(const VideoHello& hello, std::span<const std::uint8_t, 32> key);
/// What it says, before it is known whether it is true. Fails for a datagram that is none.
Result<VideoHello> readVideoHello(std::span<const std::uint8_t> datagram);
/// Whether it was signed with the key. False for what readVideoHello() refuses.
bool isSigned(std::span<const std::uint8_t> datagram, std::span<const std::uint8_t, 32> key);

}  // namespace tessera::transport
