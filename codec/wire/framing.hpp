// Messages out of a stream of bytes that arrives in pieces, and into one that leaves in pieces.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "codec/wire/message.hpp"

namespace tessera::wire {

/// Cuts a stream into messages. Takes no more memory than the pieces it is fed and one message of
/// the kind that is under way.
class MessageParser {
 public:
  /// With a peer's role, headers of what such a peer may not send are refused, and of all but a hello or a
  /// refusal as the first: nobody makes this side hold more bytes than a hello has before MessageOrder has
  /// seen one.
  explicit MessageParser(std::optional<Role> peer = {}) : peer_(peer) {}
  /// Bytes as they came, any number of them. The whole messages among them wait for next().
  void feed(std::span<const std::uint8_t> bytes);
  /// The next whole message; none while more bytes are needed. Fails for a header or a body that is none;
  /// then the stream is lost, and every later call fails with the same message.
  Result<std::optional<Message>> next();

  /// Bytes of a message that is not whole yet. A peer that keeps this above 0 for long is slow, or stuck.
  [[nodiscard]] std::size_t pending() const { return bytes_.size() - at_; }
  /// Bytes that the message under way still lacks: of its header, while that is not whole.
  [[nodiscard]] std::size_t lacking() const;

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t at_ = 0;
  std::optional<Error> lost_;
  std::optional<Role> peer_;
  bool first_ = true;
};

/// Messages on their way out. What the socket takes at once is up to the socket.
class SendQueue {
 public:
  /// Fails, and queues nothing, where encode() fails or more than `limit` bytes would wait: the peer is too
  /// slow.
  Result<void> push(const Message& message);
  explicit SendQueue(std::size_t limit = std::size_t{64} << 20) : limit_(limit) {}
  /// What to send next; empty when nothing waits.
  [[nodiscard]] std::span<const std::uint8_t> front() const;
  /// The first `count` bytes of front() are gone.
  void sent(std::size_t count);
  /// Bytes that wait.
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  std::deque<std::vector<std::uint8_t>> messages_;
  std::size_t at_ = 0;
  std::size_t pending_ = 0;
  std::size_t limit_;
};

}  // namespace tessera::wire
