// The pairing token: one secret text that both sides are given, and the proof of knowing it. The proof is
// bound to the TLS connection it travels on (RFC 9266, tls-exporter), so that whoever sits between two TLS
// connections can relay neither side's.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "codec/transport/crypto.hpp"
#include "codec/transport/record.hpp"

namespace tessera::transport {

/// Fewest letters of a token. Whoever a viewer connects to learns a proof made of the token, and can try
/// guesses at leisure: it must not be guessable. makeToken() gives 128 random bits.
inline constexpr std::size_t kFewestTokenLetters = 20;
inline constexpr std::size_t kMostTokenLetters = 256;

/// A new token: 26 letters of base 32.
std::string makeToken();

/// The key that a token gives: scrypt (RFC 7914) with N 2^14, r 8, p 1, so that a guess costs 16 MiB and tens
/// of milliseconds. Made once, not for each connection.
class PairingKey {
 public:
  /// Fails, without showing the token, for one of other than 20 to 256 printable ASCII letters.
  static Result<PairingKey> make(std::string_view token);
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return key_; }

 private:
  std::array<std::uint8_t, 32> key_{};
};

/// What a proof is bound to: one TLS connection, and what both sides chose for it.
struct Binding {
  std::array<std::uint8_t, 32> exporter{};  // label "EXPORTER-Channel-Binding", no context
  Sha256 serverCertificate{};
  Sha256 viewerCertificate{};
};

enum class Prover : std::uint8_t { Viewer = 1, Server = 2 };
/// HMAC-SHA-256 under the key over who proves, the binding and both nonces.
Tag prove(const PairingKey& key, Prover who, const Binding& binding, const Nonce& viewerNonce,
          const Nonce& serverNonce);

}  // namespace tessera::transport
