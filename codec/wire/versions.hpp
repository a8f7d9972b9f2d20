// Which versions of a protocol a side speaks, and which two sides have in common.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include <fmt/core.h>

namespace tessera::wire {

/// Both included.
struct Versions {
  std::uint16_t oldest = 1;
  std::uint16_t newest = 1;
  bool operator==(const Versions&) const = default;
};

/// "version 1", "versions 1 to 3".
inline std::string describe(const Versions& versions) {
  return versions.oldest == versions.newest
             ? fmt::format("version {}", versions.oldest)
             : fmt::format("versions {} to {}", versions.oldest, versions.newest);
}

/// The newest version that both speak; none where their ranges do not meet.
inline std::optional<std::uint16_t> commonVersion(const Versions& a, const Versions& b) {
  const std::uint16_t newest = std::min(a.newest, b.newest);
  if (newest < std::max(a.oldest, b.oldest)) return std::nullopt;
  return newest;
}

}  // namespace tessera::wire
