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
  std::vector<std::uint32_t> ids;     // 0 for nothing; see Engine::readIds
  std::vector<std::uint8_t> slanted;  // 1 where the triangle is
};

/// Of what the view shows; finds what is visible anew.
SlantPicture slantPicture(Engine& engine, const TimedView& timed);

/// The places of the picture with the most pixels of slanted triangles that do not overlap, the best first:
/// at most `count`, without their pictures. A place has an eighth of the picture's width and height, at least
/// 16 pixels, and several slanted triangles: one alone, however large, is a surface like any other.
std::vector<ReportCrop> slantedPlaces(const SlantPicture& picture, int count);

/// slantedPlaces of some frames of a run, the best over all of them: at most three.
std::vector<ReportCrop> chooseCrops(Engine& engine, const std::vector<TimedView>& views,
                                    std::span<const std::size_t> frames);

/// The part of a picture that a crop shows.
Image cropped(const Image& image, const ReportCrop& crop);

}  // namespace tessera::app
