// The few primitives of OpenSSL that pairing and the video hello stand on.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "engine/core/result.hpp"

namespace tessera::transport {

using Sha256 = std::array<std::uint8_t, 32>;

/// HMAC-SHA-256 (RFC 2104) of several parts one after the other; a part's length is part of what is hashed,
/// so that no two lists of parts read the same.
Sha256 hmac(std::span<const std::uint8_t> key, std::span<const std::span<const std::uint8_t>> parts);
Sha256 sha256(std::span<const std::uint8_t> bytes);
/// In a time that does not depend on where they differ. Spans of different lengths are different.
bool same(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b);
/// From the system's generator. Ends the program where that fails: going on would be without keys.
void fillRandom(std::span<std::uint8_t> bytes);

/// "0badf00d" in lower case, and back; fails for a wrong length or letter.
std::string hex(std::span<const std::uint8_t> bytes);
Result<Sha256> readSha256(std::string_view text);
/// What OpenSSL's queue says of the last failure, and empties it.
std::string lastCryptoError();

}  // namespace tessera::transport
