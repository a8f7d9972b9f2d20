// Values worked out by hand, through whole files made in code.
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "engine/image/image.hpp"
#include "gltf_maker.hpp"
#include "scene_invariants.hpp"

namespace tessera::test {
namespace {

using std::numbers::pi;
using Indices = std::vector<std::uint32_t>;

Scene loaded(const GltfMaker& maker) {
  auto scene = maker.load();
  EXPECT_TRUE(scene) << scene.error().message;
  if (!scene) return {};
  EXPECT_EQ(brokenInvariant(*scene), "");
  return std::move(*scene);
}

/// A material with a base colour texture, for primitives that are to keep their UVs.
int addTexturedMaterial(GltfMaker& maker, int texCoord = 0) {
  return maker.append("materials",
                      {{"pbrMetallicRoughness",
                        {{"baseColorTexture", {{"index", maker.addTexture()}, {"texCoord", texCoord}}}}}});
}

void expectNear(const glm::vec3& a, const glm::vec3& b, float tolerance = 1e-6f) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << "component " << c;
}

TEST(GltfValues, SquareAsWritten) {
  const Scene scene = loaded(square());
  EXPECT_EQ(scene.indices, (Indices{0, 1, 2, 0, 2, 3}));
  ASSERT_EQ(scene.vertices.position.size(), 4U);
  EXPECT_EQ(scene.vertices.position[2], glm::vec3(1, 1, 0));
  EXPECT_EQ(scene.vertices.normal[2], glm::vec3(0, 0, 1));
  EXPECT_TRUE(scene.vertices.uv0.empty() && scene.vertices.uv1.empty() && scene.vertices.color.empty() &&
              scene.vertices.tangent.empty());
  EXPECT_EQ(scene.materials.size(), 1U);  // the default
  EXPECT_EQ(scene.bounds.min, glm::dvec3(0, 0, 0));
  EXPECT_EQ(scene.bounds.max, glm::dvec3(1, 1, 0));
  EXPECT_EQ(scene.primitives[0].bounds.max, glm::dvec3(1, 1, 0));
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(GltfValues, IndexTypes) {
  for (const int type : {kUbyte, kUshort, kUint, 0}) {
    GltfMaker maker = square();
    if (type == kUbyte)
      maker.primitive()["indices"] = maker.addAccessor<std::uint8_t>({0, 1, 2, 0, 2, 3}, kUbyte, "SCALAR", 1);
    if (type == kUint)
      maker.primitive()["indices"] = maker.addAccessor<std::uint32_t>({0, 1, 2, 0, 2, 3}, kUint, "SCALAR", 1);
    if (type == 0) {
      maker = triangle();
      EXPECT_EQ(loaded(maker).indices, (Indices{0, 1, 2}));
    } else {
      EXPECT_EQ(loaded(maker).indices, (Indices{0, 1, 2, 0, 2, 3})) << type;
    }
  }
}

TEST(GltfValues, StripsAndFans) {
  GltfMaker maker = square();
  maker.primitive()["mode"] = 5;
  maker.primitive()["indices"] = maker.addAccessor<std::uint16_t>({0, 1, 3, 2}, kUshort, "SCALAR", 1);
  Scene scene = loaded(maker);
  // Strip 0 1 3 2: (0 1 3) and (1 2 3); new numbers by first use: 0 1 3 -> 0 1 2, then 2 -> 3.
  EXPECT_EQ(scene.indices, (Indices{0, 1, 2, 1, 3, 2}));
  EXPECT_EQ(scene.vertices.position[3], glm::vec3(1, 1, 0));

  maker.primitive()["mode"] = 6;
  maker.primitive().erase("indices");
  scene = loaded(maker);
  // Fan 0 1 2 3: (1 2 0) and (2 3 0).
  EXPECT_EQ(scene.indices, (Indices{0, 1, 2, 1, 3, 2}));
  EXPECT_EQ(scene.vertices.position[0], glm::vec3(1, 0, 0));
  EXPECT_EQ(scene.vertices.position[2], glm::vec3(0, 0, 0));
}

TEST(GltfValues, RepeatedIndicesGoZeroAreaStays) {
  GltfMaker maker = square();
  maker.primitive()["indices"] =
      maker.addAccessor<std::uint16_t>({0, 1, 1, 0, 1, 2, 3, 0, 3}, kUshort, "SCALAR", 1);
  EXPECT_EQ(loaded(maker).triangleCount(), 1U);
  maker = triangle();
  maker.primitive()["attributes"]["POSITION"] =
      maker.addAccessor<float>({0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0}, kFloat, "VEC3", 3);
  EXPECT_EQ(loaded(maker).triangleCount(), 2U);
}

TEST(GltfValues, NormalizedColours) {
  GltfMaker maker = square();
  // Three components in four bytes: the stride is given.
  const std::vector<std::uint8_t> rgb{255, 0, 51, 0, 128, 1, 2, 0, 0, 0, 0, 0, 255, 255, 255, 0};
  const int view = maker.addView(rgb);
  maker.json["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = 4;
  maker.primitive()["attributes"]["COLOR_0"] = maker.append("accessors", {{"bufferView", view},
                                                                          {"componentType", kUbyte},
                                                                          {"type", "VEC3"},
                                                                          {"count", 4},
                                                                          {"normalized", true}});
  Scene scene = loaded(maker);
  EXPECT_TRUE(scene.primitives[0].hasColor);
  EXPECT_EQ(scene.vertices.color[0], glm::vec4(1, 0, 0.2f, 1));
  EXPECT_FLOAT_EQ(scene.vertices.color[1].r, 128.0f / 255.0f);
  EXPECT_EQ(scene.vertices.color[3], glm::vec4(1));

  maker.primitive()["attributes"]["COLOR_0"] = maker.addAccessor<std::uint16_t>(
      {65535, 0, 13107, 32768, 0, 0, 0, 0, 1, 2, 3, 4, 65535, 65535, 65535, 65535}, kUshort, "VEC4", 4, true);
  scene = loaded(maker);
  EXPECT_EQ(scene.vertices.color[0].b, 0.2f);
  EXPECT_FLOAT_EQ(scene.vertices.color[0].a, 32768.0f / 65535.0f);
  EXPECT_EQ(scene.vertices.color[1], glm::vec4(0));
  EXPECT_FLOAT_EQ(scene.vertices.color[2].a, 4.0f / 65535.0f);

  maker.primitive()["attributes"]["COLOR_0"] =
      maker.addAccessor<float>({0.5, 2, -1, 0, 0, 0, 0, 0, 0, 0, 0, 0}, kFloat, "VEC3", 3);
  EXPECT_EQ(loaded(maker).vertices.color[0], glm::vec4(0.5, 2, 0, 1));
}

TEST(GltfValues, WhiteColoursAreNoColours) {
  GltfMaker maker = square();
  maker.primitive()["attributes"]["COLOR_0"] =
      maker.addAccessor<std::uint8_t>(Bytes(16, 255), kUbyte, "VEC4", 4, true);
  const Scene scene = loaded(maker);
  EXPECT_FALSE(scene.primitives[0].hasColor);
  EXPECT_TRUE(scene.vertices.color.empty());
}

TEST(GltfValues, QuantizedAttributes) {
  GltfMaker maker = square();
  maker.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  maker.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  maker.primitive()["attributes"]["POSITION"] = maker.append(
      "accessors", {{"bufferView", maker.addView(std::vector<std::int8_t>{0, 0, 0, 0, 127, 0, 0, 0, 127, 127,
                                                                          0, 0, 0, -128, 3, 0})},
                    {"componentType", kByte},
                    {"type", "VEC3"},
                    {"count", 4}});
  maker.json["bufferViews"].back()["byteStride"] = 4;
  maker.primitive()["attributes"]["NORMAL"] = maker.append(
      "accessors",
      {{"bufferView", maker.addView(std::vector<std::int16_t>{-32768, 0, 0, 0, 0, -32767, 0, 0, 0, 0, 32767,
                                                              0, 16384, 0, -16384, 0})},
       {"componentType", kShort},
       {"type", "VEC3"},
       {"count", 4},
       {"normalized", true}});
  maker.json["bufferViews"].back()["byteStride"] = 8;
  const Scene scene = loaded(maker);
  EXPECT_EQ(scene.vertices.position[1], glm::vec3(127, 0, 0));
  EXPECT_EQ(scene.vertices.position[3], glm::vec3(0, -128, 3));
  EXPECT_EQ(scene.vertices.normal[0], glm::vec3(-1, 0, 0));  // -32768 is clamped to -1
  EXPECT_EQ(scene.vertices.normal[1], glm::vec3(0, -1, 0));
  EXPECT_EQ(scene.vertices.normal[2], glm::vec3(0, 0, 1));
  expectNear(scene.vertices.normal[3], glm::vec3(std::sqrt(0.5f), 0, -std::sqrt(0.5f)));
  EXPECT_TRUE(scene.warnings.empty());

  maker.json["accessors"][static_cast<std::size_t>(maker.primitive()["attributes"]["POSITION"])]
            ["normalized"] = true;
  EXPECT_EQ(loaded(maker).vertices.position[3].y, -1.0f);  // -128 / 127, clamped

  maker.json.erase("extensionsRequired");
  maker.json.erase("extensionsUsed");
  EXPECT_EQ(loaded(maker).warnings.size(), 1U);
}

TEST(GltfValues, InterleavedWithOffset) {
  GltfMaker maker = square();
  std::vector<float> bytes{-7};  // the view starts with something else
  for (int v = 0; v < 4; ++v) {
    const float x = v == 1 || v == 2 ? 1.0f : 0.0f;
    const float y = v >= 2 ? 1.0f : 0.0f;
    bytes.insert(bytes.end(), {x, y, 0, 0, 0, -2, x * 0.25f, y * 0.5f});  // position, normal, UV
  }
  const int view = maker.addView(bytes);
  maker.json["bufferViews"].back()["byteStride"] = 32;
  const auto accessor = [&](int offset, const char* type) {
    return maker.append("accessors", {{"bufferView", view},
                                      {"byteOffset", offset},
                                      {"componentType", kFloat},
                                      {"type", type},
                                      {"count", 4}});
  };
  maker.primitive()["attributes"] = {{"POSITION", accessor(4, "VEC3")},
                                     {"NORMAL", accessor(16, "VEC3")},
                                     {"TEXCOORD_0", accessor(28, "VEC2")}};
  maker.primitive()["material"] = addTexturedMaterial(maker);
  const Scene scene = loaded(maker);
  EXPECT_EQ(scene.vertices.position[2], glm::vec3(1, 1, 0));
  EXPECT_EQ(scene.vertices.normal[3], glm::vec3(0, 0, -1));
  EXPECT_EQ(scene.vertices.uv0[2], glm::vec2(0.25f, 0.5f));
}

TEST(GltfValues, SparseOverABase) {
  GltfMaker maker = square();
  const int indices = maker.addView(std::vector<std::uint16_t>{1, 3});
  const int values = maker.addView(std::vector<float>{5, 6, 7, 8, 9, 10});
  maker.json["accessors"][0]["sparse"] = {{"count", 2},
                                          {"indices", {{"bufferView", indices}, {"componentType", kUshort}}},
                                          {"values", {{"bufferView", values}}}};
  const Scene scene = loaded(maker);
  EXPECT_EQ(scene.vertices.position[0], glm::vec3(0, 0, 0));
  EXPECT_EQ(scene.vertices.position[1], glm::vec3(5, 6, 7));
  EXPECT_EQ(scene.vertices.position[2], glm::vec3(1, 1, 0));
  EXPECT_EQ(scene.vertices.position[3], glm::vec3(8, 9, 10));
}

TEST(GltfValues, SparseOverNothing) {
  GltfMaker maker = square();
  const int indices = maker.addView(Bytes{0, 1, 2, 0});
  const int values = maker.addView(std::vector<float>{-1, -1, -1, 1, 2, 3, 0, 4, 0});
  maker.json["accessors"][0].erase("bufferView");
  maker.json["accessors"][0]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", indices}, {"byteOffset", 1}, {"componentType", kUbyte}}},
      {"values", {{"bufferView", values}, {"byteOffset", 12}}}};
  // The indices too: 0 1 2 0 0 0, the second triangle goes.
  const int sparseIndices = maker.addView(Bytes{1, 2});
  const int sparseValues = maker.addView(std::vector<std::uint16_t>{1, 2});
  maker.json["accessors"][2].erase("bufferView");
  maker.json["accessors"][2]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", sparseIndices}, {"componentType", kUbyte}}},
      {"values", {{"bufferView", sparseValues}}}};
  const Scene scene = loaded(maker);
  ASSERT_EQ(scene.indices, (Indices{0, 1, 2}));
  EXPECT_EQ(scene.vertices.position[0], glm::vec3(0, 0, 0));
  EXPECT_EQ(scene.vertices.position[1], glm::vec3(1, 2, 3));
  EXPECT_EQ(scene.vertices.position[2], glm::vec3(0, 4, 0));
}

TEST(GltfValues, WeldsSoupAndDropsUnused) {
  GltfMaker maker = triangle();
  maker.primitive()["attributes"]["POSITION"] =
      maker.addAccessor<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0}, kFloat, "VEC3", 3);
  EXPECT_EQ(loaded(maker).indices, (Indices{0, 1, 2, 0, 2, 3}));  // flat normals agree, so they weld too
  maker = square();
  maker.primitive()["indices"] = maker.addAccessor<std::uint16_t>({1, 2, 3}, kUshort, "SCALAR", 1);
  EXPECT_EQ(loaded(maker).vertices.position.size(), 3U);
}

