#include "engine/scene/gltf_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "engine/scene/weld.hpp"

namespace tessera {
namespace {

/// Calls `one` with each attribute array that is in use.
template <class V, class One>
void forEachAttribute(V& vertices, const One& one) {
  one(vertices.position);
  if (!vertices.normal.empty()) one(vertices.normal);
  if (!vertices.tangent.empty()) one(vertices.tangent);
  if (!vertices.uv0.empty()) one(vertices.uv0);
  if (!vertices.uv1.empty()) one(vertices.uv1);
  if (!vertices.color.empty()) one(vertices.color);
}

/// Reorders every attribute: new vertex i is old vertex order[i].
void reorder(Vertices& vertices, const std::vector<std::uint32_t>& order) {
  forEachAttribute(vertices, [&](auto& attribute) {
    std::remove_reference_t<decltype(attribute)> moved;
    moved.reserve(order.size());
    for (const std::uint32_t v : order) moved.push_back(attribute[v]);
    attribute = std::move(moved);
  });
}

/// Twice the area times the unit normal. In double, so that small triangles far away keep a direction.
glm::dvec3 areaNormal(const Geometry& geometry, std::size_t triangle) {
  const auto corner = [&](std::size_t k) {
    return glm::dvec3(geometry.vertices.position[geometry.indices[triangle * 3 + k]]);
  };
  return glm::cross(corner(1) - corner(0), corner(2) - corner(0));
}

glm::vec3 unitOr(const glm::dvec3& v, const glm::vec3& other) {
  const double length = glm::length(v);
  return length > 0.0 && std::isfinite(length) ? glm::vec3(v / length) : other;
}

constexpr glm::vec3 kUp{0.0f, 0.0f, 1.0f};

/// A normal shorter than this has no direction worth keeping.
constexpr double kMinNormal = 1e-6;

bool usable(const glm::vec3& normal) {
  const double length = glm::length(glm::dvec3(normal));
  return std::isfinite(length) && length > kMinNormal;
}

/// All attributes of all vertices, `width` floats a vertex.
std::vector<float> vertexKeys(const Vertices& vertices, std::size_t& width) {
  width = 0;
  forEachAttribute(vertices, [&](const auto& attribute) { width += sizeof(attribute[0]) / sizeof(float); });
  std::vector<float> keys(vertices.position.size() * width);
  std::size_t column = 0;
  forEachAttribute(vertices, [&](const auto& attribute) {
    for (std::size_t v = 0; v < attribute.size(); ++v)
      std::memcpy(&keys[v * width + column], &attribute[v], sizeof attribute[v]);
    column += sizeof(attribute[0]) / sizeof(float);
  });
  return keys;
}

}  // namespace

std::vector<std::uint32_t> triangleList(Topology topology, const std::vector<std::uint32_t>& indices) {
  std::vector<std::uint32_t> out;
  if (topology == Topology::Triangles) {
    out = indices;
    out.resize(indices.size() / 3 * 3);
    return out;
  }
  if (indices.size() < 3) return out;
  out.reserve((indices.size() - 2) * 3);
  for (std::size_t i = 0; i + 2 < indices.size(); ++i) {
    if (topology == Topology::Strip)
      out.insert(out.end(), {indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]});
    else
      out.insert(out.end(), {indices[i + 1], indices[i + 2], indices[0]});
  }
  return out;
}

std::size_t dropRepeatedIndices(std::vector<std::uint32_t>& indices) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    const std::uint32_t a = indices[i];
    const std::uint32_t b = indices[i + 1];
    const std::uint32_t c = indices[i + 2];
    if (a == b || b == c || c == a) continue;
    indices[kept++] = a;
    indices[kept++] = b;
    indices[kept++] = c;
  }
  const std::size_t dropped = (indices.size() - kept) / 3;
  indices.resize(kept);
  return dropped;
}

void makeFlat(Geometry& geometry) {
  geometry.vertices.normal.clear();
  reorder(geometry.vertices, geometry.indices);
  for (std::size_t i = 0; i < geometry.indices.size(); ++i)
    geometry.indices[i] = static_cast<std::uint32_t>(i);
  geometry.vertices.normal.reserve(geometry.indices.size());
  for (std::size_t triangle = 0; triangle < geometry.indices.size() / 3; ++triangle)
    geometry.vertices.normal.insert(geometry.vertices.normal.end(), 3,
                                    unitOr(areaNormal(geometry, triangle), kUp));
}

std::size_t repairNormals(Geometry& geometry) {
  std::vector<glm::vec3>& normals = geometry.vertices.normal;
  const auto bad =
      static_cast<std::size_t>(std::ranges::count_if(normals, [](const auto& n) { return !usable(n); }));
  if (bad > 0) {
    std::vector<glm::dvec3> sums(normals.size(), glm::dvec3(0.0));
    std::vector<glm::dvec3> any(normals.size(), glm::dvec3(0.0));
    for (std::size_t triangle = 0; triangle < geometry.indices.size() / 3; ++triangle) {
      const glm::dvec3 normal = areaNormal(geometry, triangle);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = geometry.indices[triangle * 3 + k];
        sums[v] += normal;
        any[v] = glm::length(any[v]) > 0.0 ? any[v] : normal;
      }
    }
    // Faces back to back cancel; then one of them decides.
    for (std::size_t v = 0; v < normals.size(); ++v)
      if (!usable(normals[v])) normals[v] = unitOr(sums[v], unitOr(any[v], kUp));
  }
  for (glm::vec3& normal : normals) normal = unitOr(glm::dvec3(normal), kUp);
  return bad;
}

void weld(Geometry& geometry) {
  std::size_t width = 0;
  const std::vector<float> keys = vertexKeys(geometry.vertices, width);
  const std::vector<std::uint32_t> first = firstEqual(keys, width);
  std::vector<std::uint32_t> number(first.size(), kNone);
  std::vector<std::uint32_t> order;
  const auto append = [&](std::uint32_t v) {
    order.push_back(v);
    return static_cast<std::uint32_t>(order.size() - 1);
  };
  for (std::size_t i = 0; i + 2 < geometry.indices.size(); i += 3) {
    std::uint32_t* corner = &geometry.indices[i];
    const std::uint32_t a = first[corner[0]];
    const std::uint32_t b = first[corner[1]];
    const std::uint32_t c = first[corner[2]];
    const bool collapses = a == b || b == c || c == a;
    for (int k = 0; k < 3; ++k) {
      if (collapses) {
        corner[k] = append(corner[k]);
        continue;
      }
      std::uint32_t& n = number[first[corner[k]]];
      if (n == kNone) n = append(first[corner[k]]);
      corner[k] = n;
    }
  }
  reorder(geometry.vertices, order);
}

std::vector<std::uint32_t> VertexCompactor::compact(std::vector<std::uint32_t>& indices) {
  std::vector<std::uint32_t> used;
  if (indices.empty()) return used;
  const std::size_t needed = std::size_t{*std::ranges::max_element(indices)} + 1;
  if (slots_.size() < needed) slots_.resize(needed);
  ++call_;
  for (std::uint32_t& index : indices) {
    Slot& slot = slots_[index];
    if (slot.call != call_) {
      slot = {call_, static_cast<std::uint32_t>(used.size())};
      used.push_back(index);
    }
    index = slot.number;
  }
  return used;
}

}  // namespace tessera
