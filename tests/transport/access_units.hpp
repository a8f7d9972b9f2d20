// Access units for tests of the video channel: random units that look like H.264's to whoever packs them.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace tessera::test {

/// Annex B with four-byte start codes. `sizes`: of each unit, at least 2. Random bytes above 0 after a header
/// of a slice's or a parameter set's type, so that no start code comes about.
inline std::vector<std::uint8_t> accessUnit(std::mt19937& random, const std::vector<std::size_t>& sizes) {
  std::vector<std::uint8_t> bytes;
  for (const std::size_t size : sizes) {
    bytes.insert(bytes.end(), {0, 0, 0, 1, static_cast<std::uint8_t>(size < 50 ? 0x67 : 0x65)});
    for (std::size_t i = 1; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(1 + random() % 255));
  }
  return bytes;
}

}  // namespace tessera::test
