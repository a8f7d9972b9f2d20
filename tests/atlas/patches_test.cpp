// Patches: every triangle once, layouts and winding of PatchGeometry, quality on meshes with a known best
// answer.
#include "atlas/rect/patches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include <gtest/gtest.h>

namespace tessera {
namespace {

using glsl::PatchGeometry;

struct Mesh {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;

  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    indices.insert(indices.end(), {a, b, c});
  }
  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(indices.size() / 3); }
};

using Corners = std::array<std::uint32_t, 3>;

// The smallest rotation: equal for equal windings, also where a triangle names a vertex twice.
Corners canonical(Corners t) {
  Corners best = t;
  for (int i = 0; i < 2; ++i) {
    std::rotate(t.begin(), t.begin() + 1, t.end());
    best = std::min(best, t);
  }
  return best;
}

std::vector<Corners> trianglesOf(const PatchGeometry& p) {
  if (p.triangles == 1) return {{p.v0, p.v1, p.v2}};
  if (p.triangles == 2) return {{p.v0, p.v1, p.v2}, {p.v0, p.v2, p.v3}};
  return {{p.v0, p.v1, p.v2}, {p.v0, p.v2, p.v3}, {p.v0, p.v3, p.v4}};
}

// What holds for every mesh, however wild.
void checkSound(const Mesh& mesh, const PatchSet& set, const std::string& what) {
  SCOPED_TRACE(what);
  ASSERT_EQ(set.patches.size(), std::size_t{set.pairs} + set.triples + set.singles);
  ASSERT_EQ(2 * set.pairs + 3 * set.triples + set.singles, mesh.count());
  ASSERT_EQ(set.order.size(), mesh.count());
  std::vector<std::uint32_t> seen = set.order;
  std::sort(seen.begin(), seen.end());
  for (std::uint32_t i = 0; i < mesh.count(); ++i) ASSERT_EQ(seen[i], i) << "order is no permutation";

  glsl::InstanceGpu instance{};
  instance.patchBase = 1000;
  instance.pairs = set.pairs;
  instance.triples = set.triples;
  instance.singles = set.singles;
  std::uint32_t place = 0;
  for (std::uint32_t i = 0; i < set.patches.size(); ++i) {
    const PatchGeometry& patch = set.patches[i];
    const std::uint32_t expected = i < set.pairs ? 2u : i < set.pairs + set.triples ? 3u : 1u;
    ASSERT_EQ(patch.triangles, expected) << "patch " << i << " is of the wrong kind for its place";
    if (patch.triangles == 1) {
      ASSERT_EQ(patch.v3, patch.v1);
    }
    if (patch.triangles < 3) {
      ASSERT_TRUE(patch.v4 == patch.v0 || patch.v4 == patch.v1 || patch.v4 == patch.v2 ||
                  patch.v4 == patch.v3);
    }
    for (const Corners& corners : trianglesOf(patch)) {
      ASSERT_EQ(glsl::patchOfTriangle(instance.patchBase, instance.pairs, instance.triples, place),
                instance.patchBase + i);
      const std::uint32_t* t = &mesh.indices[std::size_t{3} * set.order[place]];
      ASSERT_EQ(canonical(corners), canonical({t[0], t[1], t[2]})) << "patch " << i;
      ++place;
    }
  }
}

double area(const Mesh& mesh, std::uint32_t t) {
  const std::array p{glm::dvec3(mesh.positions[mesh.indices[3 * t]]),
                     glm::dvec3(mesh.positions[mesh.indices[3 * t + 1]]),
                     glm::dvec3(mesh.positions[mesh.indices[3 * t + 2]])};
  return 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
}

double totalArea(const Mesh& mesh) {
  double sum = 0.0;
  for (std::uint32_t t = 0; t < mesh.count(); ++t) sum += area(mesh, t);
  return sum;
}

double totalBlockArea(const Mesh& mesh, const PatchSet& set) {
  double sum = 0.0;
  for (const PatchGeometry& patch : set.patches) sum += patchBlockArea(mesh.positions, patch);
  return sum;
}

