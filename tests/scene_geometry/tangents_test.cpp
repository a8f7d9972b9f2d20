// Tangents against surfaces whose derivatives are known in closed form. Corners are compared, not vertices:
// splitting must not move anything else.
#include "engine/scene/tangents.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "engine/scene/gltf.hpp"

namespace tessera {
namespace {

constexpr double kPi = std::numbers::pi;

struct Point {
  glm::dvec3 position;
  glm::dvec3 normal;
  glm::dvec2 uv;
};

Scene emptyScene() {
  Scene scene;
  scene.primitives.push_back({});
  return scene;
}

void addVertex(Scene& scene, const Point& p) {
  scene.vertices.position.emplace_back(p.position);
  scene.vertices.normal.emplace_back(p.normal);
  scene.vertices.uv0.emplace_back(p.uv);
  scene.primitives.back().vertexCount++;
}

void addTriangle(Scene& scene, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  scene.indices.insert(scene.indices.end(), {a, b, c});
  scene.primitives.back().indexCount += 3;
}

// A surface over a grid of two triangles a cell, counter-clockwise seen from the normal where x, y, normal
// are right-handed.
Scene surface(std::uint32_t columns, std::uint32_t rows, const std::function<Point(double, double)>& at) {
  Scene scene = emptyScene();
  for (std::uint32_t y = 0; y <= rows; ++y)
    for (std::uint32_t x = 0; x <= columns; ++x) addVertex(scene, at(double(x) / columns, double(y) / rows));
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t a = y * (columns + 1) + x;
      addTriangle(scene, a, a + 1, a + columns + 2);
      addTriangle(scene, a, a + columns + 2, a + columns + 1);
    }
  }
  return scene;
}

void checkSound(const Scene& before, const Scene& after) {
  const Primitive& p = after.primitives.back();
  ASSERT_EQ(std::size_t{p.firstVertex} + p.vertexCount, after.vertices.position.size());
  ASSERT_EQ(after.vertices.tangent.size(), after.vertices.position.size());
  ASSERT_EQ(after.vertices.normal.size(), after.vertices.position.size());
  ASSERT_EQ(after.vertices.uv0.size(), before.vertices.uv0.empty() ? 0 : after.vertices.position.size());
  ASSERT_EQ(after.indices.size(), before.indices.size());
  for (std::size_t c = 0; c < after.indices.size(); ++c) {
    const std::uint32_t now = after.indices[c];
    const std::uint32_t then = before.indices[c];
    ASSERT_LT(now, after.vertices.position.size());
    ASSERT_EQ(after.vertices.position[now], before.vertices.position[then]);
    ASSERT_EQ(after.vertices.normal[now], before.vertices.normal[then]);
    if (!before.vertices.uv0.empty()) {
      ASSERT_EQ(after.vertices.uv0[now], before.vertices.uv0[then]);
    }
    const glm::vec4 t = after.vertices.tangent[now];
    ASSERT_NEAR(glm::length(glm::vec3(t)), 1.0f, 1e-5f);
    ASSERT_NEAR(glm::dot(glm::vec3(t), after.vertices.normal[now]), 0.0f, 1e-5f);
    ASSERT_EQ(std::abs(t.w), 1.0f);
  }
}

Scene generated(const Scene& before) {
  Scene after = before;
  generateTangents(after, static_cast<std::uint32_t>(after.primitives.size()) - 1, 0);
  checkSound(before, after);
  return after;
}

glm::vec4 cornerTangent(const Scene& scene, std::size_t corner) {
  return scene.vertices.tangent[scene.indices[corner]];
}

TEST(Tangents, PlaneWithUprightPicture) {
  // u to the right, v down: the bitangent, cross(normal, tangent) * w, is up.
  const Scene scene = generated(surface(4, 3, [](double x, double y) {
    return Point{{x, 2 * y, 0}, {0, 0, 1}, {3 * x, 1 - y}};
  }));
  EXPECT_EQ(scene.vertices.position.size(), 20u);
  for (std::size_t c = 0; c < scene.indices.size(); ++c)
    ASSERT_EQ(cornerTangent(scene, c), glm::vec4(1, 0, 0, 1));
}

