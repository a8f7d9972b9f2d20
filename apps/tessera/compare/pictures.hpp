// Counts and previews of drawn pictures.
#pragma once

#include <cstddef>
#include <vector>

#include "apps/tessera/report/report.hpp"
#include "atlas/gatherer.hpp"
#include "engine/image/image.hpp"

namespace tessera::app {

/// Pixels with a surface.
std::size_t coveredPixels(const Image& image);
/// Pixels that the reference covers and the test does not.
std::size_t holesOf(const Image& reference, const Image& test);
/// Halved until no side is longer than `largestSide`.
Image halved(const Image& image, int largestSide);
/// Colours the picture of an atlas by the kinds of its texels (see Gatherer::readKinds), the shaded texels
/// dimmed beneath. False, and nothing done, where there is not a kind a texel.
bool colorByKind(Image& atlas, const std::vector<std::uint8_t>& kinds, const std::vector<GatherKind>& names);
/// Where a picture of so many pixels shows most of an atlas: texels of many kinds, and many of them. A
/// smaller picture where that would be half empty.
ReportCrop fullestPart(int width, int height, const std::vector<std::uint8_t>& kinds, int partWidth,
                       int partHeight);
/// What the page shows of each method's run, so that a browser opens a page of many methods and scenes at
/// once.
struct PictureBudget {
  std::vector<std::size_t> frames;  // spread over the run
  int quality = 90;                 // of JPEG
  int atlasSide = 2048;             // pixels, at most
};
/// For a run of `frames` frames, on a page of so many runs: three pictures a run, one where runs are many.
PictureBudget pictureBudget(std::size_t frames, std::size_t runs);

}  // namespace tessera::app
