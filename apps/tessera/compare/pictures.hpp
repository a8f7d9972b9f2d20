// Counts and previews of drawn pictures.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/image/image.hpp"

namespace tessera::app {

/// Pixels with a surface.
std::size_t coveredPixels(const Image& image);
/// Pixels that the reference covers and the test does not.
std::size_t holesOf(const Image& reference, const Image& test);
/// Halved until no side is longer than `largestSide`.
Image halved(const Image& image, int largestSide);
/// Which of a run's frames the page shows: three at most, spread over it.
std::vector<std::size_t> pictureFrames(std::size_t frames);

}  // namespace tessera::app
