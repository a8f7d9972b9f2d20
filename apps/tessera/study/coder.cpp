#include "apps/tessera/study/coder.hpp"

#include <cmath>

namespace tessera::app {

Result<Coder> Coder::create(int width, int height, double framesPerSecond, double mbit) {
  EncoderOptions options;
  options.width = width;
  options.height = height;
  options.chroma = Chroma::Yuv420;
  options.framesPerSecond = framesPerSecond;
  options.bitrate = std::llround(mbit * 1e6);
  options.iFrameInterval = 0;  // each is asked for: resets of an atlas go with them
  auto encoder = VideoEncoder::create(options);
  if (!encoder) return tl::unexpected(encoder.error());
  auto decoder = VideoDecoder::create({.threads = 2});
  if (!decoder) return tl::unexpected(decoder.error());
  Coder coder(std::move(*encoder), std::move(*decoder));
  coder.framesPerSecond_ = framesPerSecond;
  coder.mbit_ = mbit;
  return coder;
}

Result<YuvView> Coder::pass(const YuvView& planes, bool iFrame, std::span<const Region> regions) {
  auto coded = encoder_.encode(planes, ++frames_, {.iFrame = iFrame, .regions = regions});
  if (!coded) return tl::unexpected(coded.error());
  bytes_ += coded->bytes.size();
  Decoded decoded = decoder_.decode(coded->bytes);
  if (!decoded.picture)
    return fail("frame {} was not decoded: {} {}", frames_, nameOf(decoded.reason), decoded.detail);
  return *decoded.picture;
}

double Coder::madeMbit() const {
  return frames_ == 0 ? 0.0
                      : 8e-6 * static_cast<double>(bytes_) * framesPerSecond_ / static_cast<double>(frames_);
}

Result<std::vector<Coder>> codersFor(int width, int height, double framesPerSecond,
                                     const std::vector<double>& bitratesMbit) {
  std::vector<Coder> coders;
  for (const double mbit : bitratesMbit) {
    auto coder = Coder::create(width, height, framesPerSecond, mbit);
    if (!coder) return tl::unexpected(coder.error());
    coders.push_back(std::move(*coder));
  }
  return coders;
}

}  // namespace tessera::app
