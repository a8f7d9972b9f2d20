#include "engine/scene/tangents.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "engine/scene/weld.hpp"

namespace tessera {
namespace {

using glm::dvec2;
using glm::dvec3;

// Sets of corners that share a tangent.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

dvec3 unitOrZero(const dvec3& v) {
  const double length = glm::length(v);
  return length > 0.0 && std::isfinite(length) ? v / length : dvec3(0.0);
}

dvec3 projected(const dvec3& v, const dvec3& normal) { return unitOrZero(v - normal * glm::dot(normal, v)); }

dvec3 anyPerpendicular(const dvec3& normal) {
  const dvec3 a = glm::abs(normal);
  const dvec3 axis = a.x <= a.y && a.x <= a.z ? dvec3(1, 0, 0) : a.y <= a.z ? dvec3(0, 1, 0) : dvec3(0, 0, 1);
  const dvec3 t = projected(axis, normal);
  return t == dvec3(0.0) ? dvec3(1, 0, 0) : t;
}

class Generator {
 public:
  Generator(Scene& scene, std::uint32_t primitive, int uvSet)
      : vertices_(scene.vertices),
        primitive_(scene.primitives[primitive]),
        uv_(uvSet == 0 ? scene.vertices.uv0 : scene.vertices.uv1),
        indices_(scene.indices.data() + primitive_.firstIndex, primitive_.indexCount),
        groups_(primitive_.indexCount) {}

  void run() {
    weld();
    deriveFaces();
    joinAcrossEdges();
    sumGroups();
    assign();
  }

 private:
  struct Face {
    dvec3 tangent{0.0};     // unit, along growing u
    bool positive = false;  // sign of the UV area
    bool usable = false;
  };

  [[nodiscard]] dvec3 position(std::uint32_t corner) const {
    return dvec3(vertices_.position[indices_[corner]]);
  }
  [[nodiscard]] dvec3 normal(std::uint32_t corner) const {
    return unitOrZero(dvec3(vertices_.normal[indices_[corner]]));
  }
  [[nodiscard]] dvec2 uv(std::uint32_t corner) const {
    return uv_.empty() ? dvec2(0.0) : dvec2(uv_[indices_[corner]]);
  }

  void weld() {
    std::vector<float> keys;
    keys.reserve(std::size_t{8} * primitive_.vertexCount);
    for (std::size_t i = primitive_.firstVertex;
         i < std::size_t{primitive_.firstVertex} + primitive_.vertexCount; ++i) {
      const glm::vec3& p = vertices_.position[i];
      const glm::vec3& n = vertices_.normal[i];
      const glm::vec2 t = uv_.empty() ? glm::vec2(0.0f) : uv_[i];
      keys.insert(keys.end(), {p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y});
    }
    const std::vector<std::uint32_t> first = firstEqual(keys, 8);
    welded_.resize(indices_.size());
    std::transform(indices_.begin(), indices_.end(), welded_.begin(),
                   [&](std::uint32_t index) { return first[index - primitive_.firstVertex]; });
  }

  void deriveFaces() {
    faces_.resize(indices_.size() / 3);
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      const dvec3 e1 = position(3 * f + 1) - position(3 * f);
      const dvec3 e2 = position(3 * f + 2) - position(3 * f);
      const dvec2 t1 = uv(3 * f + 1) - uv(3 * f);
      const dvec2 t2 = uv(3 * f + 2) - uv(3 * f);
      const double uvArea = t1.x * t2.y - t1.y * t2.x;
      Face& face = faces_[f];
      face.positive = uvArea > 0.0;
      face.tangent = unitOrZero((e1 * t2.y - e2 * t1.y) * (face.positive ? 1.0 : -1.0));
      face.usable = std::abs(uvArea) > double{std::numeric_limits<float>::min()} &&
                    glm::cross(e1, e2) != dvec3(0.0) && face.tangent != dvec3(0.0);
    }
  }

