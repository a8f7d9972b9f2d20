#include "engine/image/image.hpp"

#include <cstdlib>
#include <cstring>
#include <memory>

// stb is compiled here once, static, with the two decoders that glTF allows.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wextra"
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_MAX_DIMENSIONS 16384
#define STBI_NO_STDIO
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>
#define STBI_WRITE_NO_STDIO
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

#include "engine/core/file.hpp"

namespace tessera {

static_assert(STBI_MAX_DIMENSIONS == kMaxImageSide);

namespace {

std::size_t byteCount(const Image& image) {
  return static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 4;
}

std::vector<std::uint8_t> withoutAlpha(const Image& image) {
  std::vector<std::uint8_t> rgb(byteCount(image) / 4 * 3);
  for (std::size_t i = 0; i < rgb.size() / 3; ++i) std::memcpy(&rgb[i * 3], &image.pixels[i * 4], 3);
  return rgb;
}

void append(void* context, void* bytes, int size) {
  auto* out = static_cast<std::vector<std::uint8_t>*>(context);
  const auto* first = static_cast<const std::uint8_t*>(bytes);
  out->insert(out->end(), first, first + size);
}

}  // namespace

Image flipped(int width, int height, const std::vector<std::uint8_t>& bottomUp) {
  Image image{width, height, std::vector<std::uint8_t>(bottomUp.size())};
  const auto row = static_cast<std::size_t>(width) * 4;
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
    std::copy_n(
        bottomUp.begin() + static_cast<std::ptrdiff_t>((static_cast<std::size_t>(height) - 1 - y) * row), row,
        image.pixels.begin() + static_cast<std::ptrdiff_t>(y * row));
  return image;
}

Result<Image> decodeImage(std::span<const std::uint8_t> bytes, const std::string& name) {
  if (bytes.empty()) return fail("{}: image has no bytes", name);
  if (bytes.size() > std::size_t{1} << 30)
    return fail("{}: image of {} bytes is too large", name, bytes.size());
  const int length = static_cast<int>(bytes.size());
  int width = 0;
  int height = 0;
  int channels = 0;
  if (stbi_info_from_memory(bytes.data(), length, &width, &height, &channels) == 0)
    return fail("{}: not a PNG or JPEG image ({})", name, stbi_failure_reason());
  if (width <= 0 || height <= 0 || width > kMaxImageSide || height > kMaxImageSide ||
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) > kMaxImagePixels)
    return fail("{}: image of {} x {} pixels is past the limit of {} a side and {} in all", name, width,
                height, kMaxImageSide, kMaxImagePixels);
  std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> pixels(
      stbi_load_from_memory(bytes.data(), length, &width, &height, &channels, 4), &stbi_image_free);
  if (!pixels) return fail("{}: image does not decode ({})", name, stbi_failure_reason());
  Image image{width, height, {}};
  image.pixels.assign(pixels.get(), pixels.get() + byteCount(image));
  return image;
}

Result<Image> readImage(const std::filesystem::path& path) {
  auto bytes = readFile(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return decodeImage(*bytes, path.string());
}

Result<std::vector<std::uint8_t>> encodePng(const Image& image, bool alpha) {
  std::vector<std::uint8_t> out;
  const std::vector<std::uint8_t> rgb = alpha ? std::vector<std::uint8_t>{} : withoutAlpha(image);
  const int channels = alpha ? 4 : 3;
  const void* pixels = alpha ? image.pixels.data() : rgb.data();
  if (stbi_write_png_to_func(&append, &out, image.width, image.height, channels, pixels,
                             image.width * channels) == 0)
    return fail("a PNG of {} x {} pixels cannot be encoded", image.width, image.height);
  return out;
}

Result<std::vector<std::uint8_t>> encodeJpeg(const Image& image, int quality) {
  std::vector<std::uint8_t> out;
  const std::vector<std::uint8_t> rgb = withoutAlpha(image);
  if (stbi_write_jpg_to_func(&append, &out, image.width, image.height, 3, rgb.data(), quality) == 0)
    return fail("a JPEG of {} x {} pixels cannot be encoded", image.width, image.height);
  return out;
}

Result<void> writePng(const std::filesystem::path& path, const Image& image, bool alpha) {
  auto bytes = encodePng(image, alpha);
  if (!bytes) return tl::unexpected(bytes.error());
  return writeFile(path, *bytes);
}

}  // namespace tessera
