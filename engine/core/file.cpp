#include "engine/core/file.hpp"

#include <fstream>
#include <system_error>

namespace tessera {

Result<void> writeFile(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  const std::filesystem::path partial = path.string() + ".partial";
  std::error_code ignored;
  {
    std::ofstream file(partial, std::ios::binary | std::ios::trunc);
    if (!file) return fail("{}: cannot be created", path.string());
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) {
      std::filesystem::remove(partial, ignored);
      return fail("{}: {} bytes cannot be written", path.string(), bytes.size());
    }
  }
  std::error_code error;
  std::filesystem::rename(partial, path, error);
  if (error) {
    std::filesystem::remove(partial, ignored);
    return fail("{}: cannot be replaced ({})", path.string(), error.message());
  }
  return {};
}

Result<void> writeFile(const std::filesystem::path& path, std::string_view text) {
  return writeFile(path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

Result<std::vector<std::uint8_t>> readFile(const std::filesystem::path& path, std::uint64_t maxBytes) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return fail("{}: is a folder, not a file", path.string());
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return fail("{}: cannot be opened", path.string());
  const auto size = static_cast<std::uint64_t>(file.tellg());
  if (size > maxBytes) return fail("{}: {} bytes are past the limit of {}", path.string(), size, maxBytes);
  std::vector<std::uint8_t> bytes(size);
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!file) return fail("{}: cannot be read to its end", path.string());
  return bytes;
}

}  // namespace tessera
