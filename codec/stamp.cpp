#include "codec/stamp.hpp"

#include <algorithm>
#include <array>

extern "C" {
#include <libavutil/crc.h>
}

#include "codec/annexb.hpp"

namespace tessera {

namespace {

// Says whose message it is (ISO/IEC 11578); a random one, made once for this format.
constexpr std::array<std::uint8_t, 16> kUuid = {0x8c, 0x1b, 0x5e, 0x42, 0x97, 0x3d, 0x4f, 0xa6,
                                                0xb2, 0x0e, 0x71, 0xd4, 0x68, 0x29, 0xc5, 0xf3};
constexpr std::uint8_t kVersion = 1;
constexpr std::uint8_t kUserDataUnregistered = 5;  // payloadType
constexpr std::uint8_t kStopBit = 0x80;            // rbsp_trailing_bits

// After header, payloadType and payloadSize, all numbers with their highest byte first:
constexpr std::size_t kUuidAt = 3;
constexpr std::size_t kVersionAt = kUuidAt + kUuid.size();
constexpr std::size_t kFrameAt = kVersionAt + 1;
constexpr std::size_t kReferenceAt = kFrameAt + 8;
constexpr std::size_t kSizeAt = kReferenceAt + 8;  // of the rest of the packet
constexpr std::size_t kSumAt = kSizeAt + 4;  // CRC-32 of all from the version to the size, and of the rest
constexpr std::size_t kEnd = kSumAt + 4;

void put(std::vector<std::uint8_t>& to, std::uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) to.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

std::uint64_t get(std::span<const std::uint8_t> from, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value = value << 8U | from[at + i];
  return value;
}

std::uint32_t checksum(std::span<const std::uint8_t> fields, std::span<const std::uint8_t> packet) {
  const AVCRC* table = av_crc_get_table(AV_CRC_32_IEEE_LE);
  const std::uint32_t sum = av_crc(table, 0xffffffffU, fields.data(), fields.size());
  // It reads before the end of nothing, where nothing is a null pointer.
  return packet.empty() ? ~sum : ~av_crc(table, sum, packet.data(), packet.size());
}

}  // namespace

std::vector<std::uint8_t> stamped(const FrameStamp& stamp, std::span<const std::uint8_t> packet) {
  std::vector<std::uint8_t> message = {static_cast<std::uint8_t>(NalType::Sei), kUserDataUnregistered,
                                       static_cast<std::uint8_t>(kEnd - kUuidAt)};
  message.insert(message.end(), kUuid.begin(), kUuid.end());
  put(message, kVersion, 1);
  put(message, stamp.frame, 8);
  put(message, stamp.reference, 8);
  put(message, packet.size(), 4);
  put(message, checksum(std::span(message).subspan(kVersionAt), packet), 4);
  message.push_back(kStopBit);
  std::vector<std::uint8_t> bytes = {0, 0, 0, 1};
  const auto escaped = escape(message);
  bytes.insert(bytes.end(), escaped.begin(), escaped.end());
  bytes.insert(bytes.end(), packet.begin(), packet.end());
  return bytes;
}

Result<StampedPacket> readStamp(std::span<const std::uint8_t> bytes) {
  Nal nal;
  std::size_t end = 0;
  if (!firstNal(bytes, nal, end))
    return fail("a packet of {} bytes does not begin with a unit", bytes.size());
  if (nal.bytes[0] != static_cast<std::uint8_t>(NalType::Sei))
    return fail("a packet begins with a unit of type {}, not with a stamp", static_cast<int>(nal.type()));
  const auto message = unescape(nal.bytes);
  if (message.size() != kEnd + 1 || message[1] != kUserDataUnregistered || message[2] != kEnd - kUuidAt ||
      message[kEnd] != kStopBit || !std::equal(kUuid.begin(), kUuid.end(), message.begin() + kUuidAt))
    return fail("a packet begins with a message of {} bytes that is no stamp", message.size());
  if (message[kVersionAt] != kVersion)
    return fail("a packet's stamp is of version {}, not {}", message[kVersionAt], kVersion);
  const StampedPacket found{.stamp = {get(message, kFrameAt, 8), get(message, kReferenceAt, 8)},
                            .packet = bytes.subspan(end)};
  if (const std::uint64_t size = get(message, kSizeAt, 4); found.packet.size() != size)
    return fail("frame {}: {} bytes instead of {}", found.stamp.frame, found.packet.size(), size);
  const auto fields = std::span<const std::uint8_t>(message).subspan(kVersionAt, kSumAt - kVersionAt);
  if (checksum(fields, found.packet) != get(message, kSumAt, 4))
    return fail("frame {}: the checksum over its {} bytes differs", found.stamp.frame, found.packet.size());
  return found;
}

}  // namespace tessera
