#include "engine/scene/subdivide.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "engine/scene/weld.hpp"

namespace tessera {
namespace {

using glm::dvec3;

constexpr double kMaxQuadRatio = 4.0;  // between the areas of the two triangles of a quad
constexpr double kRelax = 1.25;        // step in which the limit grows until the cap is kept

// Squared lengths in the world, the largest over a mesh's instances: d . (M^T M) . d.
class Metric {
 public:
  void add(const glm::dmat3& linear) {
    const glm::dmat3 gram = glm::transpose(linear) * linear;
    const auto same = [&](const glm::dmat3& other) {
      double difference = 0.0;
      double size = 0.0;
      for (int c = 0; c < 3; ++c) {
        difference += glm::length(gram[c] - other[c]);
        size += glm::length(gram[c]);
      }
      return difference <= 1e-9 * size;
    };
    if (std::none_of(grams_.begin(), grams_.end(), same)) grams_.push_back(gram);
  }
  // Equal for a and b exchanged, to the bit.
  [[nodiscard]] double squared(const glm::vec3& a, const glm::vec3& b) const {
    const dvec3 d = dvec3(b) - dvec3(a);
    double worst = 0.0;
    for (const glm::dmat3& gram : grams_) worst = std::max(worst, glm::dot(d, gram * d));
    return worst;
  }

 private:
  std::vector<glm::dmat3> grams_;
};

template <class T>
T middle(const T& a, const T& b) {
  T result;
  for (int c = 0; c < T::length(); ++c)
    result[c] = static_cast<float>(0.5 * (static_cast<double>(a[c]) + static_cast<double>(b[c])));
  return result;
}

std::uint64_t edgeKey(std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32 | b; }
std::uint64_t undirected(std::uint32_t a, std::uint32_t b) { return edgeKey(std::min(a, b), std::max(a, b)); }

// Where vertex 3 of the quad 0 1 2 3 lies seen from the triangle 0 1 2: x3 = x0 + s (x1 - x0) + t (x2 - x0).
struct Affine {
  double s = 0.0;
  double t = 0.0;
};

// The attribute follows the same map as the positions, but for rounding: it is affine over the whole quad.
template <class T>
bool follows(const std::vector<T>& array, const std::array<std::uint32_t, 4>& v, const Affine& map) {
  if (array.empty()) return true;
  double extent = 0.0;
  double size = 0.0;
  double error = 0.0;
  for (int c = 0; c < T::length(); ++c) {
    const auto x = [&](std::size_t k) { return static_cast<double>(array[v[k]][c]); };
    for (std::size_t k = 0; k < 4; ++k) {
      extent = std::max(extent, std::abs(x(k) - x(0)));
      size = std::max(size, std::abs(x(k)));
    }
    error = std::max(error, std::abs(x(0) + map.s * (x(1) - x(0)) + map.t * (x(2) - x(0)) - x(3)));
  }
  return error <= 1e-5 * extent + 4.0 * double{std::numeric_limits<float>::epsilon()} * size;
}

// One primitive that has something to split, and what is known of it whatever the limit.
struct Plan {
  std::uint32_t primitive = 0;
  const Metric* metric = nullptr;
  std::vector<std::uint32_t> partner;  // of each triangle: the other half of its quad, or kNone
  std::vector<std::uint8_t> longest;   // of each triangle: number of its longest edge
};

// What becomes of a primitive: triangles, and for each vertex past the primitive's own the two it lies
// between.
struct Split {
  std::vector<std::uint32_t> indices;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> parents;
};

// Vertex numbers are absolute for the primitive's own vertices; the k-th new vertex has the number `fresh +
// k`.
class Splitter {
 public:
  Splitter(const Scene& scene, const Plan& plan, double maxEdge, std::uint64_t maxTriangles)
      : scene_(scene),
        plan_(plan),
        primitive_(scene.primitives[plan.primitive]),
        fresh_(static_cast<std::uint32_t>(scene.vertices.position.size())),
        limit_(maxEdge * maxEdge),
        maxTriangles_(maxTriangles) {}

