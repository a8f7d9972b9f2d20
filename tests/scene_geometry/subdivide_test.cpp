// Splitting of long edges: nothing may open, move or change, only get smaller.
#include "engine/scene/subdivide.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

namespace tessera {
namespace {

// A scene of one mesh and one node; each beginPrimitive starts a primitive.
struct Builder {
  Scene scene;

  explicit Builder(const glm::dmat4& world = glm::dmat4(1.0)) {
    scene.meshes.push_back({});
    Node node;
    node.mesh = 0;
    node.hasMatrix = true;
    node.matrix = world;
    scene.nodes.push_back(node);
  }
  void beginPrimitive() {
    Primitive p;
    p.firstVertex = static_cast<std::uint32_t>(scene.vertices.position.size());
    p.firstIndex = static_cast<std::uint32_t>(scene.indices.size());
    scene.instances.push_back({0, static_cast<std::uint32_t>(scene.primitives.size())});
    scene.primitives.push_back(p);
    scene.meshes[0].primitiveCount++;
  }
  // The other attributes are affine in the position, so that wherever a vertex is put they are known.
  std::uint32_t vertex(const glm::vec3& p) {
    scene.vertices.position.push_back(p);
    scene.vertices.normal.emplace_back(p);
    scene.vertices.uv0.emplace_back(0.5f * p.x + p.z, p.y - 0.25f * p.z);
    scene.primitives.back().vertexCount++;
    scene.bounds.add(glm::dvec3(scene.nodes[0].matrix * glm::dvec4(p, 1.0)));
    return static_cast<std::uint32_t>(scene.vertices.position.size() - 1);
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    scene.indices.insert(scene.indices.end(), {a, b, c});
    scene.primitives.back().indexCount += 3;
  }
  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }
};

using Place = std::tuple<float, float, float>;
Place placeOf(const Scene& scene, std::uint32_t v) {
  const glm::vec3& p = scene.vertices.position[v];
  return {p.x, p.y, p.z};
}

std::uint64_t triangleCount(const Scene& scene) { return scene.indices.size() / 3; }

double worldArea(const Scene& scene) {
  double sum = 0.0;
  for (std::size_t t = 0; t < scene.indices.size(); t += 3) {
    std::array<glm::dvec3, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
      p[k] =
          glm::dvec3(scene.nodes[0].matrix * glm::dvec4(scene.vertices.position[scene.indices[t + k]], 1.0));
    sum += 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
  }
  return sum;
}

// How often each directed edge is used more than its reverse, by position. Empty for a closed mesh.
std::map<std::pair<Place, Place>, int> openEdges(const Scene& scene) {
  std::map<std::pair<Place, Place>, int> open;
  for (std::size_t i = 0; i < scene.indices.size(); ++i) {
    const Place a = placeOf(scene, scene.indices[i]);
    const Place b = placeOf(scene, scene.indices[i - i % 3 + (i + 1) % 3]);
    if (a < b) open[{a, b}]++;
    if (b < a) open[{b, a}]--;
  }
  std::erase_if(open, [](const auto& entry) { return entry.second == 0; });
  return open;
}

// Vertices inside an edge of a triangle that does not use them: T-junctions, by trying all.
std::size_t junctions(const Scene& scene) {
  std::set<Place> places;
  for (const std::uint32_t v : scene.indices) places.insert(placeOf(scene, v));
  std::size_t found = 0;
  for (std::size_t i = 0; i < scene.indices.size(); ++i) {
    const glm::dvec3 a(scene.vertices.position[scene.indices[i]]);
    const glm::dvec3 b(scene.vertices.position[scene.indices[i - i % 3 + (i + 1) % 3]]);
    const double length = glm::length(b - a);
    for (const auto& [x, y, z] : places) {
      const glm::dvec3 p(x, y, z);
      const double along = glm::dot(p - a, b - a) / (length * length);
      if (along > 1e-4 && along < 1.0 - 1e-4 && glm::length(p - a - along * (b - a)) < 1e-6 * length) ++found;
    }
  }
  return found;
}

void checkSound(const Scene& before, const Scene& after, const SubdivideReport& report) {
  ASSERT_EQ(report.trianglesBefore, triangleCount(before));
  ASSERT_EQ(report.trianglesAfter, triangleCount(after));
  ASSERT_EQ(after.primitives.size(), before.primitives.size());
  std::uint32_t vertex = 0;
  std::uint32_t index = 0;
  for (const Primitive& p : after.primitives) {
    ASSERT_EQ(p.firstVertex, vertex);
    ASSERT_EQ(p.firstIndex, index);
    ASSERT_EQ(p.indexCount % 3, 0u);
    for (std::uint32_t i = 0; i < p.indexCount; ++i) {
      ASSERT_GE(after.indices[p.firstIndex + i], p.firstVertex);
      ASSERT_LT(after.indices[p.firstIndex + i], p.firstVertex + p.vertexCount);
    }
    vertex += p.vertexCount;
    index += p.indexCount;
  }
  ASSERT_EQ(vertex, after.vertices.position.size());
  ASSERT_EQ(index, after.indices.size());
  ASSERT_EQ(after.vertices.normal.size(), after.vertices.position.size());
  ASSERT_EQ(after.vertices.uv0.size(), after.vertices.position.size());
  for (std::size_t v = 0; v < after.vertices.position.size(); ++v) {
    const glm::vec3 p = after.vertices.position[v];
    const float size = 1e-5f * (1.0f + glm::length(p));
    ASSERT_EQ(after.vertices.normal[v], p);
    ASSERT_NEAR(after.vertices.uv0[v].x, 0.5f * p.x + p.z, size);
    ASSERT_NEAR(after.vertices.uv0[v].y, p.y - 0.25f * p.z, size);
  }
  ASSERT_NEAR(worldArea(after), worldArea(before), 1e-5 * worldArea(before));
}

// No edge longer than the limit but diagonals of quads, of which a triangle has one at most and
// shares it.
void checkLengths(const Scene& scene, double maxEdge) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> diagonals;
  for (std::size_t t = 0; t < scene.indices.size(); t += 3) {
    int over = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = scene.indices[t + k];
      const std::uint32_t b = scene.indices[t + (k + 1) % 3];
      const glm::dvec3 d = glm::dmat3(scene.nodes[0].matrix) *
                           (glm::dvec3(scene.vertices.position[b]) - glm::dvec3(scene.vertices.position[a]));
      if (glm::length(d) <= maxEdge * (1.0 + 1e-12)) continue;
      ASSERT_LE(glm::length(d), 2.0 * maxEdge);
      ++over;
      diagonals[{std::min(a, b), std::max(a, b)}]++;
    }
    ASSERT_LE(over, 1);
  }
  for (const auto& [edge, count] : diagonals) ASSERT_EQ(count, 2);
}

