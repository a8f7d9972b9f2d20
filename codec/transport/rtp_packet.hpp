// One RTP packet (RFC 3550, sec. 5.1) with the header extension (RFC 8285, sec. 4.2) that every packet of the
// video channel carries, and how it lies in bytes (big-endian, as RTP has it):
//
//   0   RTP header, 12 bytes: version 2, no padding, extension bit set, no contributing sources
//   12  0xBEDE, u16 3: one-byte headers, three words of elements follow
//   16  0x1A: element 1, 11 bytes:
//   17  u32 frame number, u16 place of the packet in its frame, u16 packets in the frame,
//       u24 send time in 2^-18 s, modulo 64 s
//   28  payload (RFC 6184)
//
// The place and the count tell a receiver which packets of which frame are lost, also where a frame's first
// or last ones are. The send time tells delay from pacing, which the RTP timestamp, one for a whole frame,
// cannot; an estimate of the path's rate (adaptive bitrate) would start from it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/result.hpp"

namespace tessera::transport {

inline constexpr std::size_t kRtpHeaderBytes = 12;
inline constexpr std::size_t kRtpExtensionBytes = 16;
inline constexpr std::uint8_t kRtpPayloadType = 96;  // the first dynamic one
inline constexpr std::uint32_t kRtpClock = 90000;    // Hz, RFC 6184, sec. 8.2.1
inline constexpr std::uint32_t kSendTimeHz = 1 << 18;
inline constexpr std::uint32_t kSendTimeRange = 1 << 24;

/// Where a packet belongs.
struct PacketPlace {
  std::uint32_t frame = 0;
  std::uint16_t index = 0;     // < count
  std::uint16_t count = 1;     // > 0
  std::uint32_t sendTime = 0;  // < kSendTimeRange
};

/// A packet as it was read; the payload is borrowed from the bytes.
struct RtpPacket {
  std::uint16_t sequence = 0;
  std::uint32_t timestamp = 0;  // of kRtpClock
  std::uint32_t source = 0;     // SSRC
  bool marker = false;          // the frame's last packet
  PacketPlace place;
  std::span<const std::uint8_t> payload;  // at least one byte
};

/// Reads a packet of this project's video channel. Fails for anything else: another version or payload type,
/// padding, contributing sources, a missing extension, a place past its count, no payload, a marker anywhere
/// but on the last packet.
Result<RtpPacket> parseRtp(std::span<const std::uint8_t> bytes);

/// Puts the extension into a packet that has a bare 12-byte header. Fails where the packet has anything else.
Result<std::vector<std::uint8_t>> withPlace(std::span<const std::uint8_t> packet, const PacketPlace& place);
/// Writes the send time into a packet that withPlace() made. Precondition: it is one.
void stampSendTime(std::span<std::uint8_t> packet, std::uint32_t sendTime);

}  // namespace tessera::transport
