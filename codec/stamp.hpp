// What each packet of video begins with: the frame's number, the frame that it builds on, and a checksum.
// H.264 itself has none of these: a packet that lost its end, or one bit, often still decodes, to a broken
// picture that every later one builds on; and its own count of frames wraps after 16. The stamp is an SEI
// message of unregistered user data (ITU-T H.264, annex D.1.7), which other decoders skip.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/result.hpp"

namespace tessera {

struct FrameStamp {
  std::uint64_t frame = 0;      // the host's number
  std::uint64_t reference = 0;  // number of the frame that it builds on; its own for an I-frame
  [[nodiscard]] bool iFrame() const { return frame == reference; }
};

/// The packet with its stamp in front. `packet` is one frame in the byte stream format.
std::vector<std::uint8_t> stamped(const FrameStamp& stamp, std::span<const std::uint8_t> packet);

/// The stamp that a packet begins with, and where the rest begins. Fails where there is none, where it is of
/// another version, where the packet is shorter or longer than it says, and where the checksum differs.
struct StampedPacket {
  FrameStamp stamp;
  std::span<const std::uint8_t> packet;
};
Result<StampedPacket> readStamp(std::span<const std::uint8_t> bytes);

}  // namespace tessera
