// Files that must be refused in one line that names file, element and value; and files broken at random,
// which may load or not but never crash.
#include <functional>
#include <limits>
#include <random>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "engine/core/file.hpp"
#include "engine/image/image.hpp"
#include "gltf_maker.hpp"
#include "scene_invariants.hpp"

namespace tessera::test {
namespace {

void expectRefused(const Result<Scene>& scene, const std::filesystem::path& file,
                   const std::string& expected) {
  ASSERT_FALSE(scene) << "loads";
  const std::string& message = scene.error().message;
  EXPECT_TRUE(message.starts_with(file.string() + ": " + expected)) << message << "\nexpected: " << expected;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

struct Bad {
  const char* name;
  std::function<void(GltfMaker&)> breakIt;
  const char* expected;  // what the message begins with, after the file
};

const float kNan = std::numeric_limits<float>::quiet_NaN();
const float kInf = std::numeric_limits<float>::infinity();

void positions(GltfMaker& m, const std::vector<float>& values) {
  m.primitive()["attributes"]["POSITION"] = m.addAccessor(values, kFloat, "VEC3", 3);
}

void texture(GltfMaker& m, const Bytes& file) {
  const int source = m.append("images", {{"bufferView", m.addView(file)}, {"mimeType", "image/png"}});
  const int index = m.append("textures", {{"source", source}});
  m.append("materials", {{"emissiveTexture", {{"index", index}}}});
}

/// A PNG that claims `width` x `height` pixels and holds none.
Bytes pngHeader(std::uint32_t width, std::uint32_t height) {
  Bytes png{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13, 'I', 'H', 'D', 'R'};
  for (const std::uint32_t value : {width, height})
    for (int shift = 24; shift >= 0; shift -= 8) png.push_back(static_cast<std::uint8_t>(value >> shift));
  png.insert(png.end(), {8, 6, 0, 0, 0, 0, 0, 0, 0});
  return png;
}

void sparse(GltfMaker& m, const std::vector<std::uint16_t>& indices) {
  const int view = m.addView(indices);
  const int values = m.addView(std::vector<float>(indices.size() * 3, 1.0f));
  m.json["accessors"][0]["sparse"] = {{"count", indices.size()},
                                      {"indices", {{"bufferView", view}, {"componentType", kUshort}}},
                                      {"values", {{"bufferView", values}}}};
}

void animate(GltfMaker& m, const std::vector<float>& times, const std::vector<float>& values,
             const char* path, const char* type, std::size_t components) {
  const int input = m.addAccessor(times, kFloat, "SCALAR", 1);
  const int output = m.addAccessor(values, kFloat, type, components);
  m.json["animations"] = Json::array({Json::object()});
  m.json["animations"][0]["channels"] = Json::parse(R"([{"sampler": 0, "target": {"node": 0}}])");
  m.json["animations"][0]["channels"][0]["target"]["path"] = path;
  m.json["animations"][0]["samplers"] = Json::array({Json::object({{"input", input}, {"output", output}})});
}

void light(GltfMaker& m, const char* text) {
  m.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({Json::parse(text)});
}

const std::vector<Bad> kBad{
    // indices and references
    {"index out of range",
     [](GltfMaker& m) {
       m.primitive()["indices"] = m.addAccessor<std::uint16_t>({0, 1, 912}, kUshort, "SCALAR", 1);
     },
     "mesh 0, primitive 0: index 912 is past 4 vertices"},
    {"index of points out of range",
     [](GltfMaker& m) {
       m.primitive()["mode"] = 0;
       m.primitive()["indices"] = m.addAccessor<std::uint32_t>({4000000000}, kUint, "SCALAR", 1);
     },
     "mesh 0, primitive 0: index 4000000000 is past 4 vertices"},
    {"restart value",
     [](GltfMaker& m) {
       m.primitive()["indices"] = m.addAccessor<std::uint8_t>({0, 1, 2, 255, 0, 1, 2}, kUbyte, "SCALAR", 1);
     },
     "mesh 0, primitive 0: index 255 is the primitive restart value"},
    {"indices of floats",
     [](GltfMaker& m) {
       m.primitive()["indices"] = m.addAccessor<float>({0, 1, 2}, kFloat, "SCALAR", 1);
     },
     "mesh 0, primitive 0: indices: accessor 3 is not of plain unsigned scalars"},
    {"strided indices", [](GltfMaker& m) { m.json["bufferViews"][2]["byteStride"] = 4; },
     "accessor 2: 6 elements of 2 bytes, stride 4, at 0 are past the 12 bytes of bufferView 2"},
    {"strided indices with room",
     [](GltfMaker& m) {
       m.primitive()["indices"] = m.addAccessor<std::uint16_t>({0, 0, 1, 0, 2, 0}, kUshort, "SCALAR", 1);
       m.json["bufferViews"][3]["byteStride"] = 4;
       m.json["accessors"][3]["count"] = 3;
     },
     "mesh 0, primitive 0: indices: bufferView 3 has a byteStride"},
    {"accessor reference", [](GltfMaker& m) { m.primitive()["attributes"]["POSITION"] = 3; },
     "mesh 0, primitive 0: attributes.POSITION 3 is past 3 accessors"},
    {"negative reference", [](GltfMaker& m) { m.primitive()["indices"] = -1; },
     "mesh 0, primitive 0: indices -1 is not in [0, 2147483647]"},
    {"material reference", [](GltfMaker& m) { m.primitive()["material"] = 0; },
     "mesh 0, primitive 0: material 0 is past 0 materials"},
    {"mesh reference", [](GltfMaker& m) { m.node(0)["mesh"] = 1; }, "node 0: mesh 1 is past 1 meshes"},
    {"image reference",
     [](GltfMaker& m) {
       m.append("textures", {{"source", 5}});
     },
     "texture 0: source 5 is past 0 images"},
    {"light reference", [](GltfMaker& m) { m.node(0)["extensions"]["KHR_lights_punctual"]["light"] = 0; },
     "node 0: extensions.KHR_lights_punctual.light 0 is past 0 lights"},
    // positions and attributes
    {"NaN position",
     [](GltfMaker& m) {
       positions(m, {0, 0, 0, 1, 0, 0, 1, kNan, 0, 0, 1, 0});
     },
     "mesh 0, primitive 0: POSITION of vertex 2 is (1, nan, 0)"},
    {"infinite position",
     [](GltfMaker& m) {
       positions(m, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, -kInf});
     },
     "mesh 0, primitive 0: POSITION of vertex 3 is (0, 1, -inf)"},
    {"unequal counts", [](GltfMaker& m) { m.json["accessors"][1]["count"] = 3; },
     "mesh 0, primitive 0: POSITION has 4 elements where others have 3"},
    {"positions of two", [](GltfMaker& m) { m.json["accessors"][0]["type"] = "VEC2"; },
     "mesh 0, primitive 0: POSITION: accessor 0 has 2 components"},
    {"positions of unsigned int", [](GltfMaker& m) { m.json["accessors"][0]["componentType"] = kUint; },
     "mesh 0, primitive 0: POSITION: accessor 0 has componentType 5125"},
    {"colours not normalized",
     [](GltfMaker& m) {
       m.primitive()["attributes"]["COLOR_0"] = m.addAccessor<std::uint8_t>(Bytes(16), kUbyte, "VEC4", 4);
     },
     "mesh 0, primitive 0: COLOR_0: accessor 3 has componentType 5121"},
    // sizes and offsets
    {"absurd count", [](GltfMaker& m) { m.json["accessors"][0]["count"] = 9007199254740992; },
     "accessor 0: 9007199254740992 elements of 12 bytes"},
    {"count past 2^53", [](GltfMaker& m) { m.json["accessors"][0]["count"] = 18446744073709551615ULL; },
     "accessor 0: count 18446744073709551615 is not in [1, 9007199254740992]"},
    {"absurd count of nothing",
     [](GltfMaker& m) {
       m.json["accessors"][0].erase("bufferView");
       m.json["accessors"][0]["count"] = 4000000000;
     },
     "accessor 0: count 4000000000 without bufferView is past the limit of 16777216"},
    {"count 0", [](GltfMaker& m) { m.json["accessors"][0]["count"] = 0; }, "accessor 0: count 0 is not in"},
    {"negative count", [](GltfMaker& m) { m.json["accessors"][0]["count"] = -4; },
     "accessor 0: count -4 is not in"},
    {"bufferView that wraps around 2^64",
     [](GltfMaker& m) { m.json["bufferViews"][0]["byteOffset"] = 18446744073709551600ULL; },
     "bufferView 0: byteOffset 18446744073709551600 is not in"},
    {"bufferView past its buffer", [](GltfMaker& m) { m.json["bufferViews"][0]["byteLength"] = 4096; },
     "bufferView 0: 4096 bytes at 0 are past the 108 bytes of buffer 0"},
    {"bufferView offset at 2^53",
     [](GltfMaker& m) { m.json["bufferViews"][0]["byteOffset"] = 9007199254740992; },
     "bufferView 0: 48 bytes at 9007199254740992 are past the 108 bytes of buffer 0"},
    {"negative offset", [](GltfMaker& m) { m.json["bufferViews"][0]["byteOffset"] = -48; },
     "bufferView 0: byteOffset -48 is not in"},
    {"accessor offset past its view", [](GltfMaker& m) { m.json["accessors"][0]["byteOffset"] = 4; },
     "accessor 0: 4 elements of 12 bytes, stride 12, at 4 are past the 48 bytes of bufferView 0"},
    {"accessor offset at 2^53", [](GltfMaker& m) { m.json["accessors"][0]["byteOffset"] = 9007199254740988; },
     "accessor 0: 4 elements of 12 bytes, stride 12, at 9007199254740988 are past"},
    {"misaligned accessor",
     [](GltfMaker& m) {
       m.json["accessors"][0]["byteOffset"] = 2;
       m.json["accessors"][0]["count"] = 3;
     },
     "accessor 0: byteOffset 2 in bufferView 0 at 0 is not a multiple of 4"},
    {"stride below the element", [](GltfMaker& m) { m.json["bufferViews"][0]["byteStride"] = 8; },
     "accessor 0: byteStride 8 of bufferView 0 is less than the 12 bytes of an element"},
    {"odd stride", [](GltfMaker& m) { m.json["bufferViews"][0]["byteStride"] = 13; },
     "bufferView 0: byteStride 13 is not a multiple of 4"},
    {"buffer longer than its bytes",
     [](GltfMaker& m) { m.json["buffers"] = Json::parse(R"([{"byteLength": 1099511627776}])"); },
     "buffer 0: byteLength 1099511627776 is past the 108 bytes there are"},
    {"buffer without bytes",
     [](GltfMaker& m) {
       m.json["buffers"] = Json::parse(R"([{"byteLength": 108}, {"byteLength": 108}])");
       m.json["bufferViews"][1]["buffer"] = 1;
     },
     "accessor 1: buffer 1 has no data: its uri is missing"},
    {"component type", [](GltfMaker& m) { m.json["accessors"][0]["componentType"] = 5124; },
     "accessor 0: componentType 5124 is not supported"},
    // sparse
    {"sparse index out of range",
     [](GltfMaker& m) {
       sparse(m, {1, 4});
     },
     "accessor 0, sparse: index 4 is past 4 elements"},
    {"sparse indices out of order",
     [](GltfMaker& m) {
       sparse(m, {2, 1});
     },
     "accessor 0, sparse: index 1 does not follow 2"},
    {"sparse count",
     [](GltfMaker& m) {
       sparse(m, {0, 1, 2, 3, 4});
     },
     "accessor 0, sparse: count 5 is past the 4 elements"},
    {"sparse values too short",
     [](GltfMaker& m) {
       sparse(m, {0, 1});
       m.json["accessors"][0]["sparse"]["values"]["byteOffset"] = 12;
     },
     "accessor 0, sparse values: 2 elements of 12 bytes, stride 12, at 12 are past"},
    {"sparse indices of bytes signed",
     [](GltfMaker& m) {
       sparse(m, {0});
       m.json["accessors"][0]["sparse"]["indices"]["componentType"] = 5122;
     },
     "accessor 0, sparse indices: componentType 5122 is not an unsigned integer"},
    // nodes
    {"cyclic nodes",
     [](GltfMaker& m) {
       m.json["nodes"] =
           Json::parse(R"([{"mesh": 0}, {"children": [2]}, {"children": [3]}, {"children": [1, 4]}, {}])");
     },
     "node 2: is its own ancestor"},
    {"a node that is its own child", [](GltfMaker& m) { m.node(0)["children"] = {0}; },
     "node 0: is its own ancestor"},
    {"two parents",
     [](GltfMaker& m) {
       m.json["nodes"] = Json::parse(R"([{"mesh": 0}, {"children": [0]}, {"children": [0]}])");
       m.json["scenes"][0]["nodes"] = {1};
     },
     "node 0: is a child of node 1 and again of node 2"},
    {"child reference", [](GltfMaker& m) { m.node(0)["children"] = {7}; },
     "node 0: children[0] 7 is past 1 nodes"},
    {"scene of a child",
     [](GltfMaker& m) { m.json["nodes"] = Json::parse(R"([{"mesh": 0}, {"children": [0]}])"); },
     "scene 0: node 0 is not a root, its parent is node 1"},
    {"node listed twice",
     [](GltfMaker& m) {
       m.json["scenes"][0]["nodes"] = {0, 0};
     },
     "scene 0: node 0 is listed twice"},
    {"scene reference", [](GltfMaker& m) { m.json["scene"] = 2; }, "scene 2 is past 1 scenes"},
    {"rotation of no length",
     [](GltfMaker& m) {
       m.node(0)["rotation"] = {0, 0, 0, 0};
     },
     "node 0: rotation has length 0"},
    {"perspective matrix",
     [](GltfMaker& m) { m.node(0)["matrix"] = {1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; },
     "node 0: matrix has 0.5 in column 0 of the last row"},
    {"short matrix",
     [](GltfMaker& m) {
       m.node(0)["matrix"] = {1, 0, 0};
     },
     "node 0: matrix has 3 numbers, not 16"},
    {"places beyond float",
     [](GltfMaker& m) {
       m.json["nodes"] =
           Json::parse(R"([{"children": [1], "scale": [3e38, 1, 1]}, {"mesh": 0, "scale": [10, 1, 1]}])");
     },
     "node 'node 1' places a vertex at ("},
    // wrong types in the JSON
    {"nodes is an object", [](GltfMaker& m) { m.json["nodes"] = Json::object(); },
     "nodes is not an array: object"},
    {"a node is a string", [](GltfMaker& m) { m.node(0) = "root"; }, "node 0 is not an object: \"root\""},
    {"mesh is a string", [](GltfMaker& m) { m.node(0)["mesh"] = "0"; },
     "node 0: mesh is not an integer: \"0\""},
    {"mesh is not whole", [](GltfMaker& m) { m.node(0)["mesh"] = 0.5; },
     "node 0: mesh is not an integer: 0.5"},
    {"translation of strings",
     [](GltfMaker& m) {
       m.node(0)["translation"] = {"a", "b", "c"};
     },
     "node 0: translation[0] is not a number: \"a\""},
    {"attributes is an array", [](GltfMaker& m) { m.primitive()["attributes"] = {0}; },
     "mesh 0, primitive 0: attributes is not an object: array"},
    {"no primitives", [](GltfMaker& m) { m.json["meshes"][0].erase("primitives"); },
     "mesh 0: primitives is missing"},
    {"no accessor type", [](GltfMaker& m) { m.json["accessors"][1].erase("type"); },
     "accessor 1: type is missing"},
    {"type is no type", [](GltfMaker& m) { m.json["accessors"][1]["type"] = "VEC5"; },
     "accessor 1: type \"VEC5\" is not one of"},
    {"mode", [](GltfMaker& m) { m.primitive()["mode"] = 7; }, "mesh 0, primitive 0: mode 7 is not in [0, 6]"},
    {"no version", [](GltfMaker& m) { m.json["asset"] = Json::object(); }, "asset.version is missing"},
    {"version 1", [](GltfMaker& m) { m.json["asset"]["version"] = "1.0"; },
     "asset: version '1.0' is not 2.x"},
    {"version of the future", [](GltfMaker& m) { m.json["asset"]["minVersion"] = "2.1"; },
     "asset: minVersion '2.1' is later than 2.0"},
    {"required extension",
     [](GltfMaker& m) { m.json["extensionsRequired"] = {"KHR_draco_mesh_compression"}; },
     "extensionsRequired: KHR_draco_mesh_compression is not supported"},
    // materials, textures, images
    {"factor",
     [](GltfMaker& m) {
       m.append("materials", {{"emissiveFactor", {0, -1, 0}}});
     },
     "material 0: emissiveFactor[1] -1 is not in [0, 1]"},
    {"wrap mode",
     [](GltfMaker& m) {
       texture(m, encodePng({1, 1, Bytes(4)}).value());
       m.append("samplers", {{"wrapS", 10498}});
       m.json["textures"][0]["sampler"] = 0;
     },
     "sampler 0: wrapS 10498 is not a wrap mode"},
    {"missing image",
     [](GltfMaker& m) {
       texture(m, {});
       m.json["images"][0] = {{"uri", "nowhere.png"}};
       m.json["bufferViews"].erase(m.json["bufferViews"].size() - 1);
     },
     "image 0 'nowhere.png': file 'nowhere.png' cannot be opened"},
    {"image of text",
     [](GltfMaker& m) {
       texture(m, {'h', 'e', 'l', 'l', 'o'});
     },
     "image 0: not a PNG or JPEG image"},
    {"huge image", [](GltfMaker& m) { texture(m, pngHeader(2000000000, 2)); },
     "image 0: not a PNG or JPEG image"},
    {"large image", [](GltfMaker& m) { texture(m, pngHeader(16384, 16384)); },
     "image 0: image of 16384 x 16384 pixels is past the limit"},
    {"cut image",
     [](GltfMaker& m) {
       Bytes png = encodePng({64, 64, Bytes(64 * 64 * 4, 7)}).value();
       png.resize(png.size() / 2);
       texture(m, png);
     },
     "image 0: image does not decode"},
    {"image without source",
     [](GltfMaker& m) {
       texture(m, {1});
       m.json["images"][0].erase("bufferView");
     },
     "image 0: uri and bufferView are missing"},
    // paths and data URIs
    {"path that leaves the folder",
     [](GltfMaker& m) {
       m.json["buffers"] = Json::parse(R"([{"byteLength": 108, "uri": "../other/data.bin"}])");
     },
     "buffer 0: path '../other/data.bin' leaves the scene's folder"},
    {"path that leaves later",
     [](GltfMaker& m) {
       m.json["buffers"] = Json::parse(R"([{"byteLength": 108, "uri": "a/../../data.bin"}])");
     },
     "buffer 0: path 'a/../../data.bin' leaves the scene's folder"},
    {"path that leaves in percent codes",
     [](GltfMaker& m) {
       m.json["buffers"] = Json::parse(R"([{"byteLength": 108, "uri": "%2e%2e%2Fdata.bin"}])");
     },
     "buffer 0: path '../data.bin' leaves the scene's folder"},
    {"absolute path",
     [](GltfMaker& m) { m.json["buffers"] = Json::parse(R"([{"byteLength": 4, "uri": "/etc/passwd"}])"); },
     "buffer 0: path '/etc/passwd' is absolute"},
    {"file scheme",
     [](GltfMaker& m) {
       m.json["buffers"] = Json::parse(R"([{"byteLength": 4, "uri": "file:///etc/passwd"}])");
     },
     "buffer 0: URI 'file:///etc/passwd' has a scheme"},
    {"the folder itself",
     [](GltfMaker& m) { m.json["buffers"] = Json::parse(R"([{"byteLength": 4, "uri": "."}])"); },
     "buffer 0: '.' is not a regular file"},
    {"empty path", [](GltfMaker& m) { m.json["buffers"] = Json::parse(R"([{"byteLength": 4, "uri": ""}])"); },
     "buffer 0: path '' leaves the scene's folder"},
    {"percent code",
     [](GltfMaker& m) { m.json["buffers"] = Json::parse(R"([{"byteLength": 4, "uri": "a%2"}])"); },
     "buffer 0: URI 'a%2' has a bad percent code at character 1"},
    {"zero byte in a path",
     [](GltfMaker& m) { m.json["buffers"] = Json::parse(R"([{"byteLength": 4, "uri": "a%00b"}])"); },
     "buffer 0: path 'a b' has a zero byte"},
    {"base64",
     [](GltfMaker& m) {
       m.json["buffers"] = Json::parse(R"([{"byteLength": 4, "uri": "data:;base64,AA*A"}])");
     },
     "buffer 0: base64 character 2 has the code 42"},
    {"short data URI",
     [](GltfMaker& m) {
       m.json["buffers"] = Json::parse(R"([{"byteLength": 108, "uri": "data:;base64,AAAA"}])");
     },
     "buffer 0: byteLength 108 is past the 3 bytes there are"},
    // animations, cameras, lights
    {"negative time",
     [](GltfMaker& m) {
       animate(m, {-1, 1}, {0, 0, 0, 1, 1, 1}, "scale", "VEC3", 3);
     },
     "animation 0, channel 0: time 0 is -1"},
    {"NaN time",
     [](GltfMaker& m) {
       animate(m, {0, kNan}, {0, 0, 0, 1, 1, 1}, "scale", "VEC3", 3);
     },
     "animation 0, channel 0: time 1 is nan"},
    {"infinite value",
     [](GltfMaker& m) {
       animate(m, {0, 1}, {0, 0, 0, 1, kInf, 1}, "scale", "VEC3", 3);
     },
     "animation 0, channel 0: value 1 is inf"},
    {"too few values",
     [](GltfMaker& m) {
       animate(m, {0, 1}, {0, 0, 0}, "translation", "VEC3", 3);
     },
     "animation 0, channel 0: output accessor 4 has 1 values for 2 times"},
    {"rotation of three",
     [](GltfMaker& m) {
       animate(m, {0}, {0, 0, 0}, "rotation", "VEC3", 3);
     },
     "animation 0, channel 0: output accessor 4 does not hold a rotation"},
    {"rotation of no length",
     [](GltfMaker& m) {
       animate(m, {0}, {0, 0, 0, 0}, "rotation", "VEC4", 4);
     },
     "animation 0, channel 0: rotation 0 has length 0"},
    {"channel without sampler",
     [](GltfMaker& m) {
       animate(m, {0}, {0, 0, 0}, "scale", "VEC3", 3);
       m.json["animations"][0]["channels"][0]["sampler"] = 1;
     },
     "animation 0, channel 0: sampler 1 is past 1 samplers"},
    {"camera without its type",
     [](GltfMaker& m) {
       m.append("cameras", {{"type", "perspective"}});
     },
     "camera 0: perspective is missing"},
    {"camera of no height",
     [](GltfMaker& m) {
       m.append("cameras", Json::parse(R"({"type": "perspective", "perspective": {"yfov": 0, "znear": 1}})"));
     },
     "camera 0: perspective.yfov 0 is not in"},
    {"camera planes",
     [](GltfMaker& m) {
       m.append("cameras",
                Json::parse(R"({"type": "perspective", "perspective": {"yfov": 1, "znear": 2, "zfar": 1}})"));
     },
     "camera 0: zfar 1 is not past znear 2"},
    {"light type", [](GltfMaker& m) { light(m, R"({"type": "area"})"); },
     "light 0: type \"area\" is not one of"},
    {"light without spot", [](GltfMaker& m) { light(m, R"({"type": "spot"})"); }, "light 0: spot is missing"},
    {"light that takes", [](GltfMaker& m) { light(m, R"({"type": "point", "intensity": -1})"); },
     "light 0: intensity -1 is not in"},
    // nothing to draw
    {"points only", [](GltfMaker& m) { m.primitive()["mode"] = 0; }, "scene: 0 triangles"},
    {"repeated indices only",
     [](GltfMaker& m) {
       m.primitive()["indices"] = m.addAccessor<std::uint16_t>({1, 1, 1}, kUshort, "SCALAR", 1);
     },
     "scene: 0 triangles"},
    {"empty scene", [](GltfMaker& m) { m.json["scenes"][0]["nodes"] = Json::array(); }, "scene: 0 triangles"},
    {"no positions", [](GltfMaker& m) { m.primitive()["attributes"].erase("POSITION"); },
     "scene: 0 triangles"},
};

TEST(GltfBad, EachIsNamed) {
  const TempFolder folder;
  const std::filesystem::path file = folder.path() / "scene.glb";
  for (const Bad& bad : kBad) {
    SCOPED_TRACE(bad.name);
    GltfMaker maker = square();
    ASSERT_TRUE(maker.load(folder));
    bad.breakIt(maker);
    expectRefused(maker.load(folder), file, bad.expected);
  }
  EXPECT_GE(kBad.size(), 25U);
}

TEST(GltfBad, LinksThatLeaveTheFolder) {
  const TempFolder folder;
  folder.write("secret/data.bin", square().bin);
  GltfMaker maker = square();
  maker.json["buffers"] = Json::parse(R"([{"byteLength": 108, "uri": "data.bin"}])");
  const auto file = folder.write("scene/scene.glb", maker.glb());
  std::filesystem::create_symlink("../secret/data.bin", folder.path() / "scene/data.bin");
  expectRefused(loadGltf(file), file, "buffer 0: link 'data.bin' leaves the scene's folder");
  maker.json["buffers"][0]["uri"] = "folder/data.bin";
  folder.write("scene/scene.glb", maker.glb());
  std::filesystem::create_directory_symlink("../secret", folder.path() / "scene/folder");
  expectRefused(loadGltf(file), file, "buffer 0: link 'folder/data.bin' leaves the scene's folder");
  // A sibling whose name begins like the scene's folder is not inside it.
  folder.write("scene2/data.bin", square().bin);
  std::filesystem::create_directory_symlink("../scene2", folder.path() / "scene/sibling");
  maker.json["buffers"][0]["uri"] = "sibling/data.bin";
  folder.write("scene/scene.glb", maker.glb());
  expectRefused(loadGltf(file), file, "buffer 0: link 'sibling/data.bin' leaves the scene's folder");
}

TEST(GltfBad, APipeIsNotWaitedFor) {
  const TempFolder folder;
  ASSERT_EQ(mkfifo((folder.path() / "pipe.bin").c_str(), 0600), 0);
  GltfMaker maker = square();
  maker.json["buffers"] = Json::parse(R"([{"byteLength": 108, "uri": "pipe.bin"}])");
  expectRefused(maker.load(folder), folder.path() / "scene.glb",
                "buffer 0: 'pipe.bin' is not a regular file");
}

TEST(GltfBad, FilesThatAreNot) {
  const TempFolder folder;
  const auto check = [&](const std::string& name, const Bytes& bytes, const char* expected) {
    const auto file = folder.write(name, bytes);
    expectRefused(loadGltf(file), file, expected);
  };
  const auto text = [](std::string_view s) { return Bytes(s.begin(), s.end()); };
  expectRefused(loadGltf(folder.path() / "none.glb"), folder.path() / "none.glb", "cannot be opened");
  expectRefused(loadGltf(folder.path()), folder.path(), "is a folder, not a file");
  check("empty.gltf", {}, "file has no bytes");
  check("text.gltf", text("hello"), "starts with 68 65 6c 6c, which is neither GLB ('glTF') nor JSON ('{')");
  check("cut.gltf", text("{\"asset\""), "JSON: parse error at line 1");
  check("overflow.gltf", text("{\"a\": 1e999}"), "JSON: number overflow");
  check("utf8.gltf", text("{\"a\": \"\xff\"}"), "JSON: parse error at line 1");
  check("zero.gltf", text(std::string("{\0}", 3)), "JSON: parse error at line 1");
  check("array.gltf", text("[]"), "starts with 5b 5d");
  check("nothing.gltf", text("{}"), "asset is missing");
  check("lines.gltf", text("{\n\n\"asset\": \"a\nb\"}"), "JSON: parse error at line 4");
  check("deep.gltf", text("{\"extras\": " + std::string(200000, '[') + std::string(200000, ']') + "}"),
        "JSON is nested 200001 deep, the limit is 64");
  check("deep_objects.gltf", text([] {
          std::string s = "{\"asset\": {\"version\": \"2.0\"}, \"extras\": ";
          for (int i = 0; i < 100000; ++i) s += "{\"a\":";
          return s;
        }()),
        "JSON is nested 100001 deep, the limit is 64");
}

TEST(GltfBad, GlbContainer) {
  const TempFolder folder;
  const Bytes good = square().glb();
  const auto check = [&](const Bytes& bytes, const char* expected) {
    const auto file = folder.write("scene.glb", bytes);
    expectRefused(loadGltf(file), file, expected);
  };
  const auto with = [&](std::size_t at, std::uint8_t value) {
    Bytes bytes = good;
    bytes[at] = value;
    return bytes;
  };
  check(with(0, 'G'), "starts with 47 6c 54 46, which is neither");
  check(with(4, 1), "GLB header: version 1 is not 2");
  check(with(8, 3), "GLB chunk ");  // length 3 in the low byte: the last chunk is cut
  check(with(11, 0xff), "GLB header: length 427");
  check(with(12, good[12] + 1), "GLB chunk 0: length ");
  check(with(15, 0xff), "GLB chunk 0: 427");
  check(with(16, 'X'), "GLB chunk 0: type 0x4e4f5358 where JSON is needed");
}

TEST(GltfBad, TruncatedAnywhere) {
  const TempFolder folder;
  const Bytes good = square().glb();
  const auto file = folder.path() / "scene.glb";
  for (std::size_t length = 0; length < good.size(); ++length) {
    folder.write("scene.glb", Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)));
    const auto scene = loadGltf(file);
    ASSERT_FALSE(scene) << length;
    ASSERT_TRUE(scene.error().message.starts_with(file.string() + ": ")) << scene.error().message;
    ASSERT_EQ(scene.error().message.find('\n'), std::string::npos);
  }
  // A header that admits to being short: the chunks are cut instead.
  for (std::size_t length = 12; length < good.size(); ++length) {
    Bytes bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length));
    for (unsigned i = 0; i < 4; ++i) bytes[8 + i] = static_cast<std::uint8_t>(length >> (8 * i));
    folder.write("scene.glb", bytes);
    const auto scene = loadGltf(file);
    ASSERT_FALSE(scene) << length;
    const std::string message = scene.error().message.substr(file.string().size());
    // At the end of the JSON chunk it is a GLB without BIN chunk.
    ASSERT_TRUE(message.starts_with(": GLB chunk ") ||
                message.starts_with(": accessor 0: buffer 0 has no data"))
        << message;
  }
}

