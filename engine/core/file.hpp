// Whole-file output that never leaves a half-written file behind.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "engine/core/result.hpp"

namespace tessera {

/// Writes to a temporary file beside `path`, then renames it over `path`.
Result<void> writeFile(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
Result<void> writeFile(const std::filesystem::path& path, std::string_view text);
/// Reads a whole file. Fails with a message that names it, also when it is past `maxBytes`.
Result<std::vector<std::uint8_t>> readFile(const std::filesystem::path& path,
                                           std::uint64_t maxBytes = std::uint64_t{1} << 32);

}  // namespace tessera