  // False once there are more than maxTriangles.
  bool run() {
    const std::uint32_t* index = scene_.indices.data() + primitive_.firstIndex;
    for (std::uint32_t t = 0; t < primitive_.indexCount / 3 && !tooMany_; ++t) {
      const std::uint32_t e = plan_.longest[t];
      const auto corner = [&](std::uint32_t triangle, std::uint32_t c) {
        return index[3 * triangle + c % 3];
      };
      const std::uint32_t other = plan_.partner[t];
      if (other == kNone) {
        triangle(corner(t, 0), corner(t, 1), corner(t, 2));
        continue;
      }
      const std::uint32_t a = corner(t, e + 1);
      const std::uint32_t b = corner(t, e + 2);
      const std::uint32_t c = corner(t, e);
      const std::uint32_t d = corner(other, plan_.longest[other] + 2u);
      if (!isLong(a, b) && !isLong(b, c) && !isLong(c, d) && !isLong(d, a)) {
        emit(corner(t, 0), corner(t, 1), corner(t, 2));
      } else if (t < other) {
        quad(a, b, c, d);
      }
    }
    return !tooMany_;
  }
  [[nodiscard]] Split take() { return std::move(split_); }

 private:
  [[nodiscard]] const glm::vec3& position(std::uint32_t v) const {
    return v < fresh_ ? scene_.vertices.position[v] : positions_[v - fresh_];
  }
  [[nodiscard]] double squared(std::uint32_t a, std::uint32_t b) const {
    return plan_.metric->squared(position(a), position(b));
  }
  [[nodiscard]] bool isLong(std::uint32_t a, std::uint32_t b) const {
    if (!(squared(a, b) > limit_)) return false;
    const glm::vec3 m = middle(position(a), position(b));
    return m != position(a) && m != position(b);  // else it is as short as floats can say
  }
  std::uint32_t midpoint(std::uint32_t a, std::uint32_t b) {
    const auto [entry, isNew] =
        midpoints_.try_emplace(undirected(a, b), fresh_ + static_cast<std::uint32_t>(positions_.size()));
    if (isNew) {
      split_.parents.emplace_back(a, b);
      positions_.push_back(middle(position(a), position(b)));
    }
    return entry->second;
  }
  void emit(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    split_.indices.insert(split_.indices.end(), {a, b, c});
    tooMany_ = split_.indices.size() / 3 > maxTriangles_;
  }

  // Triangles (a, b, c) and (a, c, d) of a flat convex quad with affine attributes: halving it along either
  // way changes no surface and no attribute, whichever triangle a point was in.
  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    if (tooMany_) return;
    const bool along = isLong(a, b);
    const bool across = isLong(b, c);
    if (along != isLong(c, d) || across != isLong(d, a)) {  // a trapezoid, or rounding
      triangle(a, b, c);
      triangle(a, c, d);
    } else if (along && (!across || squared(a, b) >= squared(b, c))) {
      const std::uint32_t m = midpoint(a, b);
      const std::uint32_t n = midpoint(c, d);
      quad(a, m, n, d);
      quad(m, b, c, n);
    } else if (across) {
      const std::uint32_t m = midpoint(b, c);
      const std::uint32_t n = midpoint(d, a);
      quad(a, b, m, n);
      quad(n, m, c, d);
    } else {
      emit(a, b, c);
      emit(a, c, d);
    }
  }

  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (tooMany_) return;
    const bool ab = isLong(a, b);
    const bool bc = isLong(b, c);
    const bool ca = isLong(c, a);
    if (ab && bc && ca) {
      const std::uint32_t m = midpoint(a, b);
      const std::uint32_t n = midpoint(b, c);
      const std::uint32_t o = midpoint(c, a);
      triangle(a, m, o);
      triangle(m, b, n);
      triangle(m, n, o);
      triangle(o, n, c);
    } else if (ab && bc) {
      splitTwo(a, b, c);
    } else if (bc && ca) {
      splitTwo(b, c, a);
    } else if (ca && ab) {
      splitTwo(c, a, b);
    } else if (ab) {
      splitOne(a, b, c);
    } else if (bc) {
      splitOne(b, c, a);
    } else if (ca) {
      splitOne(c, a, b);
    } else {
      emit(a, b, c);
    }
  }

