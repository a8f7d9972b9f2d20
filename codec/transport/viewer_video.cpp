#include "codec/transport/viewer_video.hpp"

#include <cmath>

#include "codec/transport/crypto.hpp"
#include "codec/transport/video_hello.hpp"

namespace tessera::transport {

namespace {

template <class T>
T randomNumber() {
  T value = 0;
  fillRandom({reinterpret_cast<std::uint8_t*>(&value), sizeof(value)});
  return value;
}

}  // namespace

Result<ViewerVideo> ViewerVideo::make(const Ready& ready, const Options& options) {
  const std::size_t tag = ready.srtpKey ? kSrtpTagBytes : 0;
  // Random starts, as RFC 3550, sec. 5.1 has it; low ones, so that SRTP's rollover counter begins at 0.
  const auto first = static_cast<std::uint16_t>(randomNumber<std::uint16_t>() % 0x4000);
  auto packetiser = RtpPacketiser::make({ready.source, first, options.packetBytes - tag});
  if (!packetiser) return tl::unexpected(packetiser.error());
  std::optional<Srtp> srtp;
  if (ready.srtpKey) {
    auto made = Srtp::make(ready.source, *ready.srtpKey);
    if (!made) return tl::unexpected(made.error());
    srtp = std::move(*made);
  }
  return ViewerVideo(ready, options, std::move(*packetiser), std::move(srtp));
}

ViewerVideo::ViewerVideo(const Ready& ready, const Options& options, RtpPacketiser packetiser,
                         std::optional<Srtp> srtp)
    : ready_(ready),
      packetiser_(std::move(packetiser)),
      srtp_(std::move(srtp)),
      pacer_(options.interval, options.spread),
      ticksPerFrame_(static_cast<std::uint32_t>(
          std::lround(kRtpClock * std::chrono::duration<double>(options.interval).count()))),
      firstTimestamp_(randomNumber<std::uint32_t>()) {}

Result<void> ViewerVideo::push(std::span<const std::uint8_t> accessUnit, std::uint32_t frame,
                               Clock::time_point now) {
  auto packets = packetiser_.packetise(accessUnit, frame, firstTimestamp_ + frame * ticksPerFrame_);
  if (!packets) return tl::unexpected(packets.error());
  ++statistics.frames;
  pacer_.push(std::move(*packets), now);
  return {};
}

Result<std::optional<Datagram>> ViewerVideo::take(Clock::time_point now) {
  auto packet = pacer_.pop(now);
  if (!packet) return std::optional<Datagram>();
  const double seconds = std::chrono::duration<double>(now.time_since_epoch()).count();
  stampSendTime(*packet, static_cast<std::uint32_t>(static_cast<std::uint64_t>(seconds * kSendTimeHz)));
  if (srtp_)
    if (const auto done = srtp_->protect(*packet); !done) return tl::unexpected(done.error());
  ++statistics.packets;
  statistics.bytes += packet->size();
  return packet;
}

bool ViewerVideo::accept(std::span<const std::uint8_t> hello, Clock::time_point now) {
  const auto read = readVideoHello(hello);
  if (!read || read->session != ready_.session || read->number <= lastNumber_) return false;
  if (!isSigned(hello, ready_.helloKey)) return false;
  lastNumber_ = read->number;
  lastHello_ = now;
  return true;
}

}  // namespace tessera::transport
