// Planes to libavcodec's frames and back. For codec/*.cpp only.
#pragma once

#include <optional>

#include "codec/libav.hpp"
#include "engine/image/yuv.hpp"

namespace tessera {

/// Copies planes into a frame of their size, in AV_PIX_FMT_YUV420P, _YUV444P or, with the chroma planes
/// interleaved, _NV12.
void copyPlanes(const YuvView& planes, AVFrame& frame);

/// The planes of a frame of 8-bit 4:2:0 or 4:4:4, where they lie; nothing for another format.
std::optional<YuvView> planesOf(const AVFrame& frame);

}  // namespace tessera