// A grid of rectangles in space; the triangles in a random order and rotated at random, so that nothing can
// be had from the order of the file.
template <class Place>
Mesh grid(std::uint32_t columns, std::uint32_t rows, bool wrapX, bool wrapY, unsigned seed, Place place) {
  Mesh mesh;
  const std::uint32_t nx = wrapX ? columns : columns + 1;
  const std::uint32_t ny = wrapY ? rows : rows + 1;
  for (std::uint32_t y = 0; y < ny; ++y)
    for (std::uint32_t x = 0; x < nx; ++x) mesh.positions.push_back(place(x, y));
  std::vector<Corners> triangles;
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const auto at = [&](std::uint32_t i, std::uint32_t j) { return (j % ny) * nx + i % nx; };
      triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  std::mt19937 random(seed);
  std::shuffle(triangles.begin(), triangles.end(), random);
  for (Corners& t : triangles) {
    std::rotate(t.begin(), t.begin() + random() % 3, t.end());
    mesh.triangle(t[0], t[1], t[2]);
  }
  return mesh;
}

TEST(Patches, GridPairsIntoItsRectangles) {
  const Mesh mesh = grid(31, 17, false, false, 7, [](std::uint32_t x, std::uint32_t y) {
    return glm::vec3(2.0f * static_cast<float>(x), static_cast<float>(y), 5.0f);
  });
  const PatchSet set = buildPatches(mesh.positions, mesh.indices);
  checkSound(mesh, set, "grid");
  EXPECT_EQ(set.pairs, 31u * 17u);
  EXPECT_NEAR(totalBlockArea(mesh, set), totalArea(mesh), 1e-9 * totalArea(mesh));
}

TEST(Patches, TorusAndSphere) {
  const double pi = std::numbers::pi;
  const Mesh torus = grid(60, 24, true, true, 3, [&](std::uint32_t x, std::uint32_t y) {
    const double a = 2 * pi * x / 60;
    const double b = 2 * pi * y / 24;
    return glm::vec3((3 + cos(b)) * cos(a), (3 + cos(b)) * sin(a), sin(b));
  });
  PatchSet set = buildPatches(torus.positions, torus.indices);
  checkSound(torus, set, "torus");
  EXPECT_EQ(set.pairs, 60u * 24u);
  double trapezoids = 0.0;
  for (std::uint32_t y = 0; y < 24; ++y) {
    for (std::uint32_t x = 0; x < 60; ++x) {
      const auto at = [&](std::uint32_t i, std::uint32_t j) { return j % 24 * 60 + i % 60; };
      trapezoids +=
          patchBlockArea(torus.positions, {at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1), 0, 2});
    }
  }
  EXPECT_LT(totalBlockArea(torus, set), 1.000001 * trapezoids);

  // The outer rows of this sphere are triangles without area beside narrow ones, all else is nearly
  // rectangles.
  const Mesh sphere = grid(40, 20, true, false, 5, [&](std::uint32_t x, std::uint32_t y) {
    const double a = 2 * pi * x / 40;
    const double b = pi * y / 20;
    return glm::vec3(sin(b) * cos(a), sin(b) * sin(a), cos(b));
  });
  set = buildPatches(sphere.positions, sphere.indices);
  checkSound(sphere, set, "sphere");
  EXPECT_EQ(set.pairs + set.triples, 40u * 18u);
}

// Equilateral triangles: every neighbour is as good as the other, so that greedy choices alone strand many.
TEST(Patches, EquilateralMeshIsNearlyPerfectlyMatched) {
  const Mesh mesh = grid(50, 50, false, false, 11, [](std::uint32_t x, std::uint32_t y) {
    return glm::vec3(static_cast<float>(x) - 0.5f * static_cast<float>(y), 0.8660254f * static_cast<float>(y),
                     0.0f);
  });
  const PatchSet set = buildPatches(mesh.positions, mesh.indices, {.triple = false});
  checkSound(mesh, set, "equilateral");
  EXPECT_LE(set.singles, mesh.count() / 100);
}

TEST(Patches, FanStripAndOddCounts) {
  Mesh fan;  // a disc of 7 around a centre
  fan.positions.push_back({0, 0, 0});
  for (int i = 0; i < 7; ++i) {
    const double a = 2 * std::numbers::pi * i / 7;
    fan.positions.push_back({cos(a), sin(a), 0});
  }
  for (std::uint32_t i = 0; i < 7; ++i) fan.triangle(0, 1 + i, 1 + (i + 1) % 7);
  PatchSet set = buildPatches(fan.positions, fan.indices);
  checkSound(fan, set, "fan");
  EXPECT_EQ(set.pairs, 2u);
  EXPECT_EQ(set.triples, 1u);
  EXPECT_EQ(set.singles, 0u);
  set = buildPatches(fan.positions, fan.indices, {.triple = false});
  checkSound(fan, set, "fan without triples");
  EXPECT_EQ(set.pairs, 3u);
  EXPECT_EQ(set.singles, 1u);

  Mesh strip;  // long thin, an odd number of triangles
  for (std::uint32_t i = 0; i < 103; ++i) strip.positions.push_back({0.5 * i, i % 2 == 0 ? 0.0 : 1.0, 0.0});
  for (std::uint32_t i = 0; i + 2 < 103; ++i) {
    if (i % 2 == 0) {
      strip.triangle(i, i + 2, i + 1);
    } else {
      strip.triangle(i, i + 1, i + 2);
    }
  }
  set = buildPatches(strip.positions, strip.indices);
  checkSound(strip, set, "strip");
  EXPECT_EQ(set.singles, 0u);
  EXPECT_EQ(set.triples, 1u);
}

