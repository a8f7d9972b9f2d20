// All files of ../shared/corpora.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <set>
#include <string_view>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/core/file.hpp"
#include "engine/scene/gltf.hpp"
#include "scene_invariants.hpp"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const fs::path kCorpora = fs::path(TESSERA_SHARED_DIR) / "corpora";

std::vector<fs::path> gltfFiles(const fs::path& root) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(root))
    if (entry.path().extension() == ".gltf" || entry.path().extension() == ".glb")
      files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

constexpr std::string_view kNoTriangles = "scene: 0 triangles";

/// The message after "file: "; every message is one line that begins with its file.
std::string reason(const fs::path& file, const Error& error) {
  EXPECT_TRUE(error.message.starts_with(file.string() + ": ")) << error.message;
  EXPECT_EQ(error.message.find('\n'), std::string::npos) << error.message;
  return error.message.substr(std::min(error.message.size(), file.string().size() + 2));
}

TEST(GltfCorpora, AssetGenerator) {
  const fs::path root = kCorpora / "gltf-asset-generator" / "Output";
  if (!fs::exists(root)) GTEST_SKIP() << root << " is absent";
  // By the generator's own tables: files that a 2.0 loader must refuse, and files of points and lines only.
  const std::map<std::string, std::string> refused{
      {"Compatibility_04.gltf", "asset: minVersion '2.1' is later than 2.0"},
      {"Compatibility_05.gltf", "extensionsRequired: FAKE_materials_quantumRendering is not supported"},
  };
  const std::set<std::string> pointsAndLines{"Mesh_PrimitiveMode_00.gltf", "Mesh_PrimitiveMode_01.gltf",
                                             "Mesh_PrimitiveMode_02.gltf", "Mesh_PrimitiveMode_03.gltf",
                                             "Mesh_PrimitiveMode_07.gltf", "Mesh_PrimitiveMode_08.gltf",
                                             "Mesh_PrimitiveMode_09.gltf", "Mesh_PrimitiveMode_10.gltf"};
  const std::string missing = "Textures/MetallicRoughness_Nodes.png";
  ASSERT_FALSE(fs::exists(root / "Node_NegativeScale" / missing));

  std::size_t loaded = 0;
  std::size_t withoutTexture = 0;
  const std::vector<fs::path> files = gltfFiles(root);
  EXPECT_EQ(files.size(), 169U);
  for (const fs::path& file : files) {
    SCOPED_TRACE(file);
    const std::string name = file.filename().string();
    const auto scene = loadGltf(file);
    if (scene) {
      EXPECT_EQ(test::brokenInvariant(*scene), "");
      EXPECT_FALSE(refused.contains(name) || pointsAndLines.contains(name));
      ++loaded;
      continue;
    }
    const std::string why = reason(file, scene.error());
    if (refused.contains(name)) {
      EXPECT_EQ(why, refused.at(name));
    } else if (pointsAndLines.contains(name)) {
      EXPECT_EQ(why, kNoTriangles);
    } else {
      EXPECT_TRUE(why.starts_with("image 1 '" + missing + "': ")) << why;
      EXPECT_TRUE(name.starts_with("Node_NegativeScale_"));
      ++withoutTexture;
      const auto geometry = loadGltf(file, {.loadImages = false, .progress = {}});
      EXPECT_FALSE(geometry) << "a missing image is missing whether or not it is decoded";
    }
  }
  EXPECT_EQ(withoutTexture, 13U);
  EXPECT_EQ(loaded, 169U - 2U - 8U - 13U);
}

// Errors of the Khronos validator after which there is nothing right to draw.
const std::set<std::string> kFatal{
    "ACCESSOR_ANIMATION_INPUT_NEGATIVE",
    "ACCESSOR_INDEX_OOB",
    "ACCESSOR_INDEX_PRIMITIVE_RESTART",
    "ACCESSOR_OFFSET_ALIGNMENT",
    "ACCESSOR_SMALL_BYTESTRIDE",
    "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
    "ACCESSOR_TOO_LONG",
    "ACCESSOR_TOTAL_OFFSET_ALIGNMENT",
    "ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT",
    "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT",
    "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT",
    "ARRAY_TYPE_MISMATCH",
    "ASSET_MIN_VERSION_GREATER_THAN_VERSION",
    "BUFFER_BYTE_LENGTH_MISMATCH",
    "BUFFER_VIEW_TOO_LONG",
    "CAMERA_XMAG_YMAG_ZERO",
    "CAMERA_ZFAR_LEQUAL_ZNEAR",
    "GLB_CHUNK_LENGTH_UNALIGNED",
    "GLB_CHUNK_TOO_BIG",
    "GLB_DUPLICATE_CHUNK",
    "GLB_EMPTY_CHUNK",
    "GLB_INVALID_MAGIC",
    "GLB_INVALID_VERSION",
    "GLB_LENGTH_MISMATCH",
    "GLB_LENGTH_TOO_SMALL",
    "GLB_UNEXPECTED_BIN_CHUNK",
    "GLB_UNEXPECTED_END_OF_CHUNK_DATA",
    "GLB_UNEXPECTED_END_OF_CHUNK_HEADER",
    "GLB_UNEXPECTED_END_OF_HEADER",
    "GLB_UNEXPECTED_FIRST_CHUNK",
    "INVALID_JSON",
    "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT",
    "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT",
    "MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE",
    "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT",
    "NODE_LOOP",
    "NODE_MATRIX_NON_TRS",
    "NODE_PARENT_OVERRIDE",
    "PATTERN_MISMATCH",
    "SCENE_NON_ROOT_NODE",
    "TYPE_MISMATCH",
    "UNDEFINED_PROPERTY",
    "UNKNOWN_ASSET_MAJOR_VERSION",
    "UNRESOLVED_REFERENCE",
    "VALUE_MULTIPLE_OF",
    "VALUE_NOT_IN_RANGE",
};