TEST(Tangents, PlaneWithTurnedAndShearedPicture) {
  // Position = A uv, so the tangent is the first column of A whatever the shear.
  const Scene scene = generated(surface(3, 3, [](double x, double y) {
    const glm::dvec2 uv(x, y);
    return Point{{0.6 * uv.x - uv.y, 0.8 * uv.x - 0.5 * uv.y, 4}, {0, 0, -1}, uv};
  }));
  for (std::size_t c = 0; c < scene.indices.size(); ++c) {
    ASSERT_NEAR(cornerTangent(scene, c).x, 0.6f, 1e-6f);
    ASSERT_NEAR(cornerTangent(scene, c).y, 0.8f, 1e-6f);
    ASSERT_EQ(cornerTangent(scene, c).w, -1.0f);
  }
}

TEST(Tangents, MirroredHalvesSplitTheSeam) {
  // u runs out from the middle on both sides. The vertices of the seam are shared and have one UV each.
  const Scene before = surface(2, 2, [](double x, double y) {
    return Point{{x, y, 0}, {0, 0, 1}, {std::abs(x - 0.5), 1 - y}};
  });
  const Scene after = generated(before);
  EXPECT_EQ(after.vertices.position.size(), before.vertices.position.size() + 3);
  for (std::size_t c = 0; c < after.indices.size(); ++c) {
    double x = 0.0;
    for (std::size_t k = 0; k < 3; ++k)
      x += static_cast<double>(before.vertices.position[before.indices[c - c % 3 + k]].x);
    const bool right = x / 3 > 0.5;
    ASSERT_EQ(cornerTangent(after, c), right ? glm::vec4(1, 0, 0, 1) : glm::vec4(-1, 0, 0, -1)) << c;
  }
}

TEST(Tangents, CylinderAndItsSeam) {
  const Scene before = surface(32, 2, [](double x, double y) {
    const double a = 2 * kPi * x;
    return Point{{cos(a), sin(a), 3 * y}, {cos(a), sin(a), 0}, {x, 1 - y}};
  });
  const Scene after = generated(before);
  EXPECT_EQ(after.vertices.position.size(), before.vertices.position.size());
  for (std::uint32_t v = 0; v < after.vertices.position.size(); ++v) {
    const std::uint32_t column = v % 33;
    const double a = 2 * kPi * column / 32;
    // Facets turn by 1/32 of a circle. Within the picture both sides weigh the same; at its ends there is one
    // side.
    const bool end = column == 0 || column == 32;
    const double angle =
        std::acos(glm::dot(glm::dvec3(after.vertices.tangent[v]), glm::dvec3(-sin(a), cos(a), 0)));
    ASSERT_LT(angle, end ? kPi / 32 : 1e-3) << v;
    ASSERT_EQ(after.vertices.tangent[v].w, 1.0f);
  }
}

// Three faces around the z axis with one normal and corner angles of 60, 60 and 120 degrees; the UVs along
// the spokes give each another tangent. The faces do not share indices: equal vertices count as one. `turn`
// says which corner of the faces is the centre.
void checkWeights(std::size_t turn) {
  Scene scene = emptyScene();
  const std::array starts{0.0, 60.0, 120.0, 240.0};
  const std::array<glm::dvec2, 4> spoke{glm::dvec2(1, 0), glm::dvec2(0.5, -0.8), glm::dvec2(-0.7, -0.9),
                                        glm::dvec2(-0.4, 0.9)};
  const auto at = [&](double degrees) {
    return glm::dvec3(cos(degrees * kPi / 180), sin(degrees * kPi / 180), 0.0);
  };
  glm::dvec2 sum(0.0);
  for (std::size_t i = 0; i < 3; ++i) {
    const glm::dvec3 a = at(starts[i]);
    const glm::dvec3 b = at(starts[i + 1]);
    std::array<Point, 3> points{Point{{0, 0, 0}, {0, 0, 1}, {0, 0}}, Point{a, {0, 0, 1}, spoke[i]},
                                Point{b, {0, 0, 1}, spoke[i + 1]}};
    std::rotate(points.rbegin(), points.rbegin() + static_cast<std::ptrdiff_t>(turn), points.rend());
    const auto first = static_cast<std::uint32_t>(scene.vertices.position.size());
    for (const Point& p : points) addVertex(scene, p);
    addTriangle(scene, first, first + 1, first + 2);
    // Solve a = u du + v dv for du by Cramer's rule, in the plane.
    const double det = spoke[i].x * spoke[i + 1].y - spoke[i].y * spoke[i + 1].x;
    const glm::dvec2 du((a.x * spoke[i + 1].y - b.x * spoke[i].y) / det,
                        (a.y * spoke[i + 1].y - b.y * spoke[i].y) / det);
    ASSERT_LT(det, 0.0);
    sum += glm::normalize(du) * (starts[i + 1] - starts[i]);
  }
  const Scene after = generated(scene);
  sum = glm::normalize(sum);
  for (std::size_t face = 0; face < 3; ++face) {
    const glm::vec4 centre = cornerTangent(after, 3 * face + turn);
    EXPECT_NEAR(centre.x, sum.x, 1e-6);
    EXPECT_NEAR(centre.y, sum.y, 1e-6);
    EXPECT_EQ(centre.w, 1.0f);
  }
}