TEST(Patches, TripleIsTheFanAroundTheMiddle) {
  // A rectangle with a vertex in the middle of its lower side: the one mesh that a triple's block fits
  // exactly.
  Mesh mesh;
  mesh.positions = {{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}, {0, 0, 0}};
  mesh.triangle(2, 0, 1);
  mesh.triangle(3, 0, 2);
  mesh.triangle(0, 3, 4);
  const PatchSet set = buildPatches(mesh.positions, mesh.indices);
  checkSound(mesh, set, "rectangle of three");
  ASSERT_EQ(set.triples, 1u);
  const PatchGeometry& p = set.patches[0];
  EXPECT_EQ((std::array{p.v0, p.v1, p.v2, p.v3, p.v4}), (std::array{0u, 1u, 2u, 3u, 4u}));
  EXPECT_NEAR(patchBlockArea(mesh.positions, p), 2.0, 1e-12);
}

TEST(Patches, BlockAreaOfKnownShapes) {
  const std::vector<glm::vec3> p{{0, 0, 0}, {4, 0, 0}, {4, 1, 0}, {0, 1, 0}, {1, 1, 0}, {0.5f, 0.8660254f, 0},
                                 {1, 0, 0}};
  EXPECT_NEAR(patchBlockArea(p, {0, 1, 2, 3, 0, 2}), 4.0, 1e-12);  // rectangle: its area
  EXPECT_NEAR(patchBlockArea(p, {0, 1, 2, 1, 0, 1}), 4.0, 1e-12);  // right triangle: twice its area
  EXPECT_NEAR(patchBlockArea(p, {0, 6, 5, 6, 0, 1}), 1.5, 1e-6);   // equilateral: 1 + cos 60
}

TEST(Patches, SingleTurnsItsLargestAngleToV1) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {0, 0, 9}, {1, 0, 9}, {1, 3, 9}};
  mesh.triangle(1, 2, 0);
  mesh.triangle(5, 3, 4);
  const PatchSet set = buildPatches(mesh.positions, mesh.indices);
  checkSound(mesh, set, "two right triangles");
  ASSERT_EQ(set.singles, 2u);
  EXPECT_EQ(set.patches[0].v1, 1u);
  EXPECT_EQ(set.patches[1].v1, 4u);
}

TEST(Patches, RefusesFoldsWindingAndWorseThanAlone) {
  Mesh halves;  // of a unit square: triangles 0-1-2 and 1-0-3, and 1-0-4 folded up by 60, 1-0-5 by 90 degrees
  const float c = std::sqrt(0.5f);
  halves.positions = {{-c, 0, 0}, {c, 0, 0}, {0, c, 0}, {0, -c, 0}, {0, -0.5f * c, 0.8660254f * c},
                      {0, 0, c}};
  halves.indices = {0, 1, 2, 1, 0, 3};
  EXPECT_EQ(buildPatches(halves.positions, halves.indices).pairs, 1u);
  halves.indices = {0, 1, 2, 1, 0, 4};
  EXPECT_EQ(buildPatches(halves.positions, halves.indices).pairs, 1u);
  halves.indices = {0, 1, 2, 1, 0, 5};
  EXPECT_EQ(buildPatches(halves.positions, halves.indices).pairs, 0u);
  halves.indices = {0, 1, 2, 0, 1, 3};  // one of them turned over
  EXPECT_EQ(buildPatches(halves.positions, halves.indices).pairs, 0u);
  halves.indices = {0, 1, 2, 1, 0, 2};  // front and back of one sheet
  EXPECT_EQ(buildPatches(halves.positions, halves.indices).pairs, 0u);

  Mesh skew;  // two needles end to end: a block for both stretches each more than two blocks would
  skew.positions = {{0, 0, 0}, {0, 1, 0}, {-40, 30, 0}, {40, 30, 0}};
  skew.triangle(0, 1, 2);
  skew.triangle(1, 0, 3);
  const PatchSet set = buildPatches(skew.positions, skew.indices);
  checkSound(skew, set, "needles");
  EXPECT_EQ(set.pairs, 0u);
}

