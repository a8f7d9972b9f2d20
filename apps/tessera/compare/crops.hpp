// Where a scene's frames show most slanted triangles: what atlases get wrong first.
#pragma once

#include <span>
#include <vector>

#include "apps/tessera/options.hpp"
#include "apps/tessera/report/report.hpp"

namespace tessera::app {

/// What each pixel shows, rows from the top.
struct SlantPicture {
  int width = 0;
  int height = 0;
  std::vector<std::uint32_t> ids;  // 0 for nothing; see Engine::readIds
  std::vector<float>
      excess;  // log2 of how far the triangle is past the threshold for slanted ones; 0: it is not
};

/// Of what the view shows; finds what is visible anew.
SlantPicture slantPicture(Engine& engine, const TimedView& timed);

/// The places of the picture where triangles are most slanted, the worst first, without their pictures: at
/// most `count`, and no two of them next to each other. A place has a ninth of the picture's width and
/// height, at least 16 pixels, and several slanted triangles: the more there are, the more it counts.
std::vector<ReportCrop> slantedPlaces(const SlantPicture& picture, int count);

/// Three slantedPlaces of some frames of a run, as evenly from each frame as there are any.
std::vector<ReportCrop> chooseCrops(Engine& engine, const std::vector<TimedView>& views,
                                    std::span<const std::size_t> frames);

/// The part of a picture that a crop shows.
Image cropped(const Image& image, const ReportCrop& crop);

}  // namespace tessera::app