TEST(GltfValues, MissingAndBadNormals) {
  GltfMaker maker = triangle();
  EXPECT_EQ(loaded(maker).vertices.normal[1], glm::vec3(0, 0, 1));
  maker = square();
  maker.primitive()["attributes"]["NORMAL"] = maker.addAccessor<float>(
      {0, 0, 0, 0, 0, -3, 0, std::numeric_limits<float>::quiet_NaN(), 1, 1, 0, 0}, kFloat, "VEC3", 3);
  const Scene scene = loaded(maker);
  EXPECT_EQ(scene.vertices.normal[0], glm::vec3(0, 0, 1));
  EXPECT_EQ(scene.vertices.normal[1], glm::vec3(0, 0, -1));
  EXPECT_EQ(scene.vertices.normal[2], glm::vec3(0, 0, 1));
  EXPECT_EQ(scene.vertices.normal[3], glm::vec3(1, 0, 0));
  ASSERT_EQ(scene.warnings.size(), 1U);
  EXPECT_EQ(scene.warnings[0],
            "NORMAL has a zero or not finite value: the faces' is used (mesh 0, primitive 0)");
}

TEST(GltfValues, UvSetsAndTransforms) {
  GltfMaker maker = square();
  maker.json["extensionsUsed"] = {"KHR_texture_transform"};
  maker.primitive()["attributes"]["TEXCOORD_0"] =
      maker.addAccessor<std::uint16_t>({0, 0, 65535, 0, 65535, 65535, 0, 65535}, kUshort, "VEC2", 2, true);
  maker.primitive()["attributes"]["TEXCOORD_1"] =
      maker.addAccessor<float>({5, 6, 7, 8, 9, 10, 11, 12}, kFloat, "VEC2", 2);
  maker.primitive()["material"] = addTexturedMaterial(maker);
  Json& slot = maker.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];

  Scene scene = loaded(maker);
  EXPECT_EQ(scene.vertices.uv0[2], glm::vec2(1, 1));
  EXPECT_TRUE(scene.vertices.uv1.empty());  // no slot reads it
  EXPECT_FALSE(scene.primitives[0].hasUv1);
  EXPECT_FALSE(scene.materials[0].baseColor.hasTransform);

  slot["texCoord"] = 1;
  scene = loaded(maker);
  EXPECT_TRUE(scene.vertices.uv0.empty());
  EXPECT_EQ(scene.vertices.uv1[3], glm::vec2(11, 12));
  EXPECT_TRUE(scene.primitives[0].hasUv1);

  // Scale (2, 3), then a quarter turn (u, v) -> (v, -u), then offset (0.5, 0.25); and back to set 0.
  slot["extensions"]["KHR_texture_transform"] = {
      {"offset", {0.5, 0.25}}, {"rotation", pi / 2}, {"scale", {2, 3}}, {"texCoord", 0}};
  scene = loaded(maker);
  const TextureSlot& made = scene.materials[0].baseColor;
  EXPECT_EQ(made.uvSet, 0);
  EXPECT_TRUE(made.hasTransform);
  expectNear(made.uvTransform[0], glm::vec3(0, 3, 0.5));
  expectNear(made.uvTransform[1], glm::vec3(-2, 0, 0.25));

  slot["extensions"]["KHR_texture_transform"] = {{"texCoord", 2}};
  scene = loaded(maker);
  EXPECT_EQ(scene.materials[0].baseColor.uvSet, 0);
  ASSERT_EQ(scene.warnings.size(), 1U);
  EXPECT_EQ(scene.warnings[0], "TEXCOORD_2 is not supported, TEXCOORD_0 is used (material 0)");
}

