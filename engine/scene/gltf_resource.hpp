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

/// Bytes that are either owned or a view of the document's BIN chunk. A buffer may have a length and no
/// bytes: extensions use that as a fallback, and what reads it is refused.
struct GltfBuffer {
  std::uint64_t length = 0;
  std::vector<std::uint8_t> owned;
  std::span<const std::uint8_t> bytes;  // exactly `length` long, or empty
};

/// Decodes a data URI (RFC 2397), or reads the file that a relative URI (percent-encoded, RFC
/// 3986) names in `folder`. `what` begins the message of an error: "scene.gltf: buffer 0". Refused: schemes,
/// absolute paths, paths that leave the folder by ".." or a symbolic link, what is not a regular file, and
/// more than `maxBytes`.
Result<std::vector<std::uint8_t>> readUri(const std::string& what, const std::string& uri,
                                          const std::filesystem::path& folder, std::uint64_t maxBytes);

/// All buffers of the document, 4 GiB at most in total. Errors: a missing or short resource;
/// a buffer without URI and BIN chunk has no bytes.
Result<std::vector<GltfBuffer>> readBuffers(const GltfDocument& document,
                                            const std::filesystem::path& folder);

}  // namespace tessera
