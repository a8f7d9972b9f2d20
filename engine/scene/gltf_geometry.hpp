// Triangles of one primitive on their way from the file's layout to the engine's: pure functions of arrays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "engine/scene/scene.hpp"

namespace tessera {

/// Vertices and triangles of one primitive. Attributes are as long as `vertices.position` or empty; indices
/// are below that length, three a triangle.
struct Geometry {
  Vertices vertices;
  std::vector<std::uint32_t> indices;
};

enum class Topology : std::uint8_t { Triangles, Strip, Fan };

/// The triangle list of a strip or fan (glTF 2.0 sec. 3.7.2.1), winding kept; of a list, its whole triangles.
std::vector<std::uint32_t> triangleList(Topology topology, const std::vector<std::uint32_t>& indices);

/// Removes triangles that name a vertex twice; returns how many there were.
std::size_t dropRepeatedIndices(std::vector<std::uint32_t>& indices);

/// Gives each triangle three vertices of its own with the face's normal.
void makeFlat(Geometry& geometry);

/// Makes normals unit length. One that is zero or not finite becomes the mean of its faces' normals, weighted
/// by area
/// (+z if all of them have none). Returns how many were replaced.
std::size_t repairNormals(Geometry& geometry);

/// Merges vertices whose attributes are all equal (firstEqual), in the order of their first use, and drops
/// unused ones. A triangle that would lose a corner by that keeps vertices of its own, so that no index is
/// repeated.
void weld(Geometry& geometry);

/// Numbers the vertices that `indices` use from 0 in the order of their first use, in place; returns the old
/// numbers. Its scratch memory is kept between calls, so that many small primitives in one large array cost
/// no more than their own size.
class VertexCompactor {
 public:
  std::vector<std::uint32_t> compact(std::vector<std::uint32_t>& indices);

 private:
  struct Slot {
    std::uint32_t call = 0;
    std::uint32_t number = 0;
  };
  std::vector<Slot> slots_;
  std::uint32_t call_ = 0;
};

}  // namespace tessera
