#include "codec/transport/pairing.hpp"

#include <algorithm>
#include <openssl/evp.h>

namespace tessera::transport {

std::string makeToken() {
  constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyz234567";
  std::array<std::uint8_t, 26> random{};
  fillRandom(random);
  std::string token;
  for (const std::uint8_t byte : random) token += letters[byte % letters.size()];
  return token;
}

Result<PairingKey> PairingKey::make(std::string_view token) {
  if (token.size() < kFewestTokenLetters || token.size() > kMostTokenLetters)
    return fail("pairing token: {} letters, expected {} to {}: anyone could try all short ones", token.size(),
                kFewestTokenLetters, kMostTokenLetters);
  if (!std::ranges::all_of(token, [](char letter) { return letter > ' ' && letter <= '~'; }))
    return fail("pairing token: only printable ASCII without spaces is allowed");
  constexpr std::string_view salt = "tessera pairing 1";
  PairingKey key;
  if (EVP_PBE_scrypt(token.data(), token.size(), reinterpret_cast<const unsigned char*>(salt.data()),
                     salt.size(), std::uint64_t{1} << 14, 8, 1, std::uint64_t{64} << 20, key.key_.data(),
                     key.key_.size()) != 1)
    return fail("pairing token: scrypt failed: {}", lastCryptoError());
  return key;
}

Tag prove(const PairingKey& key, Prover who, const Binding& binding, const Nonce& viewerNonce,
          const Nonce& serverNonce) {
  const std::uint8_t prover[] = {static_cast<std::uint8_t>(who)};
  const std::span<const std::uint8_t> parts[] = {
      prover,      binding.exporter, binding.serverCertificate, binding.viewerCertificate,
      viewerNonce, serverNonce};
  return hmac(key.bytes(), parts);
}

}  // namespace tessera::transport
