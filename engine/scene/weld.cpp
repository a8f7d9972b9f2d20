#include "engine/scene/weld.hpp"

#include <bit>
#include <cstring>

namespace tessera {
namespace {

std::uint64_t hashKey(std::span<const float> key) {
  std::uint64_t hash = 0x9e3779b97f4a7c15u;
  for (const float value : key) {
    hash ^= std::bit_cast<std::uint32_t>(value);
    hash *= 0xff51afd7ed558ccdu;
    hash ^= hash >> 32;
  }
  return hash;
}

}  // namespace

std::vector<std::uint32_t> firstEqual(std::span<const float> keys, std::size_t width) {
  const std::size_t count = keys.size() / width;
  std::vector<float> clean(keys.begin(), keys.end());
  for (float& value : clean) value += 0.0f;  // -0 becomes 0
  std::vector<std::uint32_t> table(std::bit_ceil(2 * count + 1), kNone);
  std::vector<std::uint32_t> first(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::span<const float> key = std::span(clean).subspan(i * width, width);
    std::size_t slot = hashKey(key) & (table.size() - 1);
    while (table[slot] != kNone &&
           std::memcmp(&clean[table[slot] * width], key.data(), width * sizeof(float)) != 0) {
      slot = (slot + 1) & (table.size() - 1);
    }
    if (table[slot] == kNone) table[slot] = static_cast<std::uint32_t>(i);
    first[i] = table[slot];
  }
  return first;
}

}  // namespace tessera
