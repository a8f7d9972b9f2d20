// SRTP (RFC 3711) with AES-128-GCM (RFC 7714) over libsrtp: one stream, sent or received; which of the two
// shows at its first packet.
#pragma once

#include <memory>
#include <vector>

#include "codec/transport/record.hpp"

namespace tessera::transport {

/// Bytes that protecting adds to a packet.
inline constexpr std::size_t kSrtpTagBytes = 16;

SrtpKey makeSrtpKey();

class Srtp {
 public:
  /// source: the stream's SSRC. Fails where libsrtp refuses, or was built without AES-GCM.
  static Result<Srtp> make(std::uint32_t source, const SrtpKey& key);
  Srtp(Srtp&&) noexcept;
  Srtp& operator=(Srtp&&) noexcept;
  ~Srtp();

  /// Encrypts and signs a packet in place. The header and its extension stay readable, and are signed.
  Result<void> protect(std::vector<std::uint8_t>& packet);
  /// The other way round. Fails for one that was not protected with this key, was altered, or came before.
  Result<void> unprotect(std::vector<std::uint8_t>& packet);

 private:
  struct State;
  explicit Srtp(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tessera::transport