TEST(GltfValues, MissingUvsAreZeroWithAWarning) {
  GltfMaker maker = square();
  maker.primitive()["material"] = addTexturedMaterial(maker);
  const Scene scene = loaded(maker);
  EXPECT_EQ(scene.warnings.at(0),
            "a texture needs TEXCOORD_0, which is missing: 0 is used (mesh 0, primitive 0)");
}

TEST(GltfValues, Materials) {
  GltfMaker maker = square();
  maker.json["extensionsUsed"] = {"KHR_materials_emissive_strength", "KHR_materials_unlit"};
  const int texture = maker.addTexture();
  maker.append("samplers", {{"magFilter", 9728}, {"minFilter", 9985}, {"wrapS", 33071}, {"wrapT", 33648}});
  maker.json["textures"][0]["sampler"] = 0;
  maker.append("materials", Json::parse(R"({"name": "full", "alphaMode": "MASK", "alphaCutoff": 0.25,
    "doubleSided": true, "emissiveFactor": [1, 0.5, 0.25],
    "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}},
    "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.75},
    "normalTexture": {"index": 0, "scale": 0.5}, "occlusionTexture": {"index": 0, "strength": 0.25},
    "emissiveTexture": {"index": 0}})"));
  maker.append("materials", {{"alphaMode", "BLEND"},
                             {"extensions", {{"KHR_materials_unlit", Json::object()}}},
                             {"emissiveFactor", {1, 1, 1}},
                             {"normalTexture", {{"index", texture}}}});
  maker.primitive()["material"] = 1;
  const Scene scene = loaded(maker);
  ASSERT_EQ(scene.materials.size(), 2U);
  const Material& full = scene.materials[0];
  EXPECT_EQ(full.name, "full");
  EXPECT_EQ(full.alphaMode, AlphaMode::Mask);
  EXPECT_EQ(full.alphaCutoff, 0.25f);
  EXPECT_TRUE(full.doubleSided);
  EXPECT_EQ(full.emissiveFactor, glm::vec3(8, 4, 2));
  EXPECT_EQ(full.baseColorFactor, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(full.metallicFactor, 0.5f);
  EXPECT_EQ(full.roughnessFactor, 0.75f);
  EXPECT_EQ(full.normalScale, 0.5f);
  EXPECT_EQ(full.occlusionStrength, 0.25f);
  EXPECT_FALSE(full.baseColor.used());
  ASSERT_TRUE(full.normal.used() && full.occlusion.used() && full.emissive.used());
  EXPECT_EQ(full.normal.sampler,
            (Sampler{Filter::Nearest, Filter::Linear, Mip::Nearest, Wrap::Clamp, Wrap::Mirror}));
  const Material& unlit = scene.materials[1];
  EXPECT_TRUE(unlit.unlit);
  EXPECT_EQ(unlit.alphaMode, AlphaMode::Blend);
  EXPECT_FALSE(unlit.normal.used());
  EXPECT_EQ(unlit.emissiveFactor, glm::vec3(0));
  EXPECT_EQ(scene.images.size(), 1U);
  EXPECT_EQ(scene.images[0].image.width, 2);
  EXPECT_TRUE(scene.vertices.tangent.empty());  // the only primitive is unlit
}

TEST(GltfValues, DefaultMaterialIsAppendedOnce) {
  GltfMaker maker = square();
  maker.append("materials", {{"name", "own"}});
  Json other = maker.primitive();
  maker.json["meshes"][0]["primitives"].push_back(other);
  maker.json["meshes"][0]["primitives"].push_back(other);
  maker.json["meshes"][0]["primitives"][0]["material"] = 0;
  const Scene scene = loaded(maker);
  ASSERT_EQ(scene.materials.size(), 2U);
  EXPECT_EQ(scene.primitives[0].material, 0U);
  EXPECT_EQ(scene.primitives[1].material, 1U);
  EXPECT_EQ(scene.primitives[2].material, 1U);
  EXPECT_EQ(scene.materials[1].metallicFactor, 1.0f);
}

GltfMaker normalMapped() {
  GltfMaker maker = square();
  maker.primitive()["attributes"]["TEXCOORD_0"] =
      maker.addAccessor<float>({0, 0, 1, 0, 1, 1, 0, 1}, kFloat, "VEC2", 2);
  maker.append("materials", {{"normalTexture", {{"index", maker.addTexture()}}}});
  maker.primitive()["material"] = 0;
  return maker;
}

TEST(GltfValues, TangentsFromTheFile) {
  GltfMaker maker = normalMapped();
  maker.primitive()["attributes"]["TANGENT"] =
      maker.addAccessor<float>({0, 2, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1, 1, 0, 0, 1}, kFloat, "VEC4", 4);
  Scene scene = loaded(maker);
  EXPECT_EQ(scene.vertices.tangent[0], glm::vec4(0, 1, 0, -1));
  EXPECT_EQ(scene.vertices.tangent[3], glm::vec4(1, 0, 0, 1));

  // They belong to normals: without these they are generated.
  maker.primitive()["attributes"].erase("NORMAL");
  scene = loaded(maker);
  for (const glm::vec4& tangent : scene.vertices.tangent)
    expectNear(glm::abs(glm::vec3(tangent)), glm::vec3(1, 0, 0));
}

TEST(GltfValues, TangentsGeneratedWhereMissingOrBad) {
  GltfMaker maker = normalMapped();
  Scene scene = loaded(maker);
  ASSERT_EQ(scene.vertices.tangent.size(), scene.vertices.position.size());
  expectNear(glm::vec3(scene.vertices.tangent[0]), glm::vec3(1, 0, 0));
  EXPECT_TRUE(scene.warnings.empty());
  maker.primitive()["attributes"]["TANGENT"] =
      maker.addAccessor<float>({0, 1, 0, 1, 0, 0, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1}, kFloat, "VEC4", 4);
  scene = loaded(maker);
  expectNear(glm::vec3(scene.vertices.tangent[0]), glm::vec3(1, 0, 0));
  EXPECT_EQ(scene.warnings.size(), 1U);
}

TEST(GltfValues, AttributesAreFilledAcrossPrimitives) {
  GltfMaker maker = normalMapped();
  const Json plain = square().primitive();
  Json& primitives = maker.json["meshes"][0]["primitives"];
  primitives.insert(primitives.begin(), plain);
  primitives.push_back(plain);
  const Scene scene = loaded(maker);  // the invariants hold: arrays are complete
  EXPECT_EQ(scene.vertices.uv0.size(), 12U);
  EXPECT_EQ(scene.vertices.uv0[6], glm::vec2(1, 1));
  EXPECT_EQ(scene.vertices.uv0[9], glm::vec2(0, 0));
}

// Node 2 is the root of the scene; 0 hangs below 1 below 2; 3 is in no scene.
GltfMaker tree() {
  GltfMaker maker = square();
  maker.json["nodes"] = Json::parse(R"([{"mesh": 0, "name": "leaf", "translation": [0, 0, 1]},
    {"children": [0, 4], "scale": [2, -2, 2]}, {"children": [1], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]},
    {"mesh": 0}, {"mesh": 0, "matrix": [0,1,0,0, -1,0,0,0, 0,0,1,0, 10,20,30,1]}])");
  maker.json["scenes"] = Json::parse(R"([{"nodes": [3]}, {"nodes": [2]}])");
  maker.json["scene"] = 1;
  return maker;
}

