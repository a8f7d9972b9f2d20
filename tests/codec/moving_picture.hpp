// Pictures that move like an atlas does: blocks that stay where they are, with shading that changes a little.
#pragma once

#include <vector>

#include "codec/video.hpp"
#include "engine/image/yuv.hpp"

namespace tessera::test {

/// Blocks of 16 texels, each a gradient of its own colours, that drift with `time` (frames), and one speck
/// that moves.
Image movingPicture(int width, int height, int time);
YuvImage movingPlanes(int width, int height, Chroma chroma, int time);

/// Mean squared error over all planes' values, of equal sizes.
double squaredError(const YuvView& a, const YuvView& b);
/// As decibels, of 255.
double planesPsnr(const YuvView& a, const YuvView& b);

/// `frames` of the moving picture, numbered from `first` on.
std::vector<EncodedFrame> encodeMoving(VideoEncoder& encoder, const EncoderOptions& options, int frames,
                                       std::uint64_t first = 1);

/// A copy of what a decoder shows.
YuvImage copyOf(const YuvView& view);

}  // namespace tessera::test
