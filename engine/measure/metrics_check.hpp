// What every metric asks of its pair of images; not part of the API.
#pragma once

#include <cstddef>

#include "engine/core/result.hpp"
#include "engine/image/image.hpp"

namespace tessera {

inline Result<void> checkPair(const char* metric, const Image& reference, const Image& test) {
  if (reference.width <= 0 || reference.height <= 0)
    return fail("{}: the reference image is empty ({} x {})", metric, reference.width, reference.height);
  if (reference.width != test.width || reference.height != test.height)
    return fail("{}: the reference is {} x {} pixels, the test image {} x {}", metric, reference.width,
                reference.height, test.width, test.height);
  const std::size_t bytes =
      static_cast<std::size_t>(reference.width) * static_cast<std::size_t>(reference.height) * 4;
  if (reference.pixels.size() != bytes || test.pixels.size() != bytes)
    return fail("{}: images of {} x {} pixels need {} bytes, the reference holds {} and the test image {}",
                metric, reference.width, reference.height, bytes, reference.pixels.size(),
                test.pixels.size());
  return {};
}

}  // namespace tessera
