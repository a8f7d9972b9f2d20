// Pictures as luma and chroma planes, the form that video coding takes. BT.709, full range: glsl/shared/yuv.h
// has the formulas and where planes lie in memory. No GL.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/core/result.hpp"
#include "engine/image/image.hpp"

namespace tessera {

/// How many texels share a chroma value.
enum class Chroma : std::uint8_t {
  Yuv444,  // each has its own
  Yuv420,  // four: the mean of a square of 2 x 2, sited at its centre
};

/// Side of the square of texels that share a chroma value: 1 or 2.
[[nodiscard]] constexpr int chromaSide(Chroma chroma) { return chroma == Chroma::Yuv420 ? 2 : 1; }
/// "4:4:4" or "4:2:0".
[[nodiscard]] const char* nameOf(Chroma chroma);

/// Planes that someone else owns: luma, blue chroma, red chroma; 8 bits a value, rows from the top.
struct YuvView {
  int width = 0;  // of luma
  int height = 0;
  Chroma chroma = Chroma::Yuv420;
  std::array<const std::uint8_t*, 3> planes{};
  std::array<std::size_t, 3> strides{};  // bytes from a row to the next, at least the plane's width

  [[nodiscard]] std::uint8_t at(std::size_t plane, int x, int y) const {
    return planes[plane][static_cast<std::size_t>(y) * strides[plane] + static_cast<std::size_t>(x)];
  }
  /// Of plane 0 to 2. Sides that are odd are rounded up.
  [[nodiscard]] int planeWidth(int plane) const {
    return plane == 0 ? width : (width + chromaSide(chroma) - 1) / chromaSide(chroma);
  }
  [[nodiscard]] int planeHeight(int plane) const {
    return plane == 0 ? height : (height + chromaSide(chroma) - 1) / chromaSide(chroma);
  }
};

/// Fails for a picture without texels, without one of its planes, or with rows that overlap.
Result<void> checkPlanes(const YuvView& planes);

/// Planes in one piece of memory, where glsl/shared/yuv.h says.
struct YuvImage {
  int width = 0;
  int height = 0;
  Chroma chroma = Chroma::Yuv420;
  std::vector<std::uint8_t> bytes;

  YuvImage() = default;
  /// Black is not what zeroes are: every value is to be written. Sides in [1, kMaxImageSide].
  YuvImage(int width, int height, Chroma chroma);
  [[nodiscard]] YuvView view() const;
};

/// Bytes of such a picture's planes, and the planes where they lie from `bytes` on.
[[nodiscard]] std::size_t yuvBytes(int width, int height, Chroma chroma);
[[nodiscard]] YuvView yuvViewOf(const std::uint8_t* bytes, int width, int height, Chroma chroma);

/// The planes in one piece of memory. `planes` must be as checkPlanes wants them.
YuvImage copyOf(const YuvView& planes);

/// Every value correctly rounded; alpha is left out. Fails for an empty image and for one whose pixels are
/// not width * height * 4 bytes.
Result<YuvImage> toYuv(const Image& image, Chroma chroma);
/// Colours within 1 of what 4:4:4 planes were made from. The texels of a square take its chroma, unfiltered:
/// an atlas' blocks are aligned to such squares, and beyond a block's edge lies another surface. Alpha is
/// 255. Fails as checkPlanes does.
Result<Image> toRgb(const YuvView& planes);

}  // namespace tessera