  void joinAcrossEdges() {
    struct Edge {
      std::uint32_t low;
      std::uint32_t high;
      bool positive;
      std::uint32_t lowCorner;
      std::uint32_t highCorner;
    };
    std::vector<Edge> edges;
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      if (!faces_[f].usable) continue;
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t a = 3 * f + e;
        const std::uint32_t b = 3 * f + (e + 1) % 3;
        const bool up = welded_[a] < welded_[b];
        edges.push_back({std::min(welded_[a], welded_[b]), std::max(welded_[a], welded_[b]),
                         faces_[f].positive, up ? a : b, up ? b : a});
      }
    }
    const auto key = [](const Edge& e) { return std::tie(e.low, e.high, e.positive); };
    std::sort(edges.begin(), edges.end(), [&](const Edge& x, const Edge& y) { return key(x) < key(y); });
    for (std::size_t i = 1; i < edges.size(); ++i) {
      if (key(edges[i]) != key(edges[i - 1])) continue;
      groups_.join(edges[i].lowCorner, edges[i - 1].lowCorner);
      groups_.join(edges[i].highCorner, edges[i - 1].highCorner);
    }
  }

  void sumGroups() {
    sums_.assign(indices_.size(), dvec3(0.0));
    for (std::uint32_t c = 0; c < indices_.size(); ++c) {
      const Face& face = faces_[c / 3];
      if (!face.usable) continue;
      const dvec3 n = normal(c);
      const std::uint32_t base = c - c % 3;
      const dvec3 a = projected(position(base + (c + 1) % 3) - position(c), n);
      const dvec3 b = projected(position(base + (c + 2) % 3) - position(c), n);
      const double angle = std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
      sums_[groups_.find(c)] += angle * projected(face.tangent, n);
    }
  }

  [[nodiscard]] glm::vec4 tangentOf(std::uint32_t corner) {
    const std::uint32_t root = groups_.find(corner);
    // Summing leaves the plane of the normal by rounding only, but two projections cost nothing.
    dvec3 t = projected(sums_[root], normal(corner));
    if (t == dvec3(0.0)) t = anyPerpendicular(normal(corner));
    // In the file v runs down the picture: positive UV area turns the other way on the surface.
    return {glm::vec3(t), faces_[corner / 3].positive ? -1.0f : 1.0f};
  }

  void assign() {
    vertices_.tangent.resize(vertices_.position.size(), glm::vec4(1, 0, 0, 1));
    const std::uint32_t end = primitive_.firstVertex + primitive_.vertexCount;
    std::vector<bool> taken(primitive_.vertexCount, false);
    std::vector<std::uint32_t> nextCopy(primitive_.vertexCount,
                                        kNone);                        // a list of the copies of each vertex
    std::vector<std::uint32_t> source(primitive_.vertexCount, kNone);  // any usable corner of a welded vertex
    for (std::uint32_t c = 0; c < indices_.size(); ++c) {
      if (!faces_[c / 3].usable) continue;
      if (source[welded_[c]] == kNone) source[welded_[c]] = c;
    }
    const std::vector<std::uint32_t> original(indices_.begin(), indices_.end());
    std::vector<glm::vec4> tangents(indices_.size());
    for (std::uint32_t c = 0; c < indices_.size(); ++c)
      if (faces_[c / 3].usable) tangents[c] = tangentOf(c);
    for (std::uint32_t c = 0; c < indices_.size(); ++c) {
      if (!faces_[c / 3].usable) continue;
      const glm::vec4& tangent = tangents[c];
      std::uint32_t vertex = original[c];
      if (!taken[vertex - primitive_.firstVertex]) {
        taken[vertex - primitive_.firstVertex] = true;
        vertices_.tangent[vertex] = tangent;
        continue;
      }
      while (vertices_.tangent[vertex] != tangent) {
        const std::uint32_t next = nextCopy[vertex - primitive_.firstVertex];
        if (next == kNone) break;
        vertex = next;
      }
      if (vertices_.tangent[vertex] != tangent) {
        const auto copy = static_cast<std::uint32_t>(vertices_.position.size());
        nextCopy[vertex - primitive_.firstVertex] = copy;
        nextCopy.push_back(kNone);
        duplicate(original[c]);
        vertices_.tangent.push_back(tangent);
        vertex = copy;
      }
      indices_[c] = vertex;
    }
    for (std::uint32_t c = 0; c < indices_.size(); ++c) {
      const std::uint32_t vertex = original[c];
      if (vertex >= end || taken[vertex - primitive_.firstVertex]) continue;
      const std::uint32_t like = source[welded_[c]];
      vertices_.tangent[vertex] =
          like != kNone ? tangents[like] : glm::vec4(glm::vec3(anyPerpendicular(normal(c))), 1.0f);
      taken[vertex - primitive_.firstVertex] = true;
    }
    for (std::uint32_t v = primitive_.firstVertex; v < end; ++v) {
      if (taken[v - primitive_.firstVertex]) continue;  // left: what no triangle uses
      vertices_.tangent[v] =
          glm::vec4(glm::vec3(anyPerpendicular(unitOrZero(dvec3(vertices_.normal[v])))), 1.0f);
    }
    primitive_.vertexCount = static_cast<std::uint32_t>(vertices_.position.size()) - primitive_.firstVertex;
  }

  void duplicate(std::uint32_t vertex) {
    const auto append = [vertex](auto& array) {
      if (array.empty()) return;
      const auto value = array[vertex];
      array.push_back(value);
    };
    append(vertices_.position);
    append(vertices_.normal);
    append(vertices_.uv0);
    append(vertices_.uv1);
    append(vertices_.color);
  }

  Vertices& vertices_;
  Primitive& primitive_;
  const std::vector<glm::vec2>& uv_;
  std::span<std::uint32_t> indices_;
  Groups groups_;  // of corners, by number in indices_
  std::vector<std::uint32_t> welded_;
  std::vector<Face> faces_;
  std::vector<dvec3> sums_;  // of a group, at its root corner
};

}  // namespace

void generateTangents(Scene& scene, std::uint32_t primitive, int uvSet) {
  assert(uvSet == 0 || uvSet == 1);
  const Primitive& p = scene.primitives[primitive];
  assert(std::size_t{p.firstVertex} + p.vertexCount == scene.vertices.position.size());
  static_cast<void>(p);
  Generator(scene, primitive, uvSet).run();
}

}  // namespace tessera
