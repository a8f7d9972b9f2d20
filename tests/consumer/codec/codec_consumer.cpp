// One grey frame there and back, by the installed package's headers and libraries.
#include <algorithm>
#include <codec/video.hpp>
#include <cstdio>

int main() {
  tessera::EncoderOptions options;
  options.width = options.height = 64;
  auto encoder = tessera::VideoEncoder::create(options);
  auto decoder = tessera::VideoDecoder::create();
  if (!encoder || !decoder) {
    std::fprintf(stderr, "%s\n", (encoder ? decoder.error() : encoder.error()).message.c_str());
    return 1;
  }
  tessera::YuvImage grey(64, 64, options.chroma);
  std::fill(grey.bytes.begin(), grey.bytes.end(), std::uint8_t{128});
  const auto frame = encoder->encode(grey.view(), 1);
  if (!frame) {
    std::fprintf(stderr, "%s\n", frame.error().message.c_str());
    return 1;
  }
  const tessera::Decoded decoded = decoder->decode(frame->bytes);
  if (!decoded.picture || decoded.picture->width != 64 || decoded.picture->at(0, 63, 63) != 128) {
    std::fprintf(stderr, "%s: %s\n", tessera::nameOf(decoded.reason), decoded.detail.c_str());
    return 1;
  }
  return 0;
}
