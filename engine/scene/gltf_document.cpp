#include "engine/scene/gltf_document.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include <fmt/ranges.h>

#include "engine/core/file.hpp"

namespace tessera {
namespace {

using Json = nlohmann::json;
using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t kGlbMagic = 0x46546c67;   // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4e4f534a;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004e4942;   // "BIN\0"
constexpr std::size_t kMaxJsonBytes = std::size_t{1} << 28;

constexpr std::array<std::string_view, 5> kAppliedExtensions{
    "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_unlit", "KHR_mesh_quantization",
    "KHR_texture_transform"};

std::uint32_t littleEndian32(Bytes bytes, std::size_t at) {
  return std::uint32_t{bytes[at]} | std::uint32_t{bytes[at + 1]} << 8 | std::uint32_t{bytes[at + 2]} << 16 |
         std::uint32_t{bytes[at + 3]} << 24;
}

/// Splits a GLB (glTF 2.0 sec. 4.4) into its JSON and BIN chunks; sets document.bin and returns the JSON.
Result<Bytes> splitGlb(GltfDocument& document) {
  const std::string& file = document.file;
  Bytes bytes = document.bytes;
  if (bytes.size() < 12) return fail("{}: GLB header: {} bytes are less than 12", file, bytes.size());
  const std::uint32_t version = littleEndian32(bytes, 4);
  const std::uint32_t length = littleEndian32(bytes, 8);
  if (version != 2) return fail("{}: GLB header: version {} is not 2", file, version);
  if (length > bytes.size())
    return fail("{}: GLB header: length {} is past the {} bytes of the file", file, length, bytes.size());
  if (length < 12) return fail("{}: GLB header: length {} is less than 12", file, length);
  if (length < bytes.size())
    document.warnings.push_back(
        fmt::format("GLB header: {} bytes after its length are not read", bytes.size() - length));
  bytes = bytes.first(length);

  Bytes json;
  std::size_t at = 12;
  for (int chunk = 0; at < bytes.size(); ++chunk) {
    if (bytes.size() - at < 8)
      return fail("{}: GLB chunk {}: header is cut off after {} bytes", file, chunk, bytes.size() - at);
    const std::uint32_t size = littleEndian32(bytes, at);
    const std::uint32_t type = littleEndian32(bytes, at + 4);
    at += 8;
    if (size > bytes.size() - at)
      return fail("{}: GLB chunk {}: {} bytes are past the {} that are left", file, chunk, size,
                  bytes.size() - at);
    if (size % 4 != 0) return fail("{}: GLB chunk {}: length {} is not a multiple of 4", file, chunk, size);
    const Bytes content = bytes.subspan(at, size);
    at += size;
    if ((type == kJsonChunk) != (chunk == 0))
      return fail("{}: GLB chunk {}: type {:#010x} where {}", file, chunk, type,
                  chunk == 0 ? "JSON is needed" : "JSON must not follow");
    if (type == kJsonChunk) json = content;
    if (type == kBinChunk) {
      if (document.hasBin || chunk != 1) return fail("{}: GLB chunk {}: BIN must be chunk 1", file, chunk);
      document.bin = content;
      document.hasBin = true;
    }
  }
  if (json.empty()) return fail("{}: GLB chunk 0: no JSON", file);
  return json;
}

/// The deepest nesting of brackets outside strings. Counted before parsing: parsers and destructors may
/// recurse.
int nesting(Bytes text) {
  int depth = 0;
  int deepest = 0;
  bool inString = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = static_cast<char>(text[i]);
    if (inString) {
      if (c == '\\') ++i;
      if (c == '"') inString = false;
    } else if (c == '"') {
      inString = true;
    } else if (c == '{' || c == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return deepest;
}

/// "[json.exception.parse_error.101] parse error at ..." without the bracket.
std::string withoutTag(const std::string& message) {
  const std::size_t end = message.find("] ");
  return printable(end == std::string::npos ? message : message.substr(end + 2));
}

Result<Json> parseJson(const std::string& file, Bytes text) {
  if (text.size() > kMaxJsonBytes)
    return fail("{}: JSON of {} bytes is past the limit of {}", file, text.size(), kMaxJsonBytes);
  if (const int depth = nesting(text); depth > kMaxJsonDepth)
    return fail("{}: JSON is nested {} deep, the limit is {}", file, depth, kMaxJsonDepth);
  try {
    return Json::parse(text.begin(), text.end());
  } catch (const Json::exception& error) {
    return fail("{}: JSON: {}", file, withoutTag(error.what()));
  }
}

/// "2.0" -> 2, 0. False if the text is not two numbers around a dot.
bool parseVersion(const std::string& text, int& major, int& minor) {
  const std::size_t dot = text.find('.');
  const auto digits = [](std::string_view s) {
    return !s.empty() && s.size() < 6 && s.find_first_not_of("0123456789") == std::string_view::npos;
  };
  if (dot == std::string::npos || !digits(std::string_view(text).substr(0, dot)) ||
      !digits(std::string_view(text).substr(dot + 1)))
    return false;
  major = std::stoi(text.substr(0, dot));
  minor = std::stoi(text.substr(dot + 1));
  return true;
}

/// Runs before the schema, so that a glTF 1.0 file is told what it is; what has the wrong type is left to the
/// schema.
Result<void> checkVersion(const std::string& file, const Json& json) {
  const Json& asset = json.contains("asset") ? json["asset"] : json;
  int major = 0;
  int minor = 0;
  for (const char* key : {"version", "minVersion"}) {
    if (!asset.contains(key) || !asset[key].is_string()) continue;
    const auto text = asset[key].get<std::string>();
    if (!parseVersion(text, major, minor) || major != 2)
      return fail("{}: asset: {} '{}' is not 2.x", file, key, printable(text));
    if (key == std::string_view("minVersion") && minor > 0)
      return fail("{}: asset: minVersion '{}' is later than 2.0", file, printable(text));
  }
  return {};
}

bool applied(const std::string& extension) {
  return std::ranges::find(kAppliedExtensions, extension) != kAppliedExtensions.end();
}

Result<void> checkExtensions(GltfDocument& document) {
  const Json none = Json::array();
  const auto list = [&](const char* key) -> const Json& {
    return document.json.contains(key) ? document.json[key] : none;
  };
  for (const Json& extension : list("extensionsRequired")) {
    const auto name = extension.get<std::string>();
    if (!applied(name))
      return fail("{}: extensionsRequired: {} is not supported", document.file, printable(name));
  }
  for (const Json& extension : list("extensionsUsed")) {
    const auto name = extension.get<std::string>();
    if (!applied(name))
      document.warnings.push_back(fmt::format("extension {}: not applied", printable(name)));
  }
  return {};
}

}  // namespace

std::string printable(const std::string& text) {
  std::string out = text.substr(0, 120);
  // A cut must not leave half of a UTF-8 sequence behind.
  if (text.size() > out.size()) {
    while (!out.empty() && (static_cast<unsigned char>(out.back()) & 0xc0) == 0x80) out.pop_back();
    if (!out.empty() && static_cast<unsigned char>(out.back()) >= 0xc0) out.pop_back();
    out += "...";
  }
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return out;
}

Result<GltfDocument> readGltfDocument(const std::filesystem::path& path) {
  GltfDocument document;
  document.file = path.string();
  auto bytes = readFile(path);
  if (!bytes) return tl::unexpected(bytes.error());
  document.bytes = std::move(*bytes);
  if (document.bytes.empty()) return fail("{}: file has no bytes", document.file);

  Bytes text = document.bytes;
  if (text.size() >= 4 && littleEndian32(text, 0) == kGlbMagic) {
    auto json = splitGlb(document);
    if (!json) return tl::unexpected(json.error());
    text = *json;
  } else if (const auto first = std::ranges::find_if(
                 text,
                 [](std::uint8_t c) { return std::strchr(" \t\r\n\xef\xbb\xbf", c) == nullptr || c == 0; });
             first == text.end() || *first != '{') {
    return fail("{}: starts with {:02x}, which is neither GLB ('glTF') nor JSON ('{{')", document.file,
                fmt::join(text.first(std::min<std::size_t>(text.size(), 4)), " "));
  }
  auto json = parseJson(document.file, text);
  if (!json) return tl::unexpected(json.error());
  document.json = std::move(*json);
  if (auto ok = checkVersion(document.file, document.json); !ok) return tl::unexpected(ok.error());
  if (auto ok = checkGltfSchema(document.file, document.json); !ok) return tl::unexpected(ok.error());
  if (auto ok = checkExtensions(document); !ok) return tl::unexpected(ok.error());
  return document;
}

}  // namespace tessera
