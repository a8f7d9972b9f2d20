#include "engine/image/yuv.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "glsl/shared/yuv.h"

namespace tessera {

namespace {

std::size_t startOf(int plane, int width, int height, Chroma chroma) {
  return std::size_t{4} * glsl::yuvPlane(static_cast<std::uint32_t>(plane), static_cast<std::uint32_t>(width),
                                         static_cast<std::uint32_t>(height),
                                         static_cast<std::uint32_t>(chromaSide(chroma)));
}

}  // namespace

const char* nameOf(Chroma chroma) { return chroma == Chroma::Yuv420 ? "4:2:0" : "4:4:4"; }

std::size_t yuvBytes(int width, int height, Chroma chroma) { return startOf(3, width, height, chroma); }

YuvView yuvViewOf(const std::uint8_t* bytes, int width, int height, Chroma chroma) {
  YuvView view{.width = width, .height = height, .chroma = chroma, .planes = {}, .strides = {}};
  for (int i = 0; i < 3; ++i) {
    const auto plane = static_cast<std::size_t>(i);
    view.planes[plane] = bytes + startOf(i, width, height, chroma);
    view.strides[plane] = std::size_t{4} * glsl::yuvStride(static_cast<std::uint32_t>(view.planeWidth(i)));
  }
  return view;
}

Result<void> checkPlanes(const YuvView& planes) {
  if (planes.width < 1 || planes.height < 1 || planes.width > kMaxImageSide || planes.height > kMaxImageSide)
    return fail("planes of {} x {}: sides must be in [1, {}]", planes.width, planes.height, kMaxImageSide);
  for (int i = 0; i < 3; ++i) {
    const auto plane = static_cast<std::size_t>(i);
    if (planes.planes[plane] == nullptr) return fail("plane {} of a picture is missing", i);
    if (planes.strides[plane] < static_cast<std::size_t>(planes.planeWidth(i)))
      return fail("plane {}: {} bytes from row to row are less than its {} texels", i, planes.strides[plane],
                  planes.planeWidth(i));
  }
  return {};
}

YuvImage::YuvImage(int wide, int high, Chroma sharing)
    : width(wide), height(high), chroma(sharing), bytes(yuvBytes(wide, high, sharing)) {
  assert(wide >= 1 && high >= 1 && wide <= kMaxImageSide && high <= kMaxImageSide);
}

YuvView YuvImage::view() const { return yuvViewOf(bytes.data(), width, height, chroma); }

YuvImage copyOf(const YuvView& planes) {
  YuvImage copy(planes.width, planes.height, planes.chroma);
  const YuvView there = copy.view();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto offset = static_cast<std::size_t>(there.planes[i] - there.planes[0]);
    const auto plane = static_cast<int>(i);
    for (int y = 0; y < planes.planeHeight(plane); ++y) {
      const auto row = static_cast<std::size_t>(y);
      std::memcpy(copy.bytes.data() + offset + row * there.strides[i],
                  planes.planes[i] + row * planes.strides[i],
                  static_cast<std::size_t>(planes.planeWidth(plane)));
    }
  }
  return copy;
}

Result<YuvImage> toYuv(const Image& image, Chroma chroma) {
  if (image.width < 1 || image.height < 1 || image.width > kMaxImageSide || image.height > kMaxImageSide)
    return fail("an image of {} x {}: sides must be in [1, {}]", image.width, image.height, kMaxImageSide);
  const std::size_t wanted =
      std::size_t{4} * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (image.pixels.size() != wanted)
    return fail("an image of {} x {} has {} bytes of pixels, not {}", image.width, image.height,
                image.pixels.size(), wanted);
  YuvImage yuv(image.width, image.height, chroma);
  const YuvView view = yuv.view();
  std::uint8_t* const start = yuv.bytes.data();
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* from = image.at(0, y);
    std::uint8_t* row = start + static_cast<std::size_t>(y) * view.strides[0];
    for (int x = 0; x < image.width; ++x, from += 4)
      row[x] = static_cast<std::uint8_t>(glsl::lumaOf(from[0], from[1], from[2]));
  }
  const int side = chromaSide(chroma);
  for (int y = 0; y < view.planeHeight(1); ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * view.strides[1];
    std::uint8_t* blue = start + (view.planes[1] - view.planes[0]) + row;
    std::uint8_t* red = start + (view.planes[2] - view.planes[0]) + row;
    for (int x = 0; x < view.planeWidth(1); ++x) {
      std::array<int, 3> sum{};
      for (int v = 0; v < side; ++v)
        for (int u = 0; u < side; ++u) {
          // Where a side is odd, the last texel counts twice.
          const std::uint8_t* from =
              image.at(std::min(x * side + u, image.width - 1), std::min(y * side + v, image.height - 1));
          for (std::size_t i = 0; i < 3; ++i) sum[i] += from[i];
        }
      blue[x] = static_cast<std::uint8_t>(glsl::blueChromaOf(sum[0], sum[1], sum[2], side * side));
      red[x] = static_cast<std::uint8_t>(glsl::redChromaOf(sum[0], sum[1], sum[2], side * side));
    }
  }
  return yuv;
}

Result<Image> toRgb(const YuvView& planes) {
  if (auto good = checkPlanes(planes); !good) return tl::unexpected(good.error());
  Image image{planes.width, planes.height, {}};
  image.pixels.resize(std::size_t{4} * static_cast<std::size_t>(planes.width) *
                      static_cast<std::size_t>(planes.height));
  const int side = chromaSide(planes.chroma);
  for (int y = 0; y < planes.height; ++y) {
    const auto row = static_cast<std::size_t>(y);
    const std::uint8_t* luma = planes.planes[0] + row * planes.strides[0];
    const std::uint8_t* blue = planes.planes[1] + row / static_cast<std::size_t>(side) * planes.strides[1];
    const std::uint8_t* red = planes.planes[2] + row / static_cast<std::size_t>(side) * planes.strides[2];
    std::uint8_t* to = image.at(0, y);
    for (int x = 0; x < planes.width; ++x, to += 4) {
      const int square = x / side;
      to[0] = static_cast<std::uint8_t>(glsl::redOf(luma[x], red[square]));
      to[1] = static_cast<std::uint8_t>(glsl::greenOf(luma[x], blue[square], red[square]));
      to[2] = static_cast<std::uint8_t>(glsl::blueOf(luma[x], blue[square]));
      to[3] = 255;
    }
  }
  return image;
}

}  // namespace tessera
