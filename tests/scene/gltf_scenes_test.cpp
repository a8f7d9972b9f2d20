// The scenes of ../shared/scenes, against its table and against a count made from their JSON alone.
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <functional>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/core/file.hpp"
#include "engine/scene/gltf.hpp"
#include "scene_invariants.hpp"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const fs::path kScenes = fs::path(TESSERA_SHARED_DIR) / "scenes";

Json jsonOf(const fs::path& file) {
  const auto bytes = readFile(file).value();
  std::uint32_t length = 0;
  std::memcpy(&length, &bytes.at(12), 4);
  return Json::parse(bytes.begin() + 20, bytes.begin() + 20 + length);
}

/// Triangles as instanced, from counts of accessors: all these files draw lists from their default scene.
std::uint64_t trianglesByJson(const Json& json) {
  const auto inMesh = [&](const Json& mesh) {
    std::uint64_t count = 0;
    for (const Json& primitive : mesh["primitives"]) {
      EXPECT_EQ(primitive.value("mode", 4), 4);
      const int accessor = primitive.value("indices", primitive["attributes"]["POSITION"].get<int>());
      count += json["accessors"][static_cast<std::size_t>(accessor)]["count"].get<std::uint64_t>() / 3;
    }
    return count;
  };
  const std::function<std::uint64_t(std::size_t)> below = [&](std::size_t index) {
    const Json& node = json["nodes"][index];
    std::uint64_t count = node.contains("mesh") ? inMesh(json["meshes"][node["mesh"].get<std::size_t>()]) : 0;
    for (const Json& child : node.value("children", Json::array())) count += below(child.get<std::size_t>());
    return count;
  };
  std::uint64_t count = 0;
  for (const Json& root : json["scenes"][json.value("scene", std::size_t{0})]["nodes"])
    count += below(root.get<std::size_t>());
  return count;
}

struct Row {
  const char* file;
  std::uint64_t triangles;
  std::uint64_t unique;
  std::size_t objects;  // nodes that show a mesh
  std::size_t materials;
  std::size_t blend;
  std::size_t mask;
  std::size_t images;
  std::size_t channels;
};

// The table of ../shared/scenes/README.md.
constexpr Row kTable[] = {
    {"sponza.glb", 262267, 262267, 1, 25, 0, 3, 69, 0},
    {"warehouse.glb", 15003, 9873, 26, 20, 0, 0, 14, 0},
    {"candela_city.glb", 444914, 126196, 830, 94, 7, 22, 109, 254},
    {"littlest_tokyo.glb", 141802, 141802, 71, 15, 4, 3, 4, 96},
    {"flight_helmet.glb", 94722, 94722, 6, 6, 1, 0, 15, 0},
    {"truck_town.glb", 30477, 30477, 20, 9, 0, 0, 2, 0},
};

TEST(GltfScenes, AreAsTheirTableSays) {
  if (!fs::exists(kScenes)) GTEST_SKIP() << kScenes << " is absent";
  for (const Row& row : kTable) {
    SCOPED_TRACE(row.file);
    const auto scene = loadGltf(kScenes / row.file);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(test::brokenInvariant(*scene), "");
    EXPECT_EQ(scene->triangleCount(), row.triangles);
    EXPECT_EQ(scene->indices.size() / 3, row.unique);
    EXPECT_EQ(scene->materials.size(), row.materials);
    EXPECT_EQ(scene->images.size(), row.images);
    std::set<std::uint32_t> objects;
    for (const Instance& instance : scene->instances) objects.insert(instance.node);
    EXPECT_EQ(objects.size(), row.objects);
    std::size_t channels = 0;
    for (const Animation& animation : scene->animations) channels += animation.channels.size();
    EXPECT_EQ(channels, row.channels);
    const auto count = [&](AlphaMode mode) {
      return static_cast<std::size_t>(std::ranges::count(scene->materials, mode, &Material::alphaMode));
    };
    EXPECT_EQ(count(AlphaMode::Blend), row.blend);
    EXPECT_EQ(count(AlphaMode::Mask), row.mask);
  }
}