TEST(GltfValues, NodesParentsFirst) {
  const Scene scene = loaded(tree());
  ASSERT_EQ(scene.nodes.size(), 4U);
  EXPECT_EQ(scene.nodes[0].parent, kNone);
  EXPECT_EQ(scene.nodes[1].parent, 0U);
  EXPECT_EQ(scene.nodes[2].name, "leaf");
  EXPECT_EQ(scene.nodes[2].parent, 1U);
  EXPECT_EQ(scene.nodes[3].parent, 1U);
  EXPECT_TRUE(scene.nodes[3].hasMatrix);
  ASSERT_EQ(scene.instances.size(), 2U);
  EXPECT_EQ(scene.triangleCount(), 4U);
  EXPECT_EQ(scene.indices.size(), 6U);  // the mesh is there once
  SceneState state;
  evaluate(scene, 0.0, state);
  // (1, 0, 0) of the leaf: +z -> (1,0,1), scaled -> (2,0,2), turned by 90 degrees about z -> (0,2,2).
  const glm::dvec3 p(state.world[2] * glm::dvec4(1, 0, 0, 1));
  EXPECT_NEAR(glm::length(p - glm::dvec3(0, 2, 2)), 0.0, 1e-12);
  EXPECT_TRUE(mirrors(state.world[2]));
  // (1, 0, 0) by the matrix -> (10, 21, 30), scaled -> (20, -42, 60), turned -> (42, 20, 60).
  const glm::dvec3 q(state.world[3] * glm::dvec4(1, 0, 0, 1));
  EXPECT_NEAR(glm::length(q - glm::dvec3(42, 20, 60)), 0.0, 1e-12);
  EXPECT_NEAR(scene.bounds.max.z, 60.0, 1e-12);
}

