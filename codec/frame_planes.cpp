#include "codec/frame_planes.hpp"

#include <cstring>

namespace tessera {

namespace {

std::uint8_t* rowOf(AVFrame& frame, int plane, int y) {
  return frame.data[plane] + static_cast<std::ptrdiff_t>(y) * frame.linesize[plane];
}
const std::uint8_t* rowOf(const YuvView& planes, int plane, int y) {
  const auto index = static_cast<std::size_t>(plane);
  return planes.planes[index] + static_cast<std::size_t>(y) * planes.strides[index];
}

}  // namespace

void copyPlanes(const YuvView& planes, AVFrame& frame) {
  const bool interleaved = frame.format == AV_PIX_FMT_NV12;
  for (int plane = 0; plane < (interleaved ? 1 : 3); ++plane)
    for (int y = 0; y < planes.planeHeight(plane); ++y)
      std::memcpy(rowOf(frame, plane, y), rowOf(planes, plane, y),
                  static_cast<std::size_t>(planes.planeWidth(plane)));
  if (!interleaved) return;
  for (int y = 0; y < planes.planeHeight(1); ++y) {
    const std::uint8_t* blue = rowOf(planes, 1, y);
    const std::uint8_t* red = rowOf(planes, 2, y);
    std::uint8_t* to = rowOf(frame, 1, y);
    for (int x = 0; x < planes.planeWidth(1); ++x) {
      *to++ = blue[x];
      *to++ = red[x];
    }
  }
}

std::optional<YuvView> planesOf(const AVFrame& frame) {
  const bool quarter = frame.format == AV_PIX_FMT_YUV420P || frame.format == AV_PIX_FMT_YUVJ420P;
  const bool full = frame.format == AV_PIX_FMT_YUV444P || frame.format == AV_PIX_FMT_YUVJ444P;
  if (!quarter && !full) return std::nullopt;
  YuvView view{.width = frame.width,
               .height = frame.height,
               .chroma = quarter ? Chroma::Yuv420 : Chroma::Yuv444,
               .planes = {},
               .strides = {}};
  for (std::size_t i = 0; i < 3; ++i) {
    if (frame.data[i] == nullptr || frame.linesize[i] < view.planeWidth(static_cast<int>(i)))
      return std::nullopt;
    view.planes[i] = frame.data[i];
    view.strides[i] = static_cast<std::size_t>(frame.linesize[i]);
  }
  return view;
}

}  // namespace tessera