  void splitOne(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const std::uint32_t m = midpoint(a, b);
    triangle(a, m, c);
    triangle(m, b, c);
  }

  // a-b and b-c are long: a triangle at their common corner, and a trapezoid that can be cut into strips.
  void splitTwo(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const std::uint32_t m = midpoint(a, b);
    const std::uint32_t n = midpoint(b, c);
    triangle(m, b, n);
    if (squared(m, c) <= squared(a, n)) {
      quad(m, n, c, a);
    } else {
      quad(a, m, n, c);
    }
  }

  const Scene& scene_;
  const Plan& plan_;
  const Primitive& primitive_;
  std::uint32_t fresh_;
  double limit_;
  std::uint64_t maxTriangles_;
  bool tooMany_ = false;
  Split split_;
  std::vector<glm::vec3> positions_;  // of the new vertices
  std::unordered_map<std::uint64_t, std::uint32_t> midpoints_;
};

// Plans for the primitives of one mesh that have an edge longer than `maxEdge`.
class Planner {
 public:
  Planner(const Scene& scene, const Mesh& mesh, const Metric& metric)
      : scene_(scene), mesh_(mesh), metric_(metric) {}

  void run(double maxEdge, std::vector<Plan>& plans) {
    const std::size_t before = plans.size();
    for (std::uint32_t p = mesh_.firstPrimitive; p < mesh_.firstPrimitive + mesh_.primitiveCount; ++p) {
      Plan plan{p, &metric_, {}, {}};
      if (findLongest(plan, maxEdge)) plans.push_back(std::move(plan));
    }
    if (plans.size() == before) return;
    countEdges();
    for (std::size_t i = before; i < plans.size(); ++i) findQuads(plans[i]);
  }

 private:
  [[nodiscard]] const std::uint32_t* triangle(std::uint32_t primitive, std::size_t t) const {
    return scene_.indices.data() + scene_.primitives[primitive].firstIndex + 3 * t;
  }

  bool findLongest(Plan& plan, double maxEdge) const {
    bool any = false;
    plan.longest.resize(scene_.primitives[plan.primitive].indexCount / 3);
    for (std::size_t t = 0; t < plan.longest.size(); ++t) {
      const std::uint32_t* v = triangle(plan.primitive, t);
      double longest = -1.0;
      for (std::uint8_t e = 0; e < 3; ++e) {
        const double length =
            metric_.squared(scene_.vertices.position[v[e]], scene_.vertices.position[v[(e + 1) % 3]]);
        if (length <= longest) continue;
        longest = length;
        plan.longest[t] = e;
      }
      any = any || longest > maxEdge * maxEdge;
    }
    return any;
  }

  // How many triangles of the whole mesh use an edge, by positions.
  void countEdges() {
    std::vector<float> keys;
    start_.clear();
    for (std::uint32_t p = mesh_.firstPrimitive; p < mesh_.firstPrimitive + mesh_.primitiveCount; ++p) {
      const Primitive& primitive = scene_.primitives[p];
      start_.push_back(keys.size() / 3);
      for (std::size_t i = primitive.firstVertex;
           i < std::size_t{primitive.firstVertex} + primitive.vertexCount; ++i) {
        const glm::vec3& x = scene_.vertices.position[i];
        keys.insert(keys.end(), {x.x, x.y, x.z});
      }
    }
    place_ = firstEqual(keys, 3);
    for (std::uint32_t p = mesh_.firstPrimitive; p < mesh_.firstPrimitive + mesh_.primitiveCount; ++p) {
      for (std::size_t t = 0; t < scene_.primitives[p].indexCount / 3; ++t) {
        for (std::uint32_t e = 0; e < 3; ++e)
          edges_.push_back(placeKey(p, triangle(p, t)[e], triangle(p, t)[(e + 1) % 3]));
      }
    }
    std::sort(edges_.begin(), edges_.end());
  }