TEST(GltfScenes, EveryFileLoadsWithTheTrianglesOfItsAccessors) {
  if (!fs::exists(kScenes)) GTEST_SKIP() << kScenes << " is absent";
  std::size_t files = 0;
  for (const fs::path& folder : {kScenes, kScenes / "feature"}) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() != ".glb") continue;
      SCOPED_TRACE(entry.path());
      const auto scene = loadGltf(entry.path(), {.loadImages = false, .progress = {}});
      ASSERT_TRUE(scene) << scene.error().message;
      EXPECT_EQ(test::brokenInvariant(*scene, false), "");
      EXPECT_EQ(scene->triangleCount(), trianglesByJson(jsonOf(entry.path())));
      ++files;
    }
  }
  EXPECT_EQ(files, 17U);
}

Scene feature(const char* name) {
  auto scene = loadGltf(kScenes / "feature" / name);
  EXPECT_TRUE(scene) << scene.error().message;
  return scene ? std::move(*scene) : Scene{};
}

TEST(GltfScenes, Features) {
  if (!fs::exists(kScenes)) GTEST_SKIP() << kScenes << " is absent";
  EXPECT_EQ(feature("CesiumMan.glb").warnings, (std::vector<std::string>{"skins are not applied (node 1)"}));
  EXPECT_EQ(feature("AnimatedMorphCube.glb").warnings.at(0),
            "morph targets are not applied (mesh 0, primitive 0)");
  EXPECT_EQ(feature("BoxBadNormals.glb").warnings.size(), 1U);
  const Scene lights = feature("Lights_punctual.glb");
  std::set<LightType> types;
  for (const Light& light : lights.lights) types.insert(light.type);
  EXPECT_EQ(types.size(), 3U);
  for (const Material& material : feature("UnlitTest.glb").materials) EXPECT_TRUE(material.unlit);
  EXPECT_FALSE(feature("VertexColorTest.glb").vertices.color.empty());
  EXPECT_TRUE(feature("CesiumMilkTruck.glb").animated());
  const Scene alpha = feature("AlphaBlendModeTest.glb");
  EXPECT_TRUE(
      std::ranges::any_of(alpha.materials, [](const Material& m) { return m.alphaMode == AlphaMode::Mask; }));
  EXPECT_EQ(feature("NormalTangentTest.glb").vertices.tangent.size(),
            feature("NormalTangentTest.glb").vertices.position.size());
}

// In the picture the arrow's tip is at (0.778, 0.778). On each transformed quad a green mark says where the
// tip must show: the transform has to send the mark's
// place to the tip, to half the width of the mark (0.05).
TEST(GltfScenes, TextureTransformSendsTheMarksToTheArrowTip) {
  if (!fs::exists(kScenes)) GTEST_SKIP() << kScenes << " is absent";
  const Scene scene = feature("TextureTransformTest.glb");
  SceneState state;
  evaluate(scene, 0.0, state);
  const auto boxOf = [&](const Instance& instance) {
    const Primitive& primitive = scene.primitives[instance.primitive];
    Box box;
    for (std::uint32_t v = primitive.firstVertex; v < primitive.firstVertex + primitive.vertexCount; ++v)
      box.add(
          glm::dvec3(state.world[instance.node] * glm::dvec4(glm::dvec3(scene.vertices.position[v]), 1.0)));
    return box;
  };
  int marks = 0;
  for (const Instance& quad : scene.instances) {
    const Material& material = scene.materials[scene.primitives[quad.primitive].material];
    if (material.name != "Rotation" && material.name != "Scale" && material.name != "All") continue;
    const Box box = boxOf(quad);
    for (const Instance& mark : scene.instances) {
      const glm::dvec3 centre = boxOf(mark).centre();
      if (scene.materials[scene.primitives[mark.primitive].material].name != "Correct" ||
          centre.x < box.min.x || centre.x > box.max.x)
        continue;
      const glm::vec3 uv(centre.x - box.min.x, box.max.y - centre.y, 1.0);
      EXPECT_NEAR(glm::dot(material.baseColor.uvTransform[0], uv), 0.778f, 0.05f) << material.name;
      EXPECT_NEAR(glm::dot(material.baseColor.uvTransform[1], uv), 0.778f, 0.05f) << material.name;
      ++marks;
    }
  }
  EXPECT_EQ(marks, 3);
}

}  // namespace
}  // namespace tessera
