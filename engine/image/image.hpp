// 8-bit images: PNG and JPEG in, PNG out. No GL.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.hpp"

namespace tessera {

/// RGBA, 8 bits a channel, rows from the top, no padding. `pixels.size() == width * height * 4`.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;

  [[nodiscard]] const std::uint8_t* at(int x, int y) const {
    return pixels.data() +
           (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) * 4;
  }
  [[nodiscard]] std::uint8_t* at(int x, int y) {
    return pixels.data() +
           (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) * 4;
  }
};

/// The largest side of an image that is decoded; a file that claims more is refused before its pixels are
/// read.
inline constexpr int kMaxImageSide = 16384;
/// The most pixels of one image; guards memory against files that claim 16384 x 16384.
inline constexpr std::size_t kMaxImagePixels = std::size_t{1} << 26;

/// Of rows from the bottom, as GL reads them back; RGBA.
Image flipped(int width, int height, const std::vector<std::uint8_t>& bottomUp);
/// Decodes PNG or JPEG bytes to RGBA. `name` is what an error calls the image.
Result<Image> decodeImage(std::span<const std::uint8_t> bytes, const std::string& name);
/// Reads and decodes a PNG or JPEG file.
Result<Image> readImage(const std::filesystem::path& path);
/// Encodes as PNG (RGBA, or RGB when `alpha` is false).
Result<std::vector<std::uint8_t>> encodePng(const Image& image, bool alpha = false);
/// Encodes as JPEG, quality 1 to 100. Alpha is dropped. Used for previews in report pages only.
Result<std::vector<std::uint8_t>> encodeJpeg(const Image& image, int quality);
/// Writes a PNG to a temporary file beside `path` and renames it: no partial output is left on failure.
Result<void> writePng(const std::filesystem::path& path, const Image& image, bool alpha = false);

}  // namespace tessera
