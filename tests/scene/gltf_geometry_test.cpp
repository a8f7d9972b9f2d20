#include "engine/scene/gltf_geometry.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tessera {
namespace {

using Indices = std::vector<std::uint32_t>;

Geometry make(std::vector<glm::vec3> positions, Indices indices) {
  Geometry geometry;
  geometry.vertices.position = std::move(positions);
  geometry.indices = std::move(indices);
  return geometry;
}

TEST(GltfTriangleList, StripKeepsWinding) {
  EXPECT_EQ(triangleList(Topology::Strip, {10, 11, 12, 13, 14}),
            (Indices{10, 11, 12, 11, 13, 12, 12, 13, 14}));
}

TEST(GltfTriangleList, FanTurnsAroundItsFirst) {
  EXPECT_EQ(triangleList(Topology::Fan, {7, 8, 9, 10}), (Indices{8, 9, 7, 9, 10, 7}));
}

TEST(GltfTriangleList, RestOfAListIsLeftOut) {
  EXPECT_EQ(triangleList(Topology::Triangles, {0, 1, 2, 3, 4}), (Indices{0, 1, 2}));
  EXPECT_TRUE(triangleList(Topology::Triangles, {0, 1}).empty());
  EXPECT_TRUE(triangleList(Topology::Strip, {0, 1}).empty());
  EXPECT_TRUE(triangleList(Topology::Fan, {}).empty());
}

TEST(GltfDropRepeated, OnlyRepeatedIndices) {
  Indices indices{0, 1, 2, 3, 3, 4, 5, 6, 5, 7, 8, 8, 2, 1, 0};
  EXPECT_EQ(dropRepeatedIndices(indices), 3U);
  EXPECT_EQ(indices, (Indices{0, 1, 2, 2, 1, 0}));
}

TEST(GltfFlat, SharedEdgeIsSplit) {
  // A floor and a wall over the edge from (0,0,0) to (1,0,0).
  Geometry geometry = make({{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}}, {0, 2, 1, 0, 1, 3});
  makeFlat(geometry);
  ASSERT_EQ(geometry.vertices.normal.size(), 6U);
  for (int k = 0; k < 3; ++k)
    EXPECT_EQ(geometry.vertices.normal[static_cast<std::size_t>(k)], glm::vec3(0, 1, 0));
  for (int k = 3; k < 6; ++k)
    EXPECT_EQ(geometry.vertices.normal[static_cast<std::size_t>(k)], glm::vec3(0, 0, 1));
  EXPECT_EQ(geometry.indices, (Indices{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(geometry.vertices.position[1], glm::vec3(0, 0, 1));
  EXPECT_EQ(geometry.vertices.position[5], glm::vec3(0, 1, 0));
}

TEST(GltfFlat, NoAreaStillGivesUnitNormals) {
  Geometry geometry = make({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {0, 1, 2});
  makeFlat(geometry);
  for (const glm::vec3& normal : geometry.vertices.normal) EXPECT_EQ(glm::length(normal), 1.0f);
}

TEST(GltfRepairNormals, ZeroNanAndLongOnes) {
  Geometry geometry = make({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}}, {0, 1, 2});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  geometry.vertices.normal = {{0, 0, 0}, {nan, 0, 0}, {0, 3, 4}, {0, 0, 0}};
  EXPECT_EQ(repairNormals(geometry), 3U);
  EXPECT_EQ(geometry.vertices.normal[0], glm::vec3(0, 0, 1));
  EXPECT_EQ(geometry.vertices.normal[1], glm::vec3(0, 0, 1));
  EXPECT_EQ(geometry.vertices.normal[2], glm::vec3(0, 0.6f, 0.8f));
  EXPECT_EQ(glm::length(geometry.vertices.normal[3]), 1.0f);  // in no face at all
}

TEST(GltfRepairNormals, LargerFaceWeighsMore) {
  // Areas 2 (normal +z) and 0.5 (normal +y): the mean is (0, 1, 4) / sqrt(17).
  Geometry geometry = make({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 1}, {1, 0, 0}}, {0, 1, 2, 0, 3, 4});
  geometry.vertices.normal.assign(5, glm::vec3(0));
  EXPECT_EQ(repairNormals(geometry), 5U);
  const float scale = 1.0f / std::sqrt(17.0f);
  EXPECT_NEAR(geometry.vertices.normal[0].y, scale, 1e-6f);
  EXPECT_NEAR(geometry.vertices.normal[0].z, 4.0f * scale, 1e-6f);
}

TEST(GltfRepairNormals, BackToBackFacesDoNotCancelToNothing) {
  Geometry geometry = make({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2, 0, 2, 1});
  geometry.vertices.normal.assign(3, glm::vec3(0));
  EXPECT_EQ(repairNormals(geometry), 3U);
  EXPECT_EQ(geometry.vertices.normal[0], glm::vec3(0, 0, 1));
}

TEST(GltfWeld, TriangleSoupBecomesIndexed) {
  Geometry geometry =
      make({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {0, 1, 2, 3, 4, 5});
  weld(geometry);
  EXPECT_EQ(geometry.indices, (Indices{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(geometry.vertices.position.size(), 4U);
  EXPECT_EQ(geometry.vertices.position[3], glm::vec3(0, 1, 0));
}

TEST(GltfWeld, EveryAttributeCounts) {
  const auto soup = [] {
    Geometry geometry =
        make({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {0, 1, 2, 3, 4, 5});
    geometry.vertices.normal.assign(6, glm::vec3(0, 0, 1));
    geometry.vertices.tangent.assign(6, glm::vec4(1, 0, 0, 1));
    geometry.vertices.uv0.assign(6, glm::vec2(0));
    geometry.vertices.uv1.assign(6, glm::vec2(0));
    geometry.vertices.color.assign(6, glm::vec4(1));
    return geometry;
  };
  const auto welded = [](Geometry geometry) {
    weld(geometry);
    return geometry.vertices.position.size();
  };
  EXPECT_EQ(welded(soup()), 4U);
  Geometry g = soup();
  g.vertices.normal[3].x = 0.1f;
  EXPECT_EQ(welded(g), 5U);
  g = soup();
  g.vertices.tangent[3].w = -1.0f;
  EXPECT_EQ(welded(g), 5U);
  g = soup();
  g.vertices.uv0[3].y = 1.0f;
  EXPECT_EQ(welded(g), 5U);
  g = soup();
  g.vertices.uv1[3].x = 1.0f;
  EXPECT_EQ(welded(g), 5U);
  g = soup();
  g.vertices.color[3].a = 0.5f;
  EXPECT_EQ(welded(g), 5U);
}

TEST(GltfWeld, ATriangleNeverLosesACorner) {
  // The second triangle has two equal corners: no area, but three indices.
  Geometry geometry =
      make({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 0, 0}, {0, 0, 0}}, {0, 1, 2, 3, 4, 5});
  weld(geometry);
  ASSERT_EQ(geometry.indices.size(), 6U);
  EXPECT_EQ(geometry.indices, (Indices{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(geometry.vertices.position[3], geometry.vertices.position[4]);
}

TEST(GltfCompact, NumbersByFirstUse) {
  VertexCompactor compactor;
  Indices indices{900, 20, 900, 7};
  EXPECT_EQ(compactor.compact(indices), (Indices{900, 20, 7}));
  EXPECT_EQ(indices, (Indices{0, 1, 0, 2}));
  indices = {7, 901};  // nothing is left of the first call
  EXPECT_EQ(compactor.compact(indices), (Indices{7, 901}));
  EXPECT_EQ(indices, (Indices{0, 1}));
}

}  // namespace
}  // namespace tessera