// Files whose fatal error is not: why.
const std::map<std::string, std::string> kHarmless{
    {"base/data/glb/bom.glb", "a byte order mark before the JSON"},
    {"base/data/json/bom.gltf", "a byte order mark before the JSON"},
};

// Valid files that need what is not there: why they are refused.
const std::map<std::string, std::string> kRefusedThoughValid{
    {"base/data/accessor/unknown_type.gltf", "accessor 0: type \"NotaVEC3\""},
    {"base/data/accessor/valid.gltf", "accessor 0: buffer 0 has no data"},
    {"base/data/asset/min_version_valid.gltf", "asset: minVersion '2.1'"},
    {"base/data/buffer/non_relative_uri.gltf", "buffer 0: URI 'http://example.com/buffer.bin' has a scheme"},
    {"base/data/root/named_objects.gltf", "accessor 0: buffer 0 has no data"},
    {"base/data/root/unused_objects.gltf", "accessor 0: buffer 0 has no data"},
    {"ext/KHR_lights_punctual/data/light/unknown_type.gltf", "light 0: type \"spherical\""},
};

/// Inside an extension that is not applied nothing is read, so nothing there can hurt.
bool inUnappliedExtension(const std::string& pointer) {
  for (const char* applied : {"KHR_lights_punctual", "KHR_materials_unlit", "KHR_materials_emissive_strength",
                              "KHR_texture_transform"})
    if (pointer.find(applied) != std::string::npos) return false;
  return pointer.find("/extensions") != std::string::npos;
}

struct Report {
  std::set<std::string> errors;
  bool fatal = false;
};

Report readReport(const fs::path& file, const std::string& name) {
  const auto text = readFile(file.string() + ".report.json");
  EXPECT_TRUE(text);
  const Json json = Json::parse(text->begin(), text->end());
  Report report;
  for (const Json& message : json["issues"]["messages"]) {
    if (message["severity"] != 0) continue;
    const auto code = message["code"].get<std::string>();
    report.errors.insert(code);
    if (kFatal.contains(code) && !inUnappliedExtension(message.value("pointer", ""))) report.fatal = true;
  }
  if (kHarmless.contains(name)) report.fatal = false;
  return report;
}

enum class Outcome { Loads, NoTriangles, Refused };

// Most of these files hold one property each and no mesh: "0 triangles" is the last check, so a file that
// comes to it has passed all others.
TEST(GltfCorpora, Validator) {
  const fs::path root = kCorpora / "gltf-validator-test" / "test";
  if (!fs::exists(root)) GTEST_SKIP() << root << " is absent";
  std::map<std::pair<bool, Outcome>, int> summary;  // (has errors, outcome) -> files
  int withWarnings = 0;
  const std::vector<fs::path> files = gltfFiles(root);
  EXPECT_EQ(files.size(), 372U);
  for (const fs::path& file : files) {
    const std::string name = fs::relative(file, root).string();
    SCOPED_TRACE(name);
    const Report report = readReport(file, name);
    const auto scene = loadGltf(file);
    const std::string why = scene ? "" : reason(file, scene.error());
    const Outcome outcome = scene                 ? Outcome::Loads
                            : why == kNoTriangles ? Outcome::NoTriangles
                                                  : Outcome::Refused;
    ++summary[{!report.errors.empty(), outcome}];
    if (scene) {
      EXPECT_EQ(test::brokenInvariant(*scene), "");
      if (!scene->warnings.empty()) ++withWarnings;
    }
    if (report.fatal) {
      EXPECT_EQ(outcome, Outcome::Refused) << *report.errors.begin();
    } else if (report.errors.empty()) {
      const auto expected = kRefusedThoughValid.find(name);
      EXPECT_EQ(outcome == Outcome::Refused, expected != kRefusedThoughValid.end()) << why;
      if (expected != kRefusedThoughValid.end()) {
        EXPECT_TRUE(why.starts_with(expected->second)) << why;
      }
    }
  }
  std::cout << "validator corpus, with errors: " << summary[{true, Outcome::Refused}] << " refused, "
            << summary[{true, Outcome::NoTriangles}] << " have no triangles, "
            << summary[{true, Outcome::Loads}] << " load; without: " << summary[{false, Outcome::Refused}]
            << " refused, " << summary[{false, Outcome::NoTriangles}] << " have no triangles, "
            << summary[{false, Outcome::Loads}] << " load; " << withWarnings
            << " of those that load have warnings\n";
  EXPECT_EQ((summary[{true, Outcome::Refused}]), 120);
  EXPECT_EQ((summary[{true, Outcome::NoTriangles}]), 120);
  EXPECT_EQ((summary[{true, Outcome::Loads}]), 3);
  EXPECT_EQ((summary[{false, Outcome::Refused}]), 7);
  EXPECT_EQ((summary[{false, Outcome::NoTriangles}]), 116);
  EXPECT_EQ((summary[{false, Outcome::Loads}]), 6);
}

}  // namespace
}  // namespace tessera
