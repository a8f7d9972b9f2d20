#include "codec/transport/rtp_packet.hpp"

#include <algorithm>

namespace tessera::transport {

namespace {

constexpr std::size_t kWhole = kRtpHeaderBytes + kRtpExtensionBytes;
constexpr std::size_t kSendTimeAt = 25;

std::uint32_t big(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | bytes[at + i];
  return value;
}

void putBig(std::span<std::uint8_t> bytes, std::size_t at, std::size_t count, std::uint32_t value) {
  for (std::size_t i = 0; i < count; ++i)
    bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * (count - 1 - i)));
}

}  // namespace

Result<RtpPacket> parseRtp(std::span<const std::uint8_t> bytes) {
  if (bytes.size() <= kWhole)
    return fail("RTP packet: {} bytes, at least {} are needed", bytes.size(), kWhole + 1);
  if (bytes[0] != 0x90)
    return fail("RTP packet: first byte {:#04x}, expected 0x90: version 2, an extension, nothing else",
                bytes[0]);
  RtpPacket packet;
  packet.marker = (bytes[1] & 0x80) != 0;
  if (const int type = bytes[1] & 0x7f; type != kRtpPayloadType)
    return fail("RTP packet: payload type {}, expected {}", type, kRtpPayloadType);
  packet.sequence = static_cast<std::uint16_t>(big(bytes, 2, 2));
  packet.timestamp = big(bytes, 4, 4);
  packet.source = big(bytes, 8, 4);
  if (const std::uint32_t head = big(bytes, 12, 4); head != 0xBEDE0003)
    return fail("RTP packet: header extension {:#010x}, expected 0xbede0003", head);
  if (bytes[16] != 0x1A) return fail("RTP packet: extension element {:#04x}, expected 0x1a", bytes[16]);
  packet.place.frame = big(bytes, 17, 4);
  packet.place.index = static_cast<std::uint16_t>(big(bytes, 21, 2));
  packet.place.count = static_cast<std::uint16_t>(big(bytes, 23, 2));
  packet.place.sendTime = big(bytes, kSendTimeAt, 3);
  if (packet.place.index >= packet.place.count)
    return fail("RTP packet: number {} of the {} of frame {}", packet.place.index, packet.place.count,
                packet.place.frame);
  if (packet.marker != (packet.place.index + 1 == packet.place.count))
    return fail("RTP packet: marker {} on number {} of the {} of frame {}", packet.marker ? 1 : 0,
                packet.place.index, packet.place.count, packet.place.frame);
  packet.payload = bytes.subspan(kWhole);
  return packet;
}

Result<std::vector<std::uint8_t>> withPlace(std::span<const std::uint8_t> packet, const PacketPlace& place) {
  if (packet.size() <= kRtpHeaderBytes || packet[0] != 0x80)
    return fail("RTP packet of {} bytes: not a bare 12-byte header and a payload", packet.size());
  std::vector<std::uint8_t> whole(packet.size() + kRtpExtensionBytes);
  std::copy_n(packet.begin(), kRtpHeaderBytes, whole.begin());
  std::copy(packet.begin() + kRtpHeaderBytes, packet.end(), whole.begin() + kWhole);
  whole[0] = 0x90;
  putBig(whole, 12, 4, 0xBEDE0003);
  whole[16] = 0x1A;
  putBig(whole, 17, 4, place.frame);
  putBig(whole, 21, 2, place.index);
  putBig(whole, 23, 2, place.count);
  putBig(whole, kSendTimeAt, 3, place.sendTime % kSendTimeRange);
  return whole;
}

void stampSendTime(std::span<std::uint8_t> packet, std::uint32_t sendTime) {
  putBig(packet, kSendTimeAt, 3, sendTime % kSendTimeRange);
}

}  // namespace tessera::transport