SubdivideOptions limit(const Scene& scene, double maxEdge) {
  SubdivideOptions options;
  options.maxEdgeShare = maxEdge / scene.bounds.diagonal();
  return options;
}

// A box, each side with its own vertices (a seam along every edge), as six primitives if `apart`.
Builder box(const glm::vec3& size, bool apart, const glm::dmat4& world = glm::dmat4(1.0)) {
  Builder b(world);
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      if (apart || b.scene.primitives.empty()) b.beginPrimitive();
      std::array<std::uint32_t, 4> v{};
      for (int k = 0; k < 4; ++k) {
        glm::vec3 p(0.0f);
        p[axis] = side == 0 ? 0.0f : size[axis];
        p[(axis + 1) % 3] = k == 1 || k == 2 ? size[(axis + 1) % 3] : 0.0f;
        p[(axis + 2) % 3] = k >= 2 ? size[(axis + 2) % 3] : 0.0f;
        v[static_cast<std::size_t>(k)] = b.vertex(p);
      }
      if (side == 0) std::swap(v[1], v[3]);
      b.quad(v[0], v[1], v[2], v[3]);
    }
  }
  return b;
}

TEST(Subdivide, RectangleBecomesAGrid) {
  Builder b;
  b.beginPrimitive();
  b.quad(b.vertex({0, 0, 0}), b.vertex({8, 0, 0}), b.vertex({8, 3, 0}), b.vertex({0, 3, 0}));
  Scene scene = b.scene;
  const SubdivideReport report = splitLongEdges(scene, limit(scene, 1.01));
  checkSound(b.scene, scene, report);
  checkLengths(scene, report.maxEdge);
  EXPECT_FALSE(report.relaxed);
  EXPECT_EQ(triangleCount(scene), 2u * 8u * 4u);
  EXPECT_EQ(scene.vertices.position.size(), 9u * 5u);
  std::set<std::pair<float, float>> steps;  // edges, as steps to the right
  for (std::size_t i = 0; i < scene.indices.size(); ++i) {
    glm::vec3 d = scene.vertices.position[scene.indices[i - i % 3 + (i + 1) % 3]] -
                  scene.vertices.position[scene.indices[i]];
    if (d.x < 0 || (d.x == 0 && d.y < 0)) d = -d;
    steps.emplace(d.x, d.y);
  }
  EXPECT_EQ(steps, (std::set<std::pair<float, float>>{{1.0f, 0.0f}, {0.0f, 0.75f}, {1.0f, 0.75f}}));
}