TEST(GltfValues, WhichSceneIsDrawn) {
  GltfMaker maker = tree();
  maker.json.erase("scene");
  EXPECT_EQ(loaded(maker).nodes.size(), 1U);  // scene 0
  maker.json.erase("scenes");
  EXPECT_EQ(loaded(maker).nodes.size(), 5U);  // all roots
}

TEST(GltfValues, DeepNodesDoNotRecurse) {
  GltfMaker maker = square();
  Json nodes = Json::array();
  constexpr int kDepth = 100000;
  for (int i = 0; i + 1 < kDepth; ++i) nodes.push_back({{"children", {i + 1}}});
  nodes.push_back({{"mesh", 0}});
  maker.json["nodes"] = std::move(nodes);
  EXPECT_EQ(loaded(maker).nodes.size(), static_cast<std::size_t>(kDepth));
}

TEST(GltfValues, CamerasAndLights) {
  GltfMaker maker = square();
  maker.json["extensionsUsed"] = {"KHR_lights_punctual"};
  maker.json["cameras"] = Json::parse(R"([{"type": "perspective", "name": "eye",
    "perspective": {"yfov": 0.5, "znear": 0.1}}, {"type": "orthographic",
    "orthographic": {"xmag": 3, "ymag": -2, "znear": 0, "zfar": 10}},
    {"type": "perspective", "perspective": {"yfov": 3.5, "znear": 0.1, "zfar": 9}}])");
  maker.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::parse(R"([
    {"type": "directional", "intensity": 3, "color": [1, 0.5, 0], "extras": {"tessera_shadow": true}},
    {"type": "point", "range": 7}, {"type": "spot", "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}},
    {"type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.5}}])");
  maker.node(0)["camera"] = 1;
  maker.node(0)["extensions"]["KHR_lights_punctual"]["light"] = 2;
  const Scene scene = loaded(maker);
  ASSERT_EQ(scene.cameras.size(), 3U);
  EXPECT_TRUE(scene.cameras[0].perspective);
  EXPECT_EQ(scene.cameras[0].name, "eye");
  EXPECT_EQ(scene.cameras[0].fovY, 0.5);
  EXPECT_EQ(scene.cameras[0].zFar, 0.0);
  EXPECT_FALSE(scene.cameras[1].perspective);
  EXPECT_EQ(scene.cameras[1].yMag, 2.0);
  EXPECT_EQ(scene.cameras[1].zFar, 10.0);
  EXPECT_LT(scene.cameras[2].fovY, pi);
  EXPECT_EQ(scene.nodes[0].camera, 1U);
  ASSERT_EQ(scene.lights.size(), 4U);
  EXPECT_EQ(scene.lights[0].type, LightType::Directional);
  EXPECT_EQ(scene.lights[0].color, glm::vec3(1, 0.5f, 0));
  EXPECT_EQ(scene.lights[0].intensity, 3.0f);
  EXPECT_TRUE(scene.lights[0].castsShadow);
  EXPECT_EQ(scene.lights[1].type, LightType::Point);
  EXPECT_EQ(scene.lights[1].range, 7.0f);
  EXPECT_FALSE(scene.lights[1].castsShadow);
  EXPECT_EQ(scene.lights[2].type, LightType::Spot);
  EXPECT_EQ(scene.lights[2].innerCone, 0.25f);
  EXPECT_EQ(scene.lights[2].outerCone, 0.5f);
  EXPECT_EQ(scene.nodes[0].light, 2U);
  EXPECT_LT(scene.lights[3].innerCone, scene.lights[3].outerCone);
  EXPECT_EQ(scene.warnings.size(), 2U);  // the wide camera and the hard cone
}

void addAnimation(GltfMaker& maker, int input, int output, const char* path, const char* interpolation) {
  if (!maker.json.contains("animations"))
    maker.json["animations"] = Json::parse(R"([{"channels": [], "samplers": []}])");
  Json& animation = maker.json["animations"][0];
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size()}, {"target", {{"node", 0}, {"path", path}}}});
  animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
}

