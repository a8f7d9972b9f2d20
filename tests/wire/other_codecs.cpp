#include "tests/wire/other_codecs.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <meshoptimizer.h>
#include <zstd.h>

namespace tessera::test {

namespace {

double zstdBits(std::span<const unsigned char> bytes) {
  if (bytes.empty()) return 0.0;
  std::vector<char> out(ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 9);
  return 8.0 * static_cast<double>(std::min(size, bytes.size()));
}

double vertexCodecBits(const void* vertices, std::size_t count, std::size_t stride) {
  if (count == 0) return 0.0;
  std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), vertices, count, stride));
  return zstdBits(out);
}

// Of the order that suits these values best.
double golombBits(std::span<const std::uint32_t> values) {
  double best = std::numeric_limits<double>::infinity();
  for (int order = 0; order < 20; ++order) {
    double bits = 5.0;
    for (const std::uint32_t value : values) {
      const int width = std::bit_width((std::uint64_t{value} >> order) + 1);
      bits += 2 * width - 1 + order;
    }
    best = std::min(best, bits);
  }
  return values.empty() ? 0.0 : best;
}

double differenceBits(std::span<const std::uint32_t> values, std::size_t stride) {
  double bits = 0.0;
  for (std::size_t attribute = 0; attribute < stride; ++attribute) {
    std::vector<std::uint32_t> steps;
    std::uint32_t last = 0;
    for (std::size_t i = attribute; i < values.size(); i += stride) {
      const std::uint32_t step = values[i] - last;
      steps.push_back((step << 1) ^ ((step >> 31) != 0 ? 0xffffffffu : 0u));
      last = values[i];
    }
    bits += golombBits(steps);
  }
  return bits;
}

double octreeBits(std::span<glm::uvec3> points, int depth) {
  if (points.empty() || depth == 0) return 0.0;
  if (points.size() == 1) return 3.0 * depth;
  const auto childOf = [&](const glm::uvec3& p) {
    return ((p.x >> (depth - 1)) & 1u) | ((p.y >> (depth - 1)) & 1u) << 1 | ((p.z >> (depth - 1)) & 1u) << 2;
  };
  std::sort(points.begin(), points.end(),
            [&](const auto& a, const auto& b) { return childOf(a) < childOf(b); });
  // Which children there are, and whether each has one point.
  double bits = 8.0;
  for (std::size_t first = 0; first < points.size();) {
    std::size_t last = first;
    while (last < points.size() && childOf(points[last]) == childOf(points[first])) ++last;
    bits += 1.0 + octreeBits(points.subspan(first, last - first), depth - 1);
    first = last;
  }
  return bits;
}

}  // namespace

PlainBits meshoptimizerBits(const PlainMessage& message) {
  PlainBits bits;
  std::vector<std::int32_t> vertices;
  for (std::size_t i = 0; i < message.vertices.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) vertices.push_back(message.vertices[i][axis]);
    vertices.push_back(message.levels[i]);
  }
  bits.vertices = vertexCodecBits(vertices.data(), message.vertices.size(), 16);
  if (!message.triangles.empty()) {
    const std::uint32_t most = *std::max_element(message.triangles.begin(), message.triangles.end());
    std::vector<unsigned char> out(meshopt_encodeIndexBufferBound(message.triangles.size(), most + 1));
    out.resize(meshopt_encodeIndexBuffer(out.data(), out.size(), message.triangles.data(),
                                         message.triangles.size()));
    bits.triangles = zstdBits(out);
  }
  bits.places =
      vertexCodecBits(message.places.data(), message.places.size() / message.stride, 4 * message.stride);
  bits.freed = vertexCodecBits(message.freed.data(), message.freed.size(), 4);
  return bits;
}

PlainBits octreeGolombBits(const PlainMessage& message) {
  PlainBits bits;
  bits.numbers = differenceBits(message.numbers, 1);
  bits.triangles = differenceBits(message.triangles, 3);
  bits.places = differenceBits(message.places, message.stride);
  bits.freed = differenceBits(message.freed, 1);
  if (message.vertices.empty()) return bits;
  const int finest = *std::min_element(message.levels.begin(), message.levels.end());
  std::vector<glm::dvec3> at;
  glm::dvec3 low(std::numeric_limits<double>::infinity());
  glm::dvec3 high(-std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < message.vertices.size(); ++i) {
    at.push_back(glm::round(glm::dvec3(message.vertices[i]) * std::ldexp(1.0, message.levels[i] - finest)));
    low = glm::min(low, at.back());
    high = glm::max(high, at.back());
  }
  const glm::dvec3 size = high - low;
  const double side = std::max({size.x, size.y, size.z});
  // Beyond 31 bits an octree's path is as long as floats are: 96 bits a point.
  if (side >= 2147483648.0) {
    bits.vertices = 96.0 * static_cast<double>(at.size());
    return bits;
  }
  std::vector<glm::uvec3> points;
  for (const glm::dvec3& p : at) points.emplace_back(p - low);
  bits.vertices = octreeBits(points, std::bit_width(static_cast<std::uint32_t>(side)));
  return bits;
}

}  // namespace tessera::test
