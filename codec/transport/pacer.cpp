#include "codec/transport/pacer.hpp"

#include <algorithm>

namespace tessera::transport {

Pacer::Pacer(Clock::duration interval, double spread) : interval_(interval), spread_(spread) {}

void Pacer::push(std::vector<Datagram> frame, Clock::time_point now) {
  if (frame.empty()) return;
  if (end_ > now + 2 * interval_) {
    for (Due& due : queue_) due.at = std::min(due.at, now);
    end_ = now;
  }
  const Clock::time_point begin = std::max(now, end_);
  const auto length =
      std::min(std::chrono::duration_cast<Clock::duration>(interval_ * spread_), kLongestSpread);
  const auto count = static_cast<Clock::rep>(frame.size());
  for (Clock::rep i = 0; i < count; ++i)
    queue_.push_back({begin + length * i / count, std::move(frame[static_cast<std::size_t>(i)])});
  end_ = begin + length;
}

std::optional<Clock::time_point> Pacer::nextDue() const {
  if (queue_.empty()) return std::nullopt;
  return queue_.front().at;
}

std::optional<Datagram> Pacer::pop(Clock::time_point now) {
  if (queue_.empty() || queue_.front().at > now) return std::nullopt;
  Datagram packet = std::move(queue_.front().packet);
  queue_.pop_front();
  return packet;
}

}  // namespace tessera::transport
