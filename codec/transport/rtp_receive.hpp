// RTP packets back into access units. libavformat's own receiver hides which frames lost packets, so this one
// is ours: it says of every frame whether it is whole. Knows no socket and no clock of its own.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "codec/transport/pacer.hpp"
#include "codec/transport/rtp_packet.hpp"

namespace tessera::transport {

struct ReceivedFrame {
  std::uint32_t frame = 0;
  std::uint32_t timestamp = 0;  // of kRtpClock
  /// Annex B, four-byte start codes; of a frame with losses, the units that came whole.
  std::vector<std::uint8_t> bytes;
  bool complete = false;  // every packet came, and was well formed
  /// Packets between this frame and the last one handed out never came: whole frames are lost.
  bool lostBefore = false;
};

/// Counted since the start.
struct VideoStatistics {
  std::uint64_t packets = 0;     // used
  std::uint64_t bytes = 0;       // of them, RTP headers included
  std::uint64_t lost = 0;        // packets that were given up
  std::uint64_t duplicated = 0;  // came again
  std::uint64_t late = 0;        // came after they were given up
  std::uint64_t malformed = 0;   // not RTP of this stream, or at odds with other packets
  std::uint64_t frames = 0;      // handed out whole
  std::uint64_t damaged = 0;     // handed out with losses
  double jitterMs = 0.0;         // RFC 3550, sec. 6.4.1, from the send times
  double mbitPerSecond = 0.0;    // over the last whole second, RTP headers included
};

struct ReceiveLimits {
  /// How long a missing packet is waited for once a later frame's have come.
  Clock::duration reorder = std::chrono::milliseconds(20);
  /// How long a frame's missing end is waited for while nothing comes.
  Clock::duration silence = std::chrono::milliseconds(100);
  std::size_t frames = 8;                     // under way at most
  std::size_t bytes = std::size_t{64} << 20;  // of packets under way at most
};

/// One stream's packets in, frames out, in order. What comes from outside costs at most the limits.
class RtpReceiver {
 public:
  /// source: the SSRC that was told; packets of others are malformed.
  explicit RtpReceiver(std::uint32_t source, const ReceiveLimits& limits = {});

  /// A datagram. Fails, and counts it as malformed, where it is none of this stream.
  Result<void> push(std::span<const std::uint8_t> datagram, Clock::time_point now);
  /// The next frame that is whole or given up; call until there is none.
  std::optional<ReceivedFrame> next(Clock::time_point now);
  /// When next() gives up something though no packet comes; nothing while nothing is under way.
  [[nodiscard]] std::optional<Clock::time_point> nextDeadline() const;
  [[nodiscard]] const VideoStatistics& statistics() const { return statistics_; }

 private:
  struct Frame {
    std::uint32_t number = 0;
    std::uint32_t timestamp = 0;
    std::vector<std::vector<std::uint8_t>> payloads;  // empty: not there
    std::size_t there = 0;
    Clock::time_point firstCame, lastCame;
    [[nodiscard]] bool whole() const { return there == payloads.size(); }
  };
  /// Frames by the extended sequence number of their first packet.
  using Frames = std::map<std::int64_t, Frame>;

  std::optional<std::int64_t> extend(std::uint16_t sequence);
  Result<void> place(const RtpPacket& packet, std::int64_t sequence, Clock::time_point now);
  [[nodiscard]] bool overfull() const;
  ReceivedFrame assemble(Frame& frame);
  void measure(const RtpPacket& packet, std::size_t bytes, Clock::time_point now);

  std::uint32_t source_;
  ReceiveLimits limits_;
  VideoStatistics statistics_;
  Frames frames_;
  std::size_t bytesUnderWay_ = 0;
  bool lostBefore_ = false;                 // of the oldest frame under way
  std::optional<std::int64_t> highest_;     // extended sequence number that came
  std::optional<std::int64_t> wanted_;      // first that was neither handed out nor given up
  std::optional<std::uint16_t> strayNext_;  // what would follow a far-off packet, see extend()
  std::optional<double> transit_;           // seconds, of the last packet
  std::optional<Clock::time_point> rateStart_;
  std::uint64_t rateBytes_ = 0;
};

}  // namespace tessera::transport