TEST(Subdivide, BoxesStayClosedAcrossSeamsAndPrimitives) {
  glm::dmat4 world(1.0);
  world[0] = {0.3, 1.2, -0.4, 0.0};
  world[1] = {-2.0, 0.4, 0.1, 0.0};
  world[2] = {0.2, 0.3, 5.0, 0.0};
  for (const bool apart : {false, true}) {
    for (const double maxEdge : {0.37, 0.6, 1.0, 2.3, 7.7}) {
      for (const glm::dmat4& matrix : {glm::dmat4(1.0), world}) {
        const Builder b = box({3.1f, 0.7f, 5.3f}, apart, matrix);
        Scene scene = b.scene;
        const SubdivideReport report = splitLongEdges(scene, limit(scene, maxEdge));
        checkSound(b.scene, scene, report);
        checkLengths(scene, report.maxEdge);
        ASSERT_NEAR(report.maxEdge, maxEdge, 1e-12);
        ASSERT_TRUE(openEdges(scene).empty()) << maxEdge;
        Scene again = scene;
        splitLongEdges(again, limit(scene, maxEdge));
        ASSERT_EQ(again.indices, scene.indices);
      }
    }
  }
}

// Sides that are equal but for rounding, and a limit between them: one is split and the other is not.
TEST(Subdivide, RoundingDividesParallelSides) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int round = 0; round < 100; ++round) {
    const Builder straight = box({4.0f, 2.0f, 3.0f}, true);
    const glm::dmat3 turn(
        glm::mat3_cast(glm::normalize(glm::dquat(any(random), any(random), any(random), any(random)))));
    Builder b;
    std::uint32_t index = 0;
    for (std::size_t p = 0; p < straight.scene.primitives.size(); ++p) {
      b.beginPrimitive();
      for (int k = 0; k < 4; ++k)
        b.vertex(glm::vec3(turn * glm::dvec3(straight.scene.vertices.position[4 * p + k])));
      for (int k = 0; k < 2; ++k, index += 3)
        b.triangle(straight.scene.indices[index], straight.scene.indices[index + 1],
                   straight.scene.indices[index + 2]);
    }
    for (const double maxEdge : {0.25, 1.0, 2.0}) {
      Scene scene = b.scene;
      const SubdivideReport report = splitLongEdges(scene, limit(scene, maxEdge));
      checkSound(b.scene, scene, report);
      ASSERT_TRUE(openEdges(scene).empty());
      checkLengths(scene, report.maxEdge);
    }
  }
}

