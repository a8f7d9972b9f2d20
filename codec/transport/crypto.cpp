#include "codec/transport/crypto.hpp"

#include <cstdlib>
#include <memory>
#include <openssl/crypto.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>
#include <vector>

namespace tessera::transport {

Sha256 hmac(std::span<const std::uint8_t> key, std::span<const std::span<const std::uint8_t>> parts) {
  std::vector<std::uint8_t> text;
  for (const auto part : parts) {
    const auto size = static_cast<std::uint32_t>(part.size());
    for (int shift = 0; shift < 32; shift += 8) text.push_back(static_cast<std::uint8_t>(size >> shift));
    text.insert(text.end(), part.begin(), part.end());
  }
  Sha256 tag{};
  unsigned length = 0;
  if (HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()), text.data(), text.size(), tag.data(),
           &length) == nullptr ||
      length != tag.size())
    std::abort();  // out of memory
  return tag;
}

Sha256 sha256(std::span<const std::uint8_t> bytes) {
  Sha256 digest{};
  unsigned length = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &length, EVP_sha256(), nullptr) != 1)
    std::abort();
  return digest;
}

bool same(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

void fillRandom(std::span<std::uint8_t> bytes) {
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) std::abort();
}

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

Result<Sha256> readSha256(std::string_view text) {
  Sha256 value{};
  if (text.size() != 2 * value.size())
    return fail("'{}': {} letters, expected 64 of SHA-256 in hex", text, text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char letter = text[i];
    int digit = 0;
    if (letter >= '0' && letter <= '9') {
      digit = letter - '0';
    } else if (letter >= 'a' && letter <= 'f') {
      digit = letter - 'a' + 10;
    } else {
      return fail("'{}': letter {} is no lower-case hex digit", text, i + 1);
    }
    value[i / 2] = static_cast<std::uint8_t>(value[i / 2] << 4 | digit);
  }
  return value;
}

std::string lastCryptoError() {
  const unsigned long code = ERR_peek_last_error();
  ERR_clear_error();
  const char* reason = ERR_reason_error_string(code);
  return reason == nullptr ? "no reason given" : reason;
}

}  // namespace tessera::transport