/// Everything at once: textures, two UV sets, colours, sparse, animation, lights, camera, several nodes.
GltfMaker everything() {
  GltfMaker m = square();
  m.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_texture_transform"};
  m.primitive()["attributes"]["TEXCOORD_0"] =
      m.addAccessor<float>({0, 0, 1, 0, 1, 1, 0, 1}, kFloat, "VEC2", 2);
  m.primitive()["attributes"]["TEXCOORD_1"] =
      m.addAccessor<std::uint16_t>({0, 0, 65535, 0, 1, 2, 3, 4}, kUshort, "VEC2", 2, true);
  m.primitive()["attributes"]["COLOR_0"] = m.addAccessor<std::uint8_t>(
      {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}, kUbyte, "VEC4", 4, true);
  sparse(m, {1, 3});
  animate(m, {0, 1}, {0, 0, 0, 1, 2, 3}, "translation", "VEC3", 3);
  const int image = m.addTexture();
  m.append("materials", {{"normalTexture", {{"index", image}}},
                         {"emissiveTexture", {{"index", image}, {"texCoord", 1}}},
                         {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", image}}}}}});
  m.json["materials"][0]["emissiveTexture"]["extensions"]["KHR_texture_transform"] = {{"rotation", 1}};
  m.primitive()["material"] = 0;
  light(m, R"({"type": "spot", "spot": {"outerConeAngle": 0.5}})");
  m.append("cameras", Json::parse(R"({"type": "perspective", "perspective": {"yfov": 1, "znear": 2}})"));
  m.json["nodes"] = Json::parse(R"([{"mesh": 0, "children": [1, 2]}, {"mesh": 0, "scale": [1, -1, 2]},
    {"camera": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 1,2,3,1],
     "extensions": {"KHR_lights_punctual": {"light": 0}}}])");
  return m;
}

void checkMutant(const std::filesystem::path& file) {
  const auto scene = loadGltf(file);
  if (scene) {
    ASSERT_EQ(brokenInvariant(*scene), "");
    SceneState state;
    evaluate(*scene, 0.5, state);
  } else {
    ASSERT_TRUE(scene.error().message.starts_with(file.string() + ": ")) << scene.error().message;
    ASSERT_EQ(scene.error().message.find('\n'), std::string::npos) << scene.error().message;
  }
}

TEST(GltfBad, RandomBytesNeverCrash) {
  const TempFolder folder;
  const Bytes good = everything().glb();
  const auto file = folder.write("scene.glb", good);
  ASSERT_TRUE(loadGltf(file)) << loadGltf(file).error().message;
  std::mt19937 random(20);
  for (int round = 0; round < 4000; ++round) {
    SCOPED_TRACE(round);
    Bytes bytes = good;
    const int changes = 1 + static_cast<int>(random() % 4);
    for (int i = 0; i < changes; ++i) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    folder.write("scene.glb", bytes);
    ASSERT_NO_FATAL_FAILURE(checkMutant(file));
  }
}

TEST(GltfBad, RandomDigitsNeverCrash) {
  // Mutations that keep the JSON readable go deeper: a digit becomes another, or a number becomes a large
  // one.
  const TempFolder folder;
  const GltfMaker good = everything();
  const std::string text = good.json.dump();
  std::mt19937 random(21);
  static constexpr const char* kNumbers[] = {"-1",         "0",     "2147483647", "4294967295",
                                             "4294967296", "1e300", "0.5",        "255",
                                             "5126",       "null",  "true",       "18446744073709551615"};
  int loaded = 0;
  for (int round = 0; round < 4000; ++round) {
    SCOPED_TRACE(round);
    std::string mutant = text;
    std::size_t at = random() % mutant.size();
    while (mutant[at] < '0' || mutant[at] > '9') at = (at + 1) % mutant.size();
    if (random() % 2 == 0)
      mutant[at] = static_cast<char>('0' + random() % 10);
    else
      mutant.replace(at, 1, kNumbers[random() % std::size(kNumbers)]);
    GltfMaker maker = good;
    maker.json = Json::parse(mutant, nullptr, false);
    if (maker.json.is_discarded()) continue;
    const auto file = folder.write("scene.glb", maker.glb());
    ASSERT_NO_FATAL_FAILURE(checkMutant(file));
    if (loadGltf(file)) ++loaded;
  }
  EXPECT_GT(loaded, 100);
  EXPECT_LT(loaded, 3500);
}

TEST(GltfBad, RandomFloatsNeverCrash) {
  const TempFolder folder;
  const GltfMaker good = everything();
  std::mt19937 random(22);
  static const float kFloats[] = {kNan, kInf, -kInf, 1e38f, -3e38f, 1e-45f, 0.0f, -0.0f, 1e20f, 1e-20f};
  for (int round = 0; round < 2000; ++round) {
    SCOPED_TRACE(round);
    GltfMaker maker = good;
    for (int i = 0; i < 3; ++i) {
      const float value = kFloats[random() % std::size(kFloats)];
      std::memcpy(&maker.bin[random() % (maker.bin.size() / 4) * 4], &value, 4);
    }
    ASSERT_NO_FATAL_FAILURE(checkMutant(folder.write("scene.glb", maker.glb())));
  }
}

}  // namespace
}  // namespace tessera::test