TEST(GltfValues, Animations) {
  GltfMaker maker = square();
  const int times = maker.addAccessor<float>({0, 1, 3}, kFloat, "SCALAR", 1);
  addAnimation(maker, times, maker.addAccessor<float>({0, 0, 0, 2, 0, 0, 2, 6, 0}, kFloat, "VEC3", 3),
               "translation", "LINEAR");
  addAnimation(maker, times,
               maker.addAccessor<std::int16_t>({0, 0, 0, 32767, 0, 0, 32767, 0, 0, 0, -32768, 0}, kShort,
                                               "VEC4", 4, true),
               "rotation", "STEP");
  const int twoTimes = maker.addAccessor<float>({0, 2}, kFloat, "SCALAR", 1);
  addAnimation(
      maker, twoTimes,
      maker.addAccessor<float>({0, 0, 0, 1, 1, 1, 3, 0, 0, 0, 0, 0, 5, 1, 1, 0, 0, 0}, kFloat, "VEC3", 3),
      "scale", "CUBICSPLINE");
  const Scene scene = loaded(maker);
  ASSERT_EQ(scene.animations.size(), 1U);
  EXPECT_EQ(scene.animations[0].duration, 3.0);
  const auto& channels = scene.animations[0].channels;
  ASSERT_EQ(channels.size(), 3U);
  EXPECT_EQ(channels[0].interpolation, Interpolation::Linear);
  EXPECT_EQ(channels[0].values[2], glm::vec4(2, 6, 0, 0));
  EXPECT_EQ(channels[1].property, AnimatedProperty::Rotation);
  EXPECT_EQ(channels[1].interpolation, Interpolation::Step);
  EXPECT_EQ(channels[1].values[0], glm::vec4(0, 0, 0, 1));
  EXPECT_EQ(channels[1].values[2], glm::vec4(0, 0, -1, 0));
  EXPECT_EQ(channels[2].interpolation, Interpolation::Cubic);
  EXPECT_EQ(channels[2].values.size(), 6U);
  EXPECT_TRUE(scene.animated());
  SceneState state;
  evaluate(scene, 2.0, state);
  // Translation (2,3,0); rotation by 180 degrees about z since time 1; scale (5,1,1) at its last key.
  const glm::dvec3 p(state.world[0] * glm::dvec4(1, 0, 0, 1));
  EXPECT_NEAR(glm::length(p - glm::dvec3(-3, 3, 0)), 0.0, 1e-5);
}

