// The bytes of a .gltf or .glb file as checked JSON and a binary chunk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/core/result.hpp"

namespace tessera {

// json moves without throwing; the check follows its asserts.
// NOLINTNEXTLINE(bugprone-exception-escape)
struct GltfDocument {
  std::string file;                   // what messages call it
  std::vector<std::uint8_t> bytes;    // the whole file; `bin` points into it
  std::span<const std::uint8_t> bin;  // the BIN chunk of a .glb, else empty
  bool hasBin = false;                // a BIN chunk is there, possibly empty
  nlohmann::json json;                // passed checkGltfSchema
  std::vector<std::string> warnings;
};

/// Brackets of the JSON may nest this deep; what reads JSON by recursion relies on it.
inline constexpr int kMaxJsonDepth = 64;

/// Reads and checks a .gltf or .glb file; which of the two is told by its first bytes. Errors: unreadable
/// file, bad container, bad JSON, a version other than 2.x, a required extension that is not applied, and all
/// of checkGltfSchema.
Result<GltfDocument> readGltfDocument(const std::filesystem::path& path);

/// Checks every property that the loader reads: present where glTF 2.0 requires it, of the right type, within
/// its range, and if it is an index, that what it points at exists. Integers written as 3.0 become 3.
/// tinygltf checks little of this: it takes a wrong type as absent, and a large value modulo 2^32. Reports
/// the first violation as "file: accessor 3: bufferView 9 is past 4 bufferViews".
Result<void> checkGltfSchema(const std::string& file, nlohmann::json& json);

/// `text` on one line and at most 120 characters, so that names and addresses out of files are safe to print.
std::string printable(const std::string& text);

}  // namespace tessera
