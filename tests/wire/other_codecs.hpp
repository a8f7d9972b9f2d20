// The same content by other means, to compare with: a general-purpose codec for meshes, and the one of
// Mueller 2021.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace tessera::test {

/// What one message has to say, as plain arrays.
struct PlainMessage {
  std::vector<glm::ivec3> vertices;      // steps, in the order of first use
  std::vector<std::int32_t> levels;      // of each
  std::vector<std::uint32_t> numbers;    // of each vertex
  std::vector<std::uint32_t> triangles;  // three vertex numbers each
  std::vector<std::uint32_t> places;     // `stride` words each, the first of them the element
  std::size_t stride = 3;
  std::vector<std::uint32_t> freed;  // rising
};
struct PlainBits {
  double vertices = 0.0, numbers = 0.0, triangles = 0.0, places = 0.0, freed = 0.0;
};

/// meshoptimizer's codecs for vertices and indices, zstd behind both. Numbers of vertices are not sent: new
/// ones follow each other. Which corner of a triangle comes first is lost, and would cost more.
PlainBits meshoptimizerBits(const PlainMessage& message);

/// Mueller 2021, sec. 7.3.5: an octree over positions on one grid, the finest that any needs (Botsch et al.
/// 2002); what is under a node of one point as it is. Everything else as differences within each attribute,
/// in exponential Golomb codes of the order that suits the attribute best.
PlainBits octreeGolombBits(const PlainMessage& message);

}  // namespace tessera::test
