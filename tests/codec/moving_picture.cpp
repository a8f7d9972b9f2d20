#include "tests/codec/moving_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tessera::test {

Image movingPicture(int width, int height, int time) {
  Image image{width, height, {}};
  image.pixels.resize(std::size_t{4} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int block = x / 16 * 7 + y / 16 * 13;
      std::uint8_t* to = image.at(x, y);
      to[0] = static_cast<std::uint8_t>(60 + block * 29 % 120 + x % 16 * 2 + time % 16);
      to[1] = static_cast<std::uint8_t>(50 + block * 53 % 130 + y % 16 * 3);
      to[2] = static_cast<std::uint8_t>(40 + block * 71 % 150 + (x + y) % 8);
      to[3] = 255;
    }
  for (int i = 0; i < 36; ++i) {
    std::uint8_t* to = image.at((time * 3 + i % 6) % width, (time * 2 + i / 6) % height);
    std::fill_n(to, 3, std::uint8_t{250});
  }
  return image;
}

YuvImage movingPlanes(int width, int height, Chroma chroma, int time) {
  auto yuv = toYuv(movingPicture(width, height, time), chroma);
  return yuv ? std::move(*yuv) : YuvImage{};
}

double squaredError(const YuvView& a, const YuvView& b) {
  double sum = 0.0;
  double count = 0.0;
  for (int plane = 0; plane < 3; ++plane)
    for (int y = 0; y < a.planeHeight(plane); ++y)
      for (int x = 0; x < a.planeWidth(plane); ++x) {
        const auto i = static_cast<std::size_t>(plane);
        const double d = static_cast<double>(a.at(i, x, y)) - b.at(i, x, y);
        sum += d * d;
        count += 1.0;
      }
  return sum / count;
}

double planesPsnr(const YuvView& a, const YuvView& b) {
  const double error = squaredError(a, b);
  return error == 0.0 ? std::numeric_limits<double>::infinity() : 10.0 * std::log10(255.0 * 255.0 / error);
}

std::vector<EncodedFrame> encodeMoving(VideoEncoder& encoder, const EncoderOptions& options, int frames,
                                       std::uint64_t first) {
  std::vector<EncodedFrame> encoded;
  for (int i = 0; i < frames; ++i) {
    const YuvImage planes = movingPlanes(options.width, options.height, options.chroma, i);
    auto frame = encoder.encode(planes.view(), first + static_cast<std::uint64_t>(i));
    if (!frame) {
      ADD_FAILURE() << frame.error().message;
      return {};
    }
    encoded.push_back(std::move(*frame));
  }
  return encoded;
}

YuvImage copyOf(const YuvView& view) {
  YuvImage copy(view.width, view.height, view.chroma);
  const YuvView to = copy.view();
  for (int plane = 0; plane < 3; ++plane)
    for (int y = 0; y < view.planeHeight(plane); ++y) {
      const auto i = static_cast<std::size_t>(plane);
      std::copy_n(view.planes[i] + static_cast<std::size_t>(y) * view.strides[i], view.planeWidth(plane),
                  copy.bytes.begin() + (to.planes[i] - to.planes[0]) +
                      static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * to.strides[i]));
    }
  return copy;
}

}  // namespace tessera::test
