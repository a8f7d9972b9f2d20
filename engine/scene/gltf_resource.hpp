// The bytes behind the URIs and buffer views of a glTF file. No file outside the scene's folder is ever
// opened.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.hpp"
#include "engine/scene/gltf_document.hpp"

namespace tessera {

/// Bytes that are either owned or a view of the document's BIN chunk.
struct GltfBuffer {
  std::vector<std::uint8_t> owned;
  std::span<const std::uint8_t> bytes;  // exactly byteLength long
};

/// Decodes a "data:[<type>];base64,<data>" URI, or reads the file that a relative URI (percent-encoded, RFC
/// 3986) names in `folder`. `what` begins the message of an error: "scene.gltf: buffer 0". Refused: schemes,
/// absolute paths, paths that leave the folder by ".." or a symbolic link, what is not a regular file, and
/// more than `maxBytes`.
Result<std::vector<std::uint8_t>> readUri(const std::string& what, const std::string& uri,
                                          const std::filesystem::path& folder, std::uint64_t maxBytes);

/// All buffers of the document, 4 GiB at most in total. Errors: a missing or short resource.
Result<std::vector<GltfBuffer>> readBuffers(const GltfDocument& document,
                                            const std::filesystem::path& folder);

}  // namespace tessera
