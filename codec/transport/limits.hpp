// What a peer may cost, and how long it may take.
#pragma once

#include <chrono>
#include <cstddef>

namespace tessera::transport {

struct Limits {
  std::size_t messageBytes = std::size_t{64} << 20;  // longest message that is taken
  /// Bytes that may wait to be sent to a peer; past that it is too slow, and is cut off.
  std::size_t pendingBytes = std::size_t{64} << 20;
  /// Bytes that may wait to be polled; past that nothing more is read until they are.
  std::size_t inboxBytes = std::size_t{128} << 20;
  std::chrono::milliseconds handshake{5000};  // from the connection to its end
  std::chrono::milliseconds ping{1000};       // between two
  std::chrono::milliseconds silence{5000};    // without a byte: the peer is gone
};

}  // namespace tessera::transport