// A long needle is cut into strips: about two triangles a step of the limit.
TEST(Subdivide, NeedlesBecomeStrips) {
  Builder b;
  b.beginPrimitive();
  b.triangle(b.vertex({0, 0, 0}), b.vertex({100, 0, 0}), b.vertex({100, 0.5f, 0}));
  Scene scene = b.scene;
  const SubdivideReport report = splitLongEdges(scene, limit(scene, 1.6));
  checkSound(b.scene, scene, report);
  checkLengths(scene, report.maxEdge);
  EXPECT_EQ(junctions(scene), 0u);
  EXPECT_EQ(triangleCount(scene), 127u);  // 64 columns, the first of one triangle
}

// A closed surface of odd triangles, without any shared vertices, dealt to two primitives.
TEST(Subdivide, RoughBallStaysClosed) {
  std::mt19937 random(4);
  for (int round = 0; round < 20; ++round) {
    Builder b;
    std::vector<std::array<glm::vec3, 3>> faces;
    const std::uint32_t columns = 3 + random() % 8;
    const std::uint32_t rows = 2 + random() % 6;
    std::vector<glm::vec3> grid;
    for (std::uint32_t y = 0; y <= rows; ++y) {
      for (std::uint32_t x = 0; x < columns; ++x) {
        const double a = 2 * std::numbers::pi * x / columns;
        const double e = std::numbers::pi * y / rows;
        const double r = 5.0 + static_cast<double>(random() % 1000) / 300.0;
        const bool pole = y == 0 || y == rows;
        grid.push_back(pole ? glm::vec3(0, 0, y == 0 ? 9 : -9)
                            : glm::vec3(r * sin(e) * cos(a), r * sin(e) * sin(a), r * cos(e)));
      }
    }
    for (std::uint32_t y = 0; y < rows; ++y) {
      for (std::uint32_t x = 0; x < columns; ++x) {
        const auto at = [&](std::uint32_t i, std::uint32_t j) { return grid[j * columns + i % columns]; };
        if (y > 0) faces.push_back({at(x, y), at(x, y + 1), at(x + 1, y)});
        if (y + 1 < rows) faces.push_back({at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)});
      }
    }
    for (std::size_t part = 0; part < 2; ++part) {
      b.beginPrimitive();
      for (std::size_t f = part; f < faces.size(); f += 2)
        b.triangle(b.vertex(faces[f][0]), b.vertex(faces[f][1]), b.vertex(faces[f][2]));
    }
    ASSERT_TRUE(openEdges(b.scene).empty());
    Scene scene = b.scene;
    const SubdivideReport report = splitLongEdges(scene, limit(scene, 1.0 + round % 5));
    checkSound(b.scene, scene, report);
    checkLengths(scene, report.maxEdge);
    ASSERT_GT(triangleCount(scene), triangleCount(b.scene));
    ASSERT_TRUE(openEdges(scene).empty());
    Scene again = scene;
    splitLongEdges(again, limit(scene, 1.0 + round % 5));
    ASSERT_EQ(again.indices, scene.indices);
  }
}

TEST(Subdivide, ThirdTriangleOnADiagonal) {
  Builder b;
  b.beginPrimitive();
  const std::array v{b.vertex({0, 0, 0}), b.vertex({4, 0, 0}), b.vertex({4, 4, 0}), b.vertex({0, 4, 0})};
  b.quad(v[0], v[1], v[2], v[3]);
  b.beginPrimitive();
  b.triangle(b.vertex({0, 0, 0}), b.vertex({4, 4, 0}), b.vertex({2, 2, 3}));
  Scene scene = b.scene;
  const SubdivideReport report = splitLongEdges(scene, limit(scene, 1.1));
  checkSound(b.scene, scene, report);
  EXPECT_EQ(junctions(scene), 0u);
}

