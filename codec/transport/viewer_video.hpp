// The server's side of one viewer's video: packets, pacing, encryption, and the address that the viewer
// opened. Knows no socket: whoever drives it sends what take() gives. For the .cpp files of this folder.
#pragma once

#include <memory>
#include <optional>

#include "codec/transport/pacer.hpp"
#include "codec/transport/record.hpp"
#include "codec/transport/rtp_send.hpp"
#include "codec/transport/srtp.hpp"

namespace tessera::transport {

struct SendStatistics {
  std::uint64_t frames = 0;
  std::uint64_t packets = 0;
  std::uint64_t bytes = 0;     // RTP headers and SRTP tags included
  std::uint64_t unsent = 0;    // packets that the system did not take
  std::uint64_t unopened = 0;  // frames that came while no path was open
};

class ViewerVideo {
 public:
  struct Options {
    Clock::duration interval;
    double spread = 0.8;
    std::size_t packetBytes = 1200;  // of a datagram
  };
  /// ready: what the viewer was told. Fails as RtpPacketiser and Srtp do.
  static Result<ViewerVideo> make(const Ready& ready, const Options& options);

  /// A frame to send from `now` on.
  Result<void> push(std::span<const std::uint8_t> accessUnit, std::uint32_t frame, Clock::time_point now);
  [[nodiscard]] std::optional<Clock::time_point> nextDue() const { return pacer_.nextDue(); }
  /// The next datagram that is due, ready to go. Fails where encryption does.
  Result<std::optional<Datagram>> take(Clock::time_point now);

  /// A video hello of this session came; true where it is signed and new. Only then may anything be sent to
  /// where it came from.
  bool accept(std::span<const std::uint8_t> hello, Clock::time_point now);
  /// Whether a hello came lately.
  [[nodiscard]] bool open(Clock::time_point now) const {
    return lastHello_ && now - *lastHello_ < kHelloSilence;
  }
  SendStatistics statistics;

 private:
  /// A viewer says hello twice a second.
  static constexpr std::chrono::seconds kHelloSilence{5};

  ViewerVideo(const Ready& ready, const Options& options, RtpPacketiser packetiser, std::optional<Srtp> srtp);

  Ready ready_;
  RtpPacketiser packetiser_;
  std::optional<Srtp> srtp_;
  Pacer pacer_;
  std::uint32_t ticksPerFrame_;
  std::uint32_t firstTimestamp_;
  std::uint64_t lastNumber_ = 0;
  std::optional<Clock::time_point> lastHello_;
};

}  // namespace tessera::transport