TEST(Patches, PrefersTheConvexPartner) {
  // Triangle 0-1-2 has the same neighbour across 0-1 and across 1-2, but for where it leans: a rhombus, or a
  // dart.
  Mesh mesh;
  mesh.positions = {
      {0, 0, 0}, {1, 0, 0}, {0.5f, 0.8660254f, 0}, {0.5f, -0.8660254f, 0}, {0.5f, 1.7320508f, 0}};
  mesh.triangle(0, 1, 2);
  mesh.triangle(2, 1, 4);
  mesh.triangle(1, 0, 3);
  const PatchSet set = buildPatches(mesh.positions, mesh.indices, {.triple = false});
  checkSound(mesh, set, "partners");
  ASSERT_EQ(set.pairs, 1u);
  EXPECT_EQ(set.order, (std::vector<std::uint32_t>{0, 2, 1}));
}

TEST(Patches, OptionsAndDegenerates) {
  Mesh mesh = grid(9, 9, false, false, 2, [](std::uint32_t x, std::uint32_t y) {
    return glm::vec3(static_cast<float>(x), static_cast<float>(y), 0.0f);
  });
  PatchSet set = buildPatches(mesh.positions, mesh.indices, {.pair = false});
  checkSound(mesh, set, "no pairs");
  EXPECT_EQ(set.singles, mesh.count());

  EXPECT_TRUE(buildPatches(mesh.positions, {}).patches.empty());

  const std::uint32_t before = mesh.count();
  for (std::uint32_t i = 0; i < 20; ++i) {
    mesh.triangle(i, i, i + 1);                                                            // an index twice
    mesh.triangle(i, i, i);                                                                // thrice
    mesh.triangle(mesh.indices[3 * i], mesh.indices[3 * i + 1], mesh.indices[3 * i + 2]);  // a copy
  }
  set = buildPatches(mesh.positions, mesh.indices);
  checkSound(mesh, set, "degenerates and copies");
  EXPECT_GE(set.singles, 40u);  // those without area stay alone
  EXPECT_LE(set.singles, 60u);
  EXPECT_GE(2 * set.pairs + 3 * set.triples, before);
}

TEST(Patches, ManyTrianglesOnOneEdgeStayFast) {
  Mesh mesh;  // a book of 20000 pages, all but flat
  mesh.positions = {{0, 0, 0}, {0, 1, 0}};
  for (std::uint32_t i = 0; i < 20000; ++i) {
    mesh.positions.push_back({i % 2 == 0 ? 1.0f : -1.0f, 0.5f, 1e-6f * static_cast<float>(i)});
    if (i % 2 == 0) {
      mesh.triangle(1, 0, 2 + i);
    } else {
      mesh.triangle(0, 1, 2 + i);
    }
  }
  const PatchSet set = buildPatches(mesh.positions, mesh.indices);
  checkSound(mesh, set, "book");
  EXPECT_EQ(set.pairs, 10000u);
}

TEST(Patches, RandomSoups) {
  std::mt19937 random(42);
  for (int round = 0; round < 300; ++round) {
    Mesh mesh;
    const std::uint32_t vertices = 3 + random() % 40;
    const bool flat = random() % 2 == 0;
    std::uniform_real_distribution<float> place(-1.0f, 1.0f);
    const float scale = std::pow(10.0f, static_cast<float>(static_cast<int>(random() % 41) - 20));
    for (std::uint32_t i = 0; i < vertices; ++i)
      mesh.positions.push_back(scale * glm::vec3(place(random), place(random), flat ? 0.0f : place(random)));
    const std::uint32_t count = random() % 200;
    for (std::uint32_t i = 0; i < count; ++i)
      mesh.triangle(random() % vertices, random() % vertices, random() % vertices);
    for (const bool triple : {false, true}) {
      const PatchSet set = buildPatches(mesh.positions, mesh.indices, {.triple = triple});
      checkSound(mesh, set, "soup " + std::to_string(round));
      EXPECT_TRUE(triple || set.triples == 0);
      const PatchSet again = buildPatches(mesh.positions, mesh.indices, {.triple = triple});
      EXPECT_EQ(set.order, again.order);
    }
  }
}

}  // namespace
}  // namespace tessera
