// A network in between, for tests: TCP and UDP on one port of loopback, passed on to a target with loss,
// delay, jitter, reordering, duplication and a bandwidth limit. The same seed makes the same decisions in the
// same order.
#pragma once

#include <cstdint>
#include <memory>

#include "codec/transport/address.hpp"

namespace tessera::test {

/// Of each direction. What is random is so by packet, independently.
struct Impairment {
  double loss = 0.0;       // of datagrams, [0, 1]
  double duplicate = 0.0;  // of datagrams that come twice
  double reorder = 0.0;    // of datagrams that are held back by reorderMs
  double reorderMs = 5.0;
  double delayMs = 0.0;         // of all, TCP too
  double jitterMs = 0.0;        // up to this much more, of datagrams; they overtake each other
  double megabitPerSecond = 0;  // of datagrams, and apart from them of each TCP connection; 0: no limit
  double queueMs = 100.0;       // with a limit: datagrams that would wait longer are dropped
};

struct ProxyStatistics {
  std::uint64_t datagrams = 0;  // that came, both ways
  std::uint64_t lost = 0;       // by chance
  std::uint64_t overflowed = 0;
  std::uint64_t duplicated = 0;
};

class Proxy {
 public:
  /// Ends the program where no port is free.
  Proxy(const transport::Address& target, const Impairment& impairment, std::uint32_t seed);
  ~Proxy();
  Proxy(const Proxy&) = delete;
  Proxy& operator=(const Proxy&) = delete;

  /// Where to connect instead of the target.
  [[nodiscard]] transport::Address address() const;
  /// From now on.
  void impair(const Impairment& impairment);
  /// Closes every TCP connection; new ones are taken.
  void cut();
  [[nodiscard]] ProxyStatistics statistics() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace tessera::test
