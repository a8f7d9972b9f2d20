// Any bytes as packets of video, from one stream's beginning on: as they come, and once more under a stamp
// that is right, since a checksum would keep the fuzzer from the decoder itself. Each packet is led by a byte
// of how it is stamped and two of its length.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "codec/video.hpp"

namespace {

/// What is shown is there to its last byte, and what is not shown has a reason.
void check(const tessera::Decoded& decoded) {
  if (!decoded.picture) {
    if (decoded.reason == tessera::NoPicture::None || decoded.detail.empty()) std::abort();
    return;
  }
  const tessera::YuvView& picture = *decoded.picture;
  if (!tessera::checkPlanes(picture)) std::abort();
  unsigned sum = 0;
  for (int plane = 0; plane < 3; ++plane)
    for (int y = 0; y < picture.planeHeight(plane); ++y)
      for (int x = 0; x < picture.planeWidth(plane); ++x)
        sum += picture.at(static_cast<std::size_t>(plane), x, y);
  [[maybe_unused]] static volatile unsigned sink = 0;
  sink = sum;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kPixels = std::size_t{1} << 16U;  // larger pictures take the time that inputs need
  auto decoder = tessera::VideoDecoder::create({.threads = 1, .maxPixels = kPixels});
  if (!decoder) std::abort();
  std::uint64_t last = 0;
  for (std::size_t at = 0; size - at >= 3;) {
    const std::uint8_t kind = data[at];
    const std::size_t length = std::min<std::size_t>(data[at + 1] * 256U + data[at + 2], size - at - 3);
    const std::span<const std::uint8_t> bytes(data + at + 3, length);
    at += 3 + length;
    if (kind % 4 == 0) {
      check(decoder->decode(bytes));
    } else {
      // An I-frame, what follows it, or what follows something else.
      const std::uint64_t frame = last + 1;
      check(decoder->decode(
          tessera::stamped({frame, kind % 4 == 1 ? frame : (kind % 4 == 2 ? last : last - 1)}, bytes)));
      last = frame;
    }
  }
  return 0;
}