TEST(Tangents, WeightsByAngleAndJoinsEqualVertices) {
  for (std::size_t turn = 0; turn < 3; ++turn) checkWeights(turn);
}

TEST(Tangents, FansThatMeetInAPointStayApart) {
  Scene scene = emptyScene();
  addVertex(scene, {{0, 0, 0}, {0, 0, 1}, {0, 0}});
  addVertex(scene, {{1, 0, 0}, {0, 0, 1}, {1, 0}});
  addVertex(scene, {{1, 1, 0}, {0, 0, 1}, {1, -1}});
  addVertex(scene, {{-1, 0, 0}, {0, 0, 1}, {0, 1}});
  addVertex(scene, {{-1, -1, 0}, {0, 0, 1}, {-1, 1}});
  addTriangle(scene, 0, 1, 2);
  addTriangle(scene, 0, 3, 4);
  const Scene after = generated(scene);
  EXPECT_EQ(after.vertices.position.size(), 6u);
  EXPECT_EQ(cornerTangent(after, 0), glm::vec4(1, 0, 0, 1));
  EXPECT_NEAR(cornerTangent(after, 3).y, 1.0f, 1e-6f);
}

TEST(Tangents, DegenerateFacesFollowTheirNeighbours) {
  // The picture is turned: any perpendicular would not do.
  Scene scene = surface(2, 2, [](double x, double y) { return Point{{x, y, 0}, {0, 0, 1}, {1 - y, 1 - x}}; });
  addTriangle(scene, 0, 1, 1);  // no area
  const auto first = static_cast<std::uint32_t>(scene.vertices.position.size());
  addVertex(scene, {{0, 0, 0}, {0, 0, 1}, {1, 1}});  // the same point as vertex 0, by a face without UV area
  addVertex(scene, {{5, 0, 0}, {0, 0.6, 0.8}, {1, 1}});
  addVertex(scene, {{5, 5, 0}, {1, 0, 0}, {1, 1}});
  addTriangle(scene, first, first + 1, first + 2);
  addVertex(scene, {{9, 9, 9}, {0, 1, 0}, {0, 0}});  // not used at all
  const Scene after = generated(scene);
  EXPECT_EQ(after.vertices.position.size(), scene.vertices.position.size());
  EXPECT_EQ(after.vertices.tangent[first], glm::vec4(0, -1, 0, 1));
  EXPECT_NEAR(glm::dot(glm::vec3(after.vertices.tangent.back()), glm::vec3(0, 1, 0)), 0.0f, 1e-6f);

  Scene bare = scene;  // no UVs anywhere
  bare.vertices.uv0.clear();
  generated(bare);
}

TEST(Tangents, EarlierPrimitivesStayAsTheyAre) {
  Scene scene = surface(2, 2, [](double x, double y) { return Point{{x, y, 0}, {0, 0, 1}, {x, 1 - y}}; });
  scene.vertices.tangent.assign(scene.vertices.position.size(), glm::vec4(0, 1, 0, -1));
  Primitive second;
  second.firstVertex = scene.primitives[0].vertexCount;
  second.firstIndex = scene.primitives[0].indexCount;
  scene.primitives.push_back(second);
  addVertex(scene, {{0, 0, 0}, {0, 0, 1}, {0, 0}});
  addVertex(scene, {{1, 0, 0}, {0, 0, 1}, {0, 1}});
  addVertex(scene, {{0, 1, 0}, {0, 0, 1}, {1, 0}});
  addTriangle(scene, second.firstVertex, second.firstVertex + 1, second.firstVertex + 2);
  const Scene after = generated(scene);
  for (std::uint32_t v = 0; v < second.firstVertex; ++v)
    ASSERT_EQ(after.vertices.tangent[v], glm::vec4(0, 1, 0, -1));
  EXPECT_NEAR(cornerTangent(after, second.firstIndex).y, 1.0f, 1e-6f);
  EXPECT_EQ(cornerTangent(after, second.firstIndex).w, 1.0f);
}

