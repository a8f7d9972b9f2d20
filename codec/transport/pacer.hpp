// When each packet of a frame leaves: spread over the frame time, never in a burst. Knows no socket and no
// clock of its own.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

namespace tessera::transport {

using Clock = std::chrono::steady_clock;
using Datagram = std::vector<std::uint8_t>;

/// A queue of packets with the time at which each is due. A frame's packets are due at even steps over
/// `spread` of the interval, or kLongestSpread where that is shorter, from the moment the frame came or the
/// one before it ends, whichever is later. Where frames come faster than that, what waits longer than two
/// intervals is due at once, so that the queue never holds back more than that.
class Pacer {
 public:
  /// A receiver that waits for a frame's next packet must not give it up.
  static constexpr Clock::duration kLongestSpread = std::chrono::milliseconds(50);

  /// interval: of frames, > 0. spread: (0, 1]; the rest of the interval is slack for a late timer.
  explicit Pacer(Clock::duration interval, double spread = 0.8);

  void push(std::vector<Datagram> frame, Clock::time_point now);
  /// When the next packet is due; nothing when none waits.
  [[nodiscard]] std::optional<Clock::time_point> nextDue() const;
  /// The next packet if it is due by `now`.
  std::optional<Datagram> pop(Clock::time_point now);
  [[nodiscard]] std::size_t waiting() const { return queue_.size(); }

 private:
  struct Due {
    Clock::time_point at;
    Datagram packet;
  };
  Clock::duration interval_;
  double spread_;
  std::deque<Due> queue_;
  Clock::time_point end_{};  // of the frame pushed last
};

}  // namespace tessera::transport
