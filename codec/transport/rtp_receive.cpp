#include "codec/transport/rtp_receive.hpp"

#include <algorithm>
#include <cmath>

#include "codec/transport/h264_payload.hpp"

namespace tessera::transport {

namespace {

// RFC 3550, appendix A.1: how far a sequence number may lie from the last one.
constexpr int kMaxDropout = 3000;
constexpr int kMaxMisorder = 1000;

}  // namespace

RtpReceiver::RtpReceiver(std::uint32_t source, const ReceiveLimits& limits)
    : source_(source), limits_(limits) {}

Result<void> RtpReceiver::push(std::span<const std::uint8_t> datagram, Clock::time_point now) {
  const auto refuse = [&](const Error& error) -> Result<void> {
    ++statistics_.malformed;
    return tl::unexpected(error);
  };
  const auto packet = parseRtp(datagram);
  if (!packet) return refuse(packet.error());
  if (packet->source != source_)
    return refuse({fmt::format("RTP packet: source {:#x}, expected {:#x}", packet->source, source_)});
  const auto sequence = extend(packet->sequence);
  if (!sequence)
    return refuse(
        {fmt::format("RTP packet: sequence number {} is far from those before it", packet->sequence)});
  if (wanted_ && *sequence < *wanted_) {
    ++statistics_.late;
    return {};
  }
  if (const auto placed = place(*packet, *sequence, now); !placed) return refuse(placed.error());
  measure(*packet, datagram.size(), now);
  return {};
}

std::optional<std::int64_t> RtpReceiver::extend(std::uint16_t sequence) {
  if (!highest_) {
    // Room below, for packets that came out of order at the start.
    highest_ = 0x10000 + std::int64_t{sequence};
    return highest_;
  }
  const auto step = static_cast<std::int16_t>(sequence - static_cast<std::uint16_t>(*highest_));
  if (step <= kMaxDropout && step >= -kMaxMisorder) {
    const std::int64_t extended = *highest_ + step;
    highest_ = std::max(*highest_, extended);
    return extended;
  }
  // One stray packet is dropped; two in a row mean that the stream went on without us.
  if (strayNext_ != sequence) {
    strayNext_ = static_cast<std::uint16_t>(sequence + 1);
    return std::nullopt;
  }
  strayNext_.reset();
  const std::int64_t ahead = static_cast<std::uint16_t>(sequence - static_cast<std::uint16_t>(*highest_));
  highest_ = *highest_ + ahead;
  return highest_;
}

Result<void> RtpReceiver::place(const RtpPacket& packet, std::int64_t sequence, Clock::time_point now) {
  const std::int64_t first = sequence - packet.place.index;
  const std::int64_t count = packet.place.count;
  auto found = frames_.find(first);
  if (found == frames_.end()) {
    if (wanted_ && first < *wanted_)
      return fail("frame {}: begins {} packets before the end of one that is done", packet.place.frame,
                  *wanted_ - first);
    const auto after = frames_.lower_bound(first);
    if (after != frames_.end() && first + count > after->first)
      return fail("frame {}: its {} packets reach into frame {}", packet.place.frame, count,
                  after->second.number);
    if (after != frames_.begin()) {
      const auto before = std::prev(after);
      if (before->first + static_cast<std::int64_t>(before->second.payloads.size()) > first)
        return fail("frame {}: begins inside frame {}", packet.place.frame, before->second.number);
    }
    Frame frame;
    frame.number = packet.place.frame;
    frame.timestamp = packet.timestamp;
    frame.payloads.resize(static_cast<std::size_t>(count));
    frame.firstCame = now;
    bytesUnderWay_ += frame.payloads.size() * sizeof(frame.payloads[0]);
    found = frames_.emplace(first, std::move(frame)).first;
  }
  Frame& frame = found->second;
  if (frame.number != packet.place.frame || frame.timestamp != packet.timestamp ||
      frame.payloads.size() != packet.place.count)
    return fail("frame {}: a packet of it has another number, time stamp or count ({}, {}, {})", frame.number,
                packet.place.frame, packet.timestamp, packet.place.count);
  auto& payload = frame.payloads[packet.place.index];
  if (!payload.empty()) {
    ++statistics_.duplicated;
    return {};
  }
  payload.assign(packet.payload.begin(), packet.payload.end());
  bytesUnderWay_ += payload.size();
  ++frame.there;
  frame.lastCame = now;
  ++statistics_.packets;
  return {};
}

bool RtpReceiver::overfull() const {
  return frames_.size() > limits_.frames || bytesUnderWay_ > limits_.bytes;
}

std::optional<Clock::time_point> RtpReceiver::nextDeadline() const {
  if (frames_.empty()) return std::nullopt;
  const auto& [first, frame] = *frames_.begin();
  if (wanted_ && first > *wanted_) return frame.firstCame + limits_.reorder;
  const auto silent = frame.lastCame + limits_.silence;
  const auto later = std::next(frames_.begin());
  return later == frames_.end() ? silent : std::min(silent, later->second.firstCame + limits_.reorder);
}

std::optional<ReceivedFrame> RtpReceiver::next(Clock::time_point now) {
  if (frames_.empty()) return std::nullopt;
  const auto oldest = frames_.begin();
  const std::int64_t gap = wanted_ ? oldest->first - *wanted_ : 0;
  Frame& frame = oldest->second;
  const bool ready = gap == 0 && frame.whole();
  if (!ready && !overfull() && now < *nextDeadline()) return std::nullopt;
  if (gap > 0 && !frame.whole() && !overfull()) {
    // What lies before it is given up; it is itself still waited for.
    statistics_.lost += static_cast<std::uint64_t>(gap);
    wanted_ = oldest->first;
    lostBefore_ = true;
    return next(now);
  }
  statistics_.lost += static_cast<std::uint64_t>(gap) + (frame.payloads.size() - frame.there);
  ReceivedFrame result = assemble(frame);
  result.lostBefore = gap > 0 || lostBefore_;
  lostBefore_ = false;
  ++(result.complete ? statistics_.frames : statistics_.damaged);
  wanted_ = oldest->first + static_cast<std::int64_t>(frame.payloads.size());
  frames_.erase(oldest);
  return result;
}

ReceivedFrame RtpReceiver::assemble(Frame& frame) {
  bytesUnderWay_ -= frame.payloads.size() * sizeof(frame.payloads[0]);
  H264Assembler assembler;
  bool gap = false;
  bool damaged = !frame.whole();
  for (const auto& payload : frame.payloads) {
    if (payload.empty()) {
      gap = true;
      continue;
    }
    bytesUnderWay_ -= payload.size();
    const bool taken = assembler.push(payload, gap).has_value();
    damaged = damaged || !taken;
    gap = !taken;
  }
  damaged = damaged || assembler.damaged();
  return {frame.number, frame.timestamp, assembler.take(), !damaged, false};
}

void RtpReceiver::measure(const RtpPacket& packet, std::size_t bytes, Clock::time_point now) {
  statistics_.bytes += bytes;
  rateBytes_ += bytes;
  if (!rateStart_) rateStart_ = now;
  if (const std::chrono::duration<double> passed = now - *rateStart_; passed.count() >= 1.0) {
    statistics_.mbitPerSecond = 8e-6 * static_cast<double>(rateBytes_) / passed.count();
    rateStart_ = now;
    rateBytes_ = 0;
  }
  // Transit times are compared modulo the send time's range; its half is far more than any network takes.
  constexpr double range = double{kSendTimeRange} / kSendTimeHz;
  const double came = std::chrono::duration<double>(now.time_since_epoch()).count();
  const double transit = came - static_cast<double>(packet.place.sendTime) / kSendTimeHz;
  if (transit_) {
    const double difference = std::abs(std::remainder(transit - *transit_, range));
    statistics_.jitterMs += (1000.0 * difference - statistics_.jitterMs) / 16.0;
  }
  transit_ = transit;
}

}  // namespace tessera::transport
