// Small glTF files made in code, each valid until a test breaks it.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/scene/gltf.hpp"

namespace tessera::test {

using Json = nlohmann::json;
using Bytes = std::vector<std::uint8_t>;

inline constexpr int kByte = 5120;
inline constexpr int kUbyte = 5121;
inline constexpr int kShort = 5122;
inline constexpr int kUshort = 5123;
inline constexpr int kUint = 5125;
inline constexpr int kFloat = 5126;

/// A folder of its own that goes with the object.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, const Bytes& bytes) const;
  std::filesystem::path write(const std::string& name, std::string_view text) const;

 private:
  std::filesystem::path path_;
};

std::string base64(const Bytes& bytes);

// json moves without throwing; the check follows its asserts.
// NOLINTNEXTLINE(bugprone-exception-escape)
struct GltfMaker {
  Json json;
  Bytes bin;

  /// Appends bytes at a multiple of 4; returns the new buffer view.
  int addView(const void* data, std::size_t size);
  template <class T>
  int addView(const std::vector<T>& values) {
    return addView(values.data(), values.size() * sizeof(T));
  }
  /// A tightly packed accessor; its element size must be a multiple of 4 where glTF asks for that.
  template <class T>
  int addAccessor(const std::vector<T>& values, int componentType, const char* type, std::size_t components,
                  bool normalized = false) {
    Json accessor{{"bufferView", addView(values)},
                  {"componentType", componentType},
                  {"type", type},
                  {"count", values.size() / components}};
    if (normalized) accessor["normalized"] = true;
    return append("accessors", accessor);
  }
  int append(const char* list, const Json& element);
  /// A 2 x 2 PNG in a buffer view, a texture of it; returns the texture.
  int addTexture();
  Json& primitive(std::size_t mesh = 0) { return json["meshes"][mesh]["primitives"][0]; }
  Json& node(std::size_t i) { return json["nodes"][i]; }

  /// The file as .glb bytes; buffer 0 is the BIN chunk with the length of `bin`.
  [[nodiscard]] Bytes glb() const;
  /// Writes it as scene.glb into `folder` and loads it.
  [[nodiscard]] Result<Scene> load(const TempFolder& folder, const GltfOptions& options = {}) const;
  [[nodiscard]] Result<Scene> load() const { return load(TempFolder()); }
};

/// One node, one mesh, one primitive: the triangle (0,0,0), (1,0,0), (0,1,0), no indices, no normals, no
/// material.
GltfMaker triangle();
/// The unit square in xy as two triangles over four vertices with normals +z: indices 0 1 2, 0 2 3 (unsigned
/// short), accessors 0 POSITION, 1 NORMAL, 2 indices.
GltfMaker square();

}  // namespace tessera::test