TEST(GltfValues, AnimationsThatCannotBeAppliedAreNamed) {
  GltfMaker maker = square();
  const int times = maker.addAccessor<float>({0, 1, 1, 0.5, 2}, kFloat, "SCALAR", 1);
  const int values =
      maker.addAccessor<float>({0, 0, 0, 1, 0, 0, 9, 9, 9, 9, 9, 9, 2, 0, 0}, kFloat, "VEC3", 3);
  addAnimation(maker, times, values, "translation", "LINEAR");
  addAnimation(maker, times, values, "translation", "STEP");
  addAnimation(maker, times, values, "weights", "LINEAR");
  Scene scene = loaded(maker);
  ASSERT_EQ(scene.animations.at(0).channels.size(), 1U);
  EXPECT_EQ(scene.animations[0].channels[0].times, (std::vector<float>{0, 1, 2}));
  EXPECT_EQ(scene.animations[0].channels[0].values[2], glm::vec4(2, 0, 0, 0));
  EXPECT_EQ(scene.warnings.size(), 3U);
  maker.node(0)["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  scene = loaded(maker);
  EXPECT_TRUE(scene.animations.empty());
}

TEST(GltfValues, FeaturesAtRestAreNamedOnce) {
  GltfMaker maker = square();
  maker.json["extensionsUsed"] = {"KHR_materials_clearcoat", "KHR_materials_unlit"};
  maker.json["skins"] = Json::parse(R"([{"joints": [0]}])");
  maker.json["nodes"] =
      Json::parse(R"([{"mesh": 0, "skin": 0}, {"mesh": 0, "skin": 0}, {"mesh": 0, "skin": 0}])");
  maker.json["scenes"][0]["nodes"] = {0, 1, 2};
  maker.primitive()["targets"] = Json::parse(R"([{"POSITION": 0}])");
  const Json lines{{"mode", 1}, {"attributes", maker.primitive()["attributes"]}};
  maker.json["meshes"][0]["primitives"].push_back(lines);
  EXPECT_EQ(loaded(maker).warnings,
            (std::vector<std::string>{"extension KHR_materials_clearcoat: not applied",
                                      "skins are not applied (node 0 and 2 more)",
                                      "morph targets are not applied (mesh 0, primitive 0)",
                                      "points and lines are not drawn (mesh 0, primitive 1)"}));
}

TEST(GltfValues, IntegersMayBeWrittenAsFloats) {
  GltfMaker maker = square();
  maker.json["accessors"][0]["count"] = 4.0;
  maker.node(0)["mesh"] = 0.0;
  EXPECT_EQ(loaded(maker).triangleCount(), 2U);
}

// --- files beside the scene ---

/// The square as .gltf text whose buffer has the given URI.
std::string textWith(const std::string& uri, std::size_t length) {
  Json json = square().json;
  json["buffers"] = Json::array({Json::object({{"byteLength", length}, {"uri", uri}})});
  return json.dump();
}

TEST(GltfFiles, DataUriAndFilesBesideTheScene) {
  const Bytes bin = square().bin;
  const TempFolder folder;
  const auto check = [&](const std::string& uri) {
    const auto scene = loadGltf(folder.write("scene.gltf", textWith(uri, bin.size())));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->vertices.position[2], glm::vec3(1, 1, 0)) << uri;
  };
  check("data:application/octet-stream;base64," + base64(bin));
  check("data:;base64," + base64(bin));
  std::string percent = "data:application/gltf-buffer,";
  for (const std::uint8_t byte : bin) percent += fmt::format("%{:02X}", byte);
  check(percent);
  folder.write("with space \xc3\xa4.bin", bin);
  check("with%20space%20%C3%A4.bin");
  check("with space \xc3\xa4.bin");
  folder.write("sub/dir/data.bin", bin);
  check("sub/dir/data.bin");
  check("sub/../sub/./dir/data.bin");
  Bytes longer = bin;
  longer.resize(bin.size() + 100, 0xff);
  folder.write("longer.bin", longer);  // a buffer may be a part of its file
  check("longer.bin");
  std::filesystem::create_symlink("longer.bin", folder.path() / "inner.bin");
  check("inner.bin");
}

