#include "gltf_maker.hpp"

#include <atomic>
#include <unistd.h>

#include "engine/core/file.hpp"

namespace tessera::test {
namespace {

void put32(Bytes& out, std::size_t value) {
  for (unsigned shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

GltfMaker oneMesh() {
  GltfMaker maker;
  maker.json = Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                               "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{}]}]})");
  return maker;
}

}  // namespace

TempFolder::TempFolder() {
  static std::atomic<int> next{0};
  path_ = std::filesystem::temp_directory_path() / fmt::format("tessera_gltf_{}_{}", getpid(), next++);
  std::filesystem::create_directories(path_);
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path TempFolder::write(const std::string& name, const Bytes& bytes) const {
  std::filesystem::path file = path_ / name;
  std::filesystem::create_directories(file.parent_path());
  if (!writeFile(file, bytes)) throw std::runtime_error("cannot write " + file.string());
  return file;
}

std::filesystem::path TempFolder::write(const std::string& name, std::string_view text) const {
  return write(name, Bytes(text.begin(), text.end()));
}

std::string base64(const Bytes& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      out.push_back(i + k > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63U]);
  }
  return out;
}

int GltfMaker::append(const char* list, const Json& element) {
  json[list].push_back(element);
  return static_cast<int>(json[list].size()) - 1;
}

int GltfMaker::addView(const void* data, std::size_t size) {
  bin.resize((bin.size() + 3) / 4 * 4);
  const std::size_t offset = bin.size();
  bin.resize(offset + size);
  if (size > 0) std::memcpy(&bin[offset], data, size);
  return append("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
}

int GltfMaker::addTexture() {
  const Image image{2, 2, Bytes(16, 255)};
  const int source =
      append("images", {{"bufferView", addView(encodePng(image).value())}, {"mimeType", "image/png"}});
  return append("textures", {{"source", source}});
}

Bytes GltfMaker::glb() const {
  Json document = json;
  if (!document.contains("buffers"))
    document["buffers"] = Json::array({Json::object({{"byteLength", bin.size()}})});
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  Bytes chunk = bin;
  chunk.resize((chunk.size() + 3) / 4 * 4);
  Bytes out{'g', 'l', 'T', 'F'};
  put32(out, 2);
  put32(out, 12 + 8 + text.size() + 8 + chunk.size());
  put32(out, text.size());
  put32(out, 0x4e4f534a);
  out.insert(out.end(), text.begin(), text.end());
  put32(out, chunk.size());
  put32(out, 0x004e4942);
  out.insert(out.end(), chunk.begin(), chunk.end());
  return out;
}

Result<Scene> GltfMaker::load(const TempFolder& folder, const GltfOptions& options) const {
  return loadGltf(folder.write("scene.glb", glb()), options);
}

GltfMaker triangle() {
  GltfMaker maker = oneMesh();
  maker.primitive()["attributes"]["POSITION"] =
      maker.addAccessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, kFloat, "VEC3", 3);
  return maker;
}

GltfMaker square() {
  GltfMaker maker = oneMesh();
  Json& primitive = maker.primitive();
  primitive["attributes"]["POSITION"] =
      maker.addAccessor<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, kFloat, "VEC3", 3);
  primitive["attributes"]["NORMAL"] =
      maker.addAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3", 3);
  primitive["indices"] = maker.addAccessor<std::uint16_t>({0, 1, 2, 0, 2, 3}, kUshort, "SCALAR", 1);
  return maker;
}

}  // namespace tessera::test