// Attributes that do not match over the two halves forbid the grid: each half keeps its own.
TEST(Subdivide, BentAttributesAreKept) {
  Builder b;
  b.beginPrimitive();
  const std::array v{b.vertex({0, 0, 0}), b.vertex({4, 0, 0}), b.vertex({4, 4, 0}), b.vertex({0, 4, 0})};
  b.quad(v[0], v[1], v[2], v[3]);
  b.scene.vertices.color = {{0, 0, 0, 1}, {0, 0, 0, 1}, {0, 0, 0, 1}, {1, 0, 0, 1}};
  Scene scene = b.scene;
  checkSound(b.scene, scene, splitLongEdges(scene, limit(scene, 1.0)));
  ASSERT_EQ(scene.vertices.color.size(), scene.vertices.position.size());
  for (std::size_t i = 0; i < scene.vertices.position.size(); ++i) {
    const glm::vec3 p = scene.vertices.position[i];
    EXPECT_EQ(scene.vertices.color[i].r, std::max(0.0f, (p.y - p.x) / 4.0f)) << p.x << " " << p.y;
  }
}

TEST(Subdivide, SoupsHaveNoJunctions) {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> any(-5, 5);
  for (int round = 0; round < 30; ++round) {
    Builder b;
    b.beginPrimitive();
    for (int i = 0; i < 7; ++i) b.vertex({any(random), any(random), any(random)});
    for (int i = 0; i < 8; ++i) b.triangle(random() % 7, random() % 7, random() % 7);
    Scene scene = b.scene;
    const SubdivideReport report = splitLongEdges(scene, limit(scene, 2.0));
    checkSound(b.scene, scene, report);
    ASSERT_EQ(junctions(scene), 0u) << round;
  }
}

TEST(Subdivide, CapIsKept) {
  const Builder b = box({10, 10, 10}, true);
  for (const std::uint64_t cap : {0u, 11u, 100u, 5000u}) {
    Scene scene = b.scene;
    SubdivideOptions options;
    options.maxEdgeShare = 1e-3;
    options.maxAddedTriangles = cap;
    const SubdivideReport report = splitLongEdges(scene, options);
    checkSound(b.scene, scene, report);
    checkLengths(scene, report.maxEdge);
    EXPECT_TRUE(report.relaxed);
    EXPECT_LE(triangleCount(scene), triangleCount(b.scene) + cap);
    EXPECT_GE(4 * triangleCount(scene), std::min<std::uint64_t>(4 * triangleCount(b.scene), cap));
    EXPECT_TRUE(openEdges(scene).empty());
  }
}

TEST(Subdivide, InstancesDecideAndTheRestIsLeft) {
  Builder b;
  b.beginPrimitive();
  b.triangle(b.vertex({0, 0, 0}), b.vertex({1, 0, 0}), b.vertex({0, 1, 0}));
  Node large;  // a second, larger instance
  large.mesh = 0;
  large.scale = glm::dvec3(3.0, 3.0, 3.0);
  b.scene.nodes.push_back(large);
  b.scene.instances.push_back({1, 0});
  Scene scene = b.scene;
  splitLongEdges(scene, limit(scene, 2.2));
  EXPECT_EQ(triangleCount(scene), 4u);

  Scene lonely = b.scene;
  lonely.nodes.clear();
  lonely.instances.clear();
  splitLongEdges(lonely, limit(lonely, 0.1));
  EXPECT_EQ(lonely.indices, b.scene.indices);

  for (const double share : {0.0, -1.0, 1.0 / 0.0, std::nan("")}) {
    Scene same = b.scene;
    SubdivideOptions options;
    options.maxEdgeShare = share;
    splitLongEdges(same, options);
    EXPECT_EQ(same.indices, b.scene.indices);
  }
}

TEST(Subdivide, FarFromTheOriginItEnds) {
  Builder b;
  b.beginPrimitive();
  b.triangle(b.vertex({1e7f, 1e7f, 0}), b.vertex({1e7f + 40, 1e7f, 0}), b.vertex({1e7f, 1e7f + 40, 0}));
  Scene scene = b.scene;
  const SubdivideReport report = splitLongEdges(scene, limit(scene, 1e-4));
  EXPECT_FALSE(report.relaxed);  // floats there are a metre apart: no edge can get shorter
  EXPECT_EQ(report.trianglesAfter, triangleCount(scene));
  EXPECT_LE(triangleCount(scene), 2u * 40u * 40u);
  EXPECT_EQ(scene.vertices.normal, scene.vertices.position);
}

}  // namespace
}  // namespace tessera
