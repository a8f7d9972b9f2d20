#include "engine/scene/weld.hpp"

#include <random>

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(Weld, FirstEqualByBitsButZero) {
  const std::vector<float> keys{1, 0, 2, 0, 1, -0.0f, 2, 1e-45f, 2, 0};
  EXPECT_EQ(firstEqual(keys, 2), (std::vector<std::uint32_t>{0, 1, 0, 3, 1}));
  EXPECT_TRUE(firstEqual({}, 3).empty());
}

TEST(Weld, MergesWithinAPrimitiveAndKeepsEveryCorner) {
  std::mt19937 random(1);
  for (int round = 0; round < 50; ++round) {
    Scene scene;
    const bool uv = round % 2 == 0;
    for (std::uint32_t p = 0; p < 3; ++p) {
      Primitive primitive;
      primitive.firstVertex = static_cast<std::uint32_t>(scene.vertices.position.size());
      primitive.firstIndex = static_cast<std::uint32_t>(scene.indices.size());
      primitive.vertexCount = 60;
      primitive.indexCount = 60;
      for (std::uint32_t i = 0; i < 60; ++i) {
        scene.vertices.position.emplace_back(random() % 3, random() % 2, 0);
        scene.vertices.normal.emplace_back(0, 0, 1);
        if (uv) scene.vertices.uv0.emplace_back(random() % 2, 0);
        scene.indices.push_back(primitive.firstVertex + random() % 60);
      }
      scene.primitives.push_back(primitive);
    }
    const Scene before = scene;
    const std::size_t gone = weldVertices(scene);
    EXPECT_EQ(scene.vertices.position.size() + gone, before.vertices.position.size());
    EXPECT_LE(scene.vertices.position.size(), std::size_t{3} * (uv ? 12 : 6));
    for (std::size_t i = 0; i < scene.indices.size(); ++i) {
      ASSERT_EQ(scene.vertices.position[scene.indices[i]], before.vertices.position[before.indices[i]]);
      if (uv) {
        ASSERT_EQ(scene.vertices.uv0[scene.indices[i]], before.vertices.uv0[before.indices[i]]);
      }
    }
    std::uint32_t next = 0;
    for (const Primitive& primitive : scene.primitives) {
      ASSERT_EQ(primitive.firstVertex, next);
      next += primitive.vertexCount;
      for (std::uint32_t i = 0; i < primitive.indexCount; ++i) {
        ASSERT_GE(scene.indices[primitive.firstIndex + i], primitive.firstVertex);
        ASSERT_LT(scene.indices[primitive.firstIndex + i], next);
      }
    }
    ASSERT_EQ(next, scene.vertices.position.size());
    ASSERT_EQ(weldVertices(scene), 0u);
  }
}

}  // namespace
}  // namespace tessera
