#include "engine/scene/weld.hpp"

#include <algorithm>
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

// All attributes of the primitive's vertices, one key a vertex.
std::vector<float> attributeKeys(const Vertices& vertices, const Primitive& primitive, std::size_t& width) {
  width = 6 + (vertices.tangent.empty() ? 0u : 4u) + (vertices.uv0.empty() ? 0u : 2u) +
          (vertices.uv1.empty() ? 0u : 2u) + (vertices.color.empty() ? 0u : 4u);
  std::vector<float> keys;
  keys.reserve(width * primitive.vertexCount);
  const auto put = [&](const auto& array, std::size_t i) {
    for (int c = 0; !array.empty() && c < array[i].length(); ++c) keys.push_back(array[i][c]);
  };
  for (std::size_t i = primitive.firstVertex; i < std::size_t{primitive.firstVertex} + primitive.vertexCount;
       ++i) {
    put(vertices.position, i);
    put(vertices.normal, i);
    put(vertices.tangent, i);
    put(vertices.uv0, i);
    put(vertices.uv1, i);
    put(vertices.color, i);
  }
  return keys;
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

std::size_t weldVertices(Scene& scene) {
  const std::size_t before = scene.vertices.position.size();
  Vertices welded;
  const auto copy = [](auto& to, const auto& from, std::size_t i) {
    if (!from.empty()) to.push_back(from[i]);
  };
  for (Primitive& primitive : scene.primitives) {
    std::size_t width = 0;
    const std::vector<float> keys = attributeKeys(scene.vertices, primitive, width);
    const std::vector<std::uint32_t> first = firstEqual(keys, width);
    const std::span<std::uint32_t> indices(scene.indices.data() + primitive.firstIndex, primitive.indexCount);
    std::vector<std::uint32_t> place(primitive.vertexCount, kNone);
    for (const std::uint32_t index : indices) place[first[index - primitive.firstVertex]] = 0;
    const auto base = static_cast<std::uint32_t>(welded.position.size());
    for (std::uint32_t i = 0; i < primitive.vertexCount; ++i) {
      if (place[i] == kNone) continue;
      const std::size_t source = std::size_t{primitive.firstVertex} + i;
      place[i] = static_cast<std::uint32_t>(welded.position.size());
      copy(welded.position, scene.vertices.position, source);
      copy(welded.normal, scene.vertices.normal, source);
      copy(welded.tangent, scene.vertices.tangent, source);
      copy(welded.uv0, scene.vertices.uv0, source);
      copy(welded.uv1, scene.vertices.uv1, source);
      copy(welded.color, scene.vertices.color, source);
    }
    for (std::uint32_t& index : indices) index = place[first[index - primitive.firstVertex]];
    primitive.firstVertex = base;
    primitive.vertexCount = static_cast<std::uint32_t>(welded.position.size()) - base;
  }
  scene.vertices = std::move(welded);
  return before - std::min(before, scene.vertices.position.size());
}

}  // namespace tessera
