#include "engine/scene/gltf_resource.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>

#include "engine/core/file.hpp"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxBufferBytes = std::uint64_t{1} << 32;

/// -1 where a character is not a digit of the base.
int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

int base64Digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  if (c == '/') return 63;
  return -1;
}

Result<std::vector<std::uint8_t>> decodeBase64(const std::string& what, std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  if (text.size() % 4 == 1) return fail("{}: base64 text of {} characters is cut off", what, text.size());
  std::vector<std::uint8_t> out;
  out.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t bits = 0;
  int count = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int digit = base64Digit(text[i]);
    if (digit < 0)
      return fail("{}: base64 character {} has the code {}", what, i, static_cast<unsigned char>(text[i]));
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    count += 6;
    if (count >= 8) {
      count -= 8;
      out.push_back(static_cast<std::uint8_t>(bits >> count));
    }
  }
  return out;
}

Result<std::string> decodePercent(const std::string& what, const std::string& uri) {
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    char c = uri[i];
    if (c == '%') {
      const int high = i + 2 < uri.size() ? hexDigit(uri[i + 1]) : -1;
      const int low = i + 2 < uri.size() ? hexDigit(uri[i + 2]) : -1;
      if (high < 0 || low < 0)
        return fail("{}: URI '{}' has a bad percent code at character {}", what, printable(uri), i);
      c = static_cast<char>(high * 16 + low);
      i += 2;
    }
    out.push_back(c);
  }
  return out;
}

/// "data:[<type>][;base64],<data>" (RFC 2397).
Result<std::vector<std::uint8_t>> decodeDataUri(const std::string& what, const std::string& uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string::npos)
    return fail("{}: data URI '{}' has no comma", what, printable(uri.substr(0, 40)));
  if (std::string_view(uri).substr(0, comma).ends_with(";base64"))
    return decodeBase64(what, std::string_view(uri).substr(comma + 1));
  const auto text = decodePercent(what, uri.substr(comma + 1));
  if (!text) return tl::unexpected(text.error());
  return std::vector<std::uint8_t>(text->begin(), text->end());
}

/// The file that a relative path names, symbolic links resolved, known to lie in `folder`.
Result<fs::path> resolve(const std::string& what, const std::string& name, const fs::path& folder) {
  const std::string shown = printable(name);
  if (name.find('\0') != std::string::npos) return fail("{}: path '{}' has a zero byte", what, shown);
  const std::size_t colon = name.find(':');
  if (colon != std::string::npos && name.find('/') > colon)
    return fail("{}: URI '{}' has a scheme; only data and files beside the scene are read", what, shown);
  const fs::path relative = fs::path(name).lexically_normal();
  if (relative.is_absolute()) return fail("{}: path '{}' is absolute", what, shown);
  if (relative.empty() || *relative.begin() == "..")
    return fail("{}: path '{}' leaves the scene's folder", what, shown);
  std::error_code error;
  const fs::path root = fs::canonical(folder.empty() ? fs::path(".") : folder, error);
  if (error) return fail("{}: folder '{}' cannot be opened ({})", what, folder.string(), error.message());
  const fs::path full = fs::canonical(root / relative, error);
  if (error) return fail("{}: file '{}' cannot be opened ({})", what, shown, error.message());
  const auto [rootEnd, ignored] = std::mismatch(root.begin(), root.end(), full.begin(), full.end());
  if (rootEnd != root.end()) return fail("{}: link '{}' leaves the scene's folder", what, shown);
  if (!fs::is_regular_file(full, error)) return fail("{}: '{}' is not a regular file", what, shown);
  return full;
}

}  // namespace

Result<std::vector<std::uint8_t>> readUri(const std::string& what, const std::string& uri,
                                          const fs::path& folder, std::uint64_t maxBytes) {
  if (uri.starts_with("data:")) return decodeDataUri(what, uri);
  const auto name = decodePercent(what, uri);
  if (!name) return tl::unexpected(name.error());
  const auto path = resolve(what, *name, folder);
  if (!path) return tl::unexpected(path.error());
  auto bytes = readFile(*path, maxBytes);
  if (!bytes) return fail("{}: file {}", what, bytes.error().message);
  return bytes;
}

Result<std::vector<GltfBuffer>> readBuffers(const GltfDocument& document, const fs::path& folder) {
  std::vector<GltfBuffer> buffers;
  const nlohmann::json list = document.json.value("buffers", nlohmann::json::array());
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string what = fmt::format("{}: buffer {}", document.file, i);
    const auto length = list[i]["byteLength"].get<std::uint64_t>();
    GltfBuffer buffer;
    buffer.length = length;
    if (list[i].contains("uri")) {
      auto bytes = readUri(what, list[i]["uri"].get<std::string>(), folder, kMaxBufferBytes);
      if (!bytes) return tl::unexpected(bytes.error());
      total += bytes->size();
      if (total > kMaxBufferBytes)
        return fail("{}: the buffers' {} bytes are past the limit of {}", what, total, kMaxBufferBytes);
      buffer.owned = std::move(*bytes);
      buffer.bytes = buffer.owned;
    } else if (i == 0 && document.hasBin) {
      buffer.bytes = document.bin;
    } else {
      buffers.push_back(std::move(buffer));
      continue;
    }
    if (length > buffer.bytes.size())
      return fail("{}: byteLength {} is past the {} bytes there are", what, length, buffer.bytes.size());
    buffer.bytes = buffer.bytes.first(length);
    buffers.push_back(std::move(buffer));
  }
  return buffers;
}

}  // namespace tessera
