// Access units into RTP packets. libavformat's muxer does the packetising (RFC 6184, mode 1); its packets are
// kept, not sent, so that they can be counted, numbered, paced and encrypted here.
#pragma once

#include <memory>

#include "codec/transport/pacer.hpp"
#include "codec/transport/rtp_packet.hpp"

namespace tessera::transport {

struct RtpStream {
  std::uint32_t source = 1;         // SSRC, not 0: told to the receiver beforehand
  std::uint16_t firstSequence = 0;  // below 2^15: SRTP's rollover counter then starts at 0 on both sides
  std::size_t packetBytes = 1200;   // [128, 65000] with RTP header and extension; what every path carries
};

/// The packets of one stream to one receiver. Not for several threads at once.
/// Forward error correction would be a step after packetise(): packets that protect a frame's others,
/// numbered on from them.
class RtpPacketiser {
 public:
  /// Fails where libavformat has no RTP muxer or a value is out of range.
  static Result<RtpPacketiser> make(const RtpStream& stream);
  RtpPacketiser(RtpPacketiser&&) noexcept;
  RtpPacketiser& operator=(RtpPacketiser&&) noexcept;
  ~RtpPacketiser();

  /// One access unit in annex B form as packets, all with `timestamp` (of kRtpClock, from a random start) and
  /// `frame`. Fails for an empty one, for one without a start code, or one of more than 65535 packets.
  Result<std::vector<Datagram>> packetise(std::span<const std::uint8_t> accessUnit, std::uint32_t frame,
                                          std::uint32_t timestamp);

 private:
  struct State;
  explicit RtpPacketiser(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tessera::transport