TEST(Tangents, RandomSoupsStaySound) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int round = 0; round < 200; ++round) {
    Scene scene = emptyScene();
    const std::uint32_t count = 3 + random() % 30;
    for (std::uint32_t i = 0; i < count; ++i) {
      const glm::dvec2 uv(std::round(2 * any(random)), std::round(2 * any(random)));
      addVertex(scene, {glm::round(2.0 * glm::dvec3(any(random), any(random), any(random))),
                        glm::normalize(glm::dvec3(any(random), any(random), any(random))), uv});
    }
    scene.vertices.uv0[0].x = round % 3 == 0 ? std::numeric_limits<float>::infinity() : 0.0f;
    for (std::uint32_t i = 0; i < 60; ++i)
      addTriangle(scene, random() % count, random() % count, random() % count);
    const Scene after = generated(scene);
    for (std::size_t f = 0; f < after.indices.size(); f += 3) {
      const auto uv = [&](std::size_t k) { return glm::dvec2(scene.vertices.uv0[scene.indices[f + k]]); };
      const glm::dvec2 a = uv(1) - uv(0);
      const glm::dvec2 b = uv(2) - uv(0);
      const double area = a.x * b.y - a.y * b.x;
      if (!std::isfinite(area) || area == 0.0) continue;
      const auto p = [&](std::size_t k) { return glm::dvec3(scene.vertices.position[scene.indices[f + k]]); };
      if (glm::cross(p(1) - p(0), p(2) - p(0)) == glm::dvec3(0.0)) continue;
      for (std::size_t k = 0; k < 3; ++k) ASSERT_EQ(cornerTangent(after, f + k).w, area > 0.0 ? -1.0f : 1.0f);
    }
  }
}

// A file whose tangents another tool made, by a like method but not the same one: most agree closely.
TEST(Tangents, AgreeWithAFilesOwn) {
  const std::filesystem::path file = std::filesystem::path(TESSERA_SHARED_DIR) / "scenes/flight_helmet.glb";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  GltfOptions options;
  options.loadImages = false;
  const Result<Scene> loaded = loadGltf(file, options);
  ASSERT_TRUE(loaded) << loaded.error().message;
  std::vector<double> degrees;
  std::size_t sameSign = 0;
  for (const Primitive& primitive : loaded->primitives) {
    if (!loaded->materials[primitive.material].normal.used()) continue;
    Scene alone = emptyScene();
    for (std::uint32_t v = primitive.firstVertex; v < primitive.firstVertex + primitive.vertexCount; ++v)
      addVertex(alone, {loaded->vertices.position[v], loaded->vertices.normal[v], loaded->vertices.uv0[v]});
    for (std::uint32_t i = 0; i < primitive.indexCount; ++i)
      alone.indices.push_back(loaded->indices[primitive.firstIndex + i] - primitive.firstVertex);
    alone.primitives.back().indexCount = primitive.indexCount;
    const Scene after = generated(alone);
    for (std::uint32_t i = 0; i < primitive.indexCount; ++i) {
      const glm::vec4 theirs = loaded->vertices.tangent[loaded->indices[primitive.firstIndex + i]];
      const glm::vec4 ours = cornerTangent(after, i);
      const double cosine = std::clamp<double>(glm::dot(glm::vec3(theirs), glm::vec3(ours)), -1.0, 1.0);
      degrees.push_back(std::acos(cosine) * 180 / kPi);
      sameSign += theirs.w == ours.w ? 1 : 0;
    }
  }
  ASSERT_GT(degrees.size(), 200'000u);
  std::sort(degrees.begin(), degrees.end());
  EXPECT_LT(degrees[degrees.size() / 2], 0.5);
  EXPECT_LT(degrees[degrees.size() * 9 / 10], 3.0);
  EXPECT_GT(static_cast<double>(sameSign), 0.999 * static_cast<double>(degrees.size()));
}

}  // namespace
}  // namespace tessera