  [[nodiscard]] std::uint64_t placeKey(std::uint32_t primitive, std::uint32_t a, std::uint32_t b) const {
    const std::size_t base = start_[primitive - mesh_.firstPrimitive];
    const std::uint32_t first = scene_.primitives[primitive].firstVertex;
    return undirected(place_[base + a - first], place_[base + b - first]);
  }

  // Pairs of triangles over a common longest edge that make a flat quad. No third triangle may touch that
  // edge, since it is not split with the others of its length.
  void findQuads(Plan& plan) const {
    plan.partner.assign(plan.longest.size(), kNone);
    std::unordered_map<std::uint64_t, std::uint32_t> byEdge;
    for (std::uint32_t t = 0; t < plan.longest.size(); ++t) {
      const std::uint32_t* v = triangle(plan.primitive, t);
      const std::uint32_t e = plan.longest[t];
      const std::uint32_t from = v[e];
      const std::uint32_t to = v[(e + 1) % 3];
      byEdge.try_emplace(edgeKey(from, to), t);
      const auto found = byEdge.find(edgeKey(to, from));
      if (found == byEdge.end() || from == to) continue;
      const std::uint32_t other = found->second;
      if (other == t || plan.partner[other] != kNone) continue;
      const auto users = std::equal_range(edges_.begin(), edges_.end(), placeKey(plan.primitive, from, to));
      if (users.second - users.first != 2) continue;
      const std::uint32_t across = triangle(plan.primitive, other)[(plan.longest[other] + 2) % 3];
      if (!isFlat({from, across, to, v[(e + 2) % 3]})) continue;
      plan.partner[t] = other;
      plan.partner[other] = t;
    }
  }

  // Convex, flat and with affine attributes.
  [[nodiscard]] bool isFlat(const std::array<std::uint32_t, 4>& v) const {
    const Vertices& x = scene_.vertices;
    const dvec3 origin(x.position[v[0]]);
    const dvec3 a = dvec3(x.position[v[1]]) - origin;
    const dvec3 b = dvec3(x.position[v[2]]) - origin;
    const dvec3 d = dvec3(x.position[v[3]]) - origin;
    const dvec3 n = glm::cross(a, b);
    const double scale = glm::dot(n, n);
    if (!(scale > 0.0)) return false;
    const Affine map{glm::dot(glm::cross(d, b), n) / scale, glm::dot(glm::cross(a, d), n) / scale};
    const double crossing = map.t / (1.0 - map.s);  // of the diagonals, along 0-2
    if (!(map.s < 0.0 && crossing > 0.0 && crossing < 1.0)) return false;
    // A small share here means a triangle that is far larger than the other: its rounding would be blown up.
    if (map.s < -kMaxQuadRatio || map.s > -1.0 / kMaxQuadRatio) return false;
    return follows(x.position, v, map) && follows(x.normal, v, map) && follows(x.tangent, v, map) &&
           follows(x.uv0, v, map) && follows(x.uv1, v, map) && follows(x.color, v, map);
  }

  const Scene& scene_;
  const Mesh& mesh_;
  const Metric& metric_;
  std::vector<std::size_t> start_;    // of each primitive's vertices in place_
  std::vector<std::uint32_t> place_;  // of each vertex: number of its position in the mesh
  std::vector<std::uint64_t> edges_;  // one entry a triangle and edge, sorted
};

template <class T>
void appendVertices(std::vector<T>& to, const std::vector<T>& from, const Primitive& primitive,
                    const Split* split) {
  if (from.empty()) return;
  const std::size_t base = to.size();
  const auto first = from.begin() + primitive.firstVertex;
  to.insert(to.end(), first, first + primitive.vertexCount);
  if (split == nullptr) return;
  const auto place = [&](std::uint32_t v) {
    return v < from.size() ? base + v - primitive.firstVertex
                           : base + primitive.vertexCount + (v - from.size());
  };
  for (const auto& [a, b] : split->parents) {
    T value = middle(to[place(a)], to[place(b)]);
    to.push_back(value);
  }
}