TEST(GltfFiles, AFolderReachedByALinkIsTheScenesFolder) {
  const Bytes bin = square().bin;
  const TempFolder folder;
  folder.write("real/data.bin", bin);
  folder.write("real/scene.gltf", textWith("data.bin", bin.size()));
  std::filesystem::create_directory_symlink("real", folder.path() / "alias");
  EXPECT_TRUE(loadGltf(folder.path() / "alias" / "scene.gltf"));
}

TEST(GltfFiles, Images) {
  GltfMaker maker = square();
  maker.append("images", {{"uri", "nowhere.png"}});
  addTexturedMaterial(maker);
  maker.primitive()["material"] = 0;
  maker.append("images", {{"uri", "picture.png"}, {"name", "pic"}});
  maker.append("textures", {{"source", 2}});
  maker.append("materials", {{"emissiveTexture", {{"index", 1}}}});
  const TempFolder folder;
  folder.write("picture.png", encodePng({3, 1, {1, 2, 3, 255, 4, 5, 6, 255, 7, 8, 9, 255}}).value());

  auto scene = maker.load(folder);
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->images.size(), 2U);  // the first is used by nothing
  EXPECT_EQ(scene->images[1].name, "pic");
  EXPECT_EQ(scene->images[1].image.width, 3);
  EXPECT_EQ(*scene->images[1].image.at(2, 0), 7);
  EXPECT_EQ(scene->materials[1].emissive.image, 1U);
  EXPECT_EQ(scene->warnings.back(), "an image that no material uses cannot be read (image 0)");

  scene = maker.load(folder, {.loadImages = false, .progress = {}});
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->images.size(), 2U);
  EXPECT_TRUE(scene->images[1].image.pixels.empty());
}

TEST(GltfFiles, ProgressNamesItsSteps) {
  std::vector<std::string> steps;
  ASSERT_TRUE(square().load(TempFolder(),
                            {.loadImages = true, .progress = [&](const auto& s) { steps.push_back(s); }}));
  EXPECT_EQ(steps, (std::vector<std::string>{"file", "materials and nodes", "geometry", "images"}));
}

}  // namespace
}  // namespace tessera::test
