// RTP payloads of H.264 (RFC 6184) back into units: single units, aggregates (STAP-A) and fragments (FU-A),
// the three that a sender in packetization mode 1 may use.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/result.hpp"

namespace tessera::transport {

/// Puts one frame's payloads, in order, back into an access unit in annex B form (ITU-T H.264, 08/2021),
/// every unit behind a four-byte start code.
class H264Assembler {
 public:
  /// The next payload. `gap`: payloads before it are lost; a unit that was under way is dropped, and so is
  /// one whose first fragment is missing. Fails for what RFC 6184 does not allow in mode 1; the payload is
  /// then skipped as though it were lost.
  Result<void> push(std::span<const std::uint8_t> payload, bool gap);
  /// Whether something is missing: a gap, a payload that failed, or a unit without its last fragment.
  [[nodiscard]] bool damaged() const { return damaged_ || inFragment_; }
  /// The whole units so far; the assembler is empty and undamaged after this.
  std::vector<std::uint8_t> take();

 private:
  Result<void> single(std::span<const std::uint8_t> unit);
  Result<void> aggregate(std::span<const std::uint8_t> payload);
  Result<void> fragment(std::span<const std::uint8_t> payload);
  void dropFragment();

  std::vector<std::uint8_t> bytes_;
  std::size_t unitAt_ = 0;  // where the unit under way began
  bool inFragment_ = false;
  std::uint8_t fragmentHeader_ = 0;
  bool damaged_ = false;
};

}  // namespace tessera::transport