void replaceGeometry(Scene& scene, const std::vector<const Split*>& splits) {
  const Vertices old = std::move(scene.vertices);
  const std::vector<std::uint32_t> oldIndices = std::move(scene.indices);
  scene.vertices = {};
  scene.indices.clear();
  const auto fresh = static_cast<std::uint32_t>(old.position.size());
  for (std::size_t p = 0; p < scene.primitives.size(); ++p) {
    Primitive& primitive = scene.primitives[p];
    const Split* split = splits[p];
    const auto base = static_cast<std::uint32_t>(scene.vertices.position.size());
    const auto firstIndex = static_cast<std::uint32_t>(scene.indices.size());
    appendVertices(scene.vertices.position, old.position, primitive, split);
    appendVertices(scene.vertices.normal, old.normal, primitive, split);
    appendVertices(scene.vertices.tangent, old.tangent, primitive, split);
    appendVertices(scene.vertices.uv0, old.uv0, primitive, split);
    appendVertices(scene.vertices.uv1, old.uv1, primitive, split);
    appendVertices(scene.vertices.color, old.color, primitive, split);
    const auto renumber = [&](std::uint32_t v) {
      return v < fresh ? base + v - primitive.firstVertex : base + primitive.vertexCount + (v - fresh);
    };
    if (split == nullptr) {
      const auto first = oldIndices.begin() + primitive.firstIndex;
      std::transform(first, first + primitive.indexCount, std::back_inserter(scene.indices), renumber);
    } else {
      std::transform(split->indices.begin(), split->indices.end(), std::back_inserter(scene.indices),
                     renumber);
    }
    primitive.firstVertex = base;
    primitive.vertexCount = static_cast<std::uint32_t>(scene.vertices.position.size()) - base;
    primitive.firstIndex = firstIndex;
    primitive.indexCount = static_cast<std::uint32_t>(scene.indices.size()) - firstIndex;
  }
}

// The metric of each mesh; of a mesh without instances it measures every edge as 0.
std::vector<Metric> meshMetrics(const Scene& scene) {
  SceneState state;
  evaluate(scene, 0.0, state);
  std::vector<Metric> metrics(scene.meshes.size());
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].mesh != kNone) metrics[scene.nodes[n].mesh].add(glm::dmat3(state.world[n]));
  }
  return metrics;
}

}  // namespace

SubdivideReport splitLongEdges(Scene& scene, const SubdivideOptions& options) {
  SubdivideReport report;
  for (const Primitive& primitive : scene.primitives) report.trianglesBefore += primitive.indexCount / 3;
  report.trianglesAfter = report.trianglesBefore;
  report.maxEdge = options.maxEdgeShare * scene.bounds.diagonal();
  if (!(report.maxEdge > 0.0)) {
    report.maxEdge = 0.0;
    return report;
  }
  const std::vector<Metric> metrics = meshMetrics(scene);
  std::vector<Plan> plans;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    Planner(scene, scene.meshes[m], metrics[m]).run(report.maxEdge, plans);
  if (plans.empty()) return report;

  std::uint64_t planned = 0;
  for (const Plan& plan : plans) planned += plan.longest.size();
  std::vector<Split> splits;
  for (;; report.maxEdge *= kRelax, report.relaxed = true) {
    splits.clear();
    std::uint64_t left = planned + options.maxAddedTriangles;
    for (const Plan& plan : plans) {
      Splitter splitter(scene, plan, report.maxEdge, left);
      if (!splitter.run()) break;
      splits.push_back(splitter.take());
      left -= splits.back().indices.size() / 3;
    }
    if (splits.size() == plans.size()) break;
  }
  report.trianglesAfter -= planned;
  std::vector<const Split*> byPrimitive(scene.primitives.size(), nullptr);
  for (std::size_t i = 0; i < plans.size(); ++i) {
    byPrimitive[plans[i].primitive] = &splits[i];
    report.trianglesAfter += splits[i].indices.size() / 3;
  }
  replaceGeometry(scene, byPrimitive);
  return report;
}

}  // namespace tessera
