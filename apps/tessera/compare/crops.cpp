#include "apps/tessera/compare/crops.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

namespace tessera::app {

namespace {

constexpr int kParts = 9;  // of the picture's width and height that a crop is
constexpr int kLeastSide = 16;
constexpr int kSteps = 4;  // places looked at over a crop's own width and height
constexpr std::size_t kSeveral = 8;
constexpr int kMost = 3;

/// Whether a picture's width or height, or less, lies between them.
bool adjacent(const ReportCrop& a, const ReportCrop& b) {
  return std::abs(a.x - b.x) < 2 * a.width && std::abs(a.y - b.y) < 2 * a.height;
}

}  // namespace

SlantPicture slantPicture(Engine& engine, const TimedView& timed) {
  engine.update(timed.time);
  engine.findVisible({&timed.view, 1});
  SlantPicture picture{timed.view.width, timed.view.height, engine.readIds(), {}};
  const auto threshold = static_cast<double>(TessMemoryOptions().slanted);
  std::unordered_map<std::uint32_t, float> known = {{0, 0.0f}};
  picture.excess.reserve(picture.ids.size());
  for (const std::uint32_t id : picture.ids) {
    const auto [found, fresh] = known.try_emplace(id);
    if (fresh)
      found->second =
          static_cast<float>(std::log2(std::max(engine.slantOf(id, timed.view) / threshold, 1.0)));
    picture.excess.push_back(found->second);
  }
  return picture;
}

std::vector<ReportCrop> slantedPlaces(const SlantPicture& picture, int count) {
  const int width = std::min(std::max(picture.width / kParts, kLeastSide), picture.width);
  const int height = std::min(std::max(picture.height / kParts, kLeastSide), picture.height);
  struct Place {
    double excess = 0.0;
    ReportCrop crop;
  };
  std::vector<Place> places;
  for (int y = 0; y + height <= picture.height; y += std::max(1, height / kSteps))
    for (int x = 0; x + width <= picture.width; x += std::max(1, width / kSteps)) {
      Place place;
      std::size_t pixels = 0;
      std::unordered_set<std::uint32_t> triangles;
      for (int row = y; row < y + height; ++row)
        for (int column = x; column < x + width; ++column) {
          const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(picture.width) +
                          static_cast<std::size_t>(column);
          if (!(picture.excess[at] > 0.0f)) continue;
          ++pixels;
          place.excess += static_cast<double>(picture.excess[at]);
          triangles.insert(picture.ids[at]);
        }
      if (triangles.size() < kSeveral) continue;
      // Of two places as slanted, the one of many thin triangles: a wall of few is a surface like any other.
      place.excess *= std::sqrt(static_cast<double>(triangles.size()));
      place.crop.x = x;
      place.crop.y = y;
      place.crop.width = width;
      place.crop.height = height;
      place.crop.slantedShare = static_cast<double>(pixels) / (width * height);
      places.push_back(std::move(place));
    }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.excess > b.excess; });
  std::vector<ReportCrop> worst;
  for (const Place& place : places) {
    if (static_cast<int>(worst.size()) == count) break;
    if (std::none_of(worst.begin(), worst.end(),
                     [&](const ReportCrop& w) { return adjacent(place.crop, w); }))
      worst.push_back(place.crop);
  }
  return worst;
}

std::vector<ReportCrop> chooseCrops(Engine& engine, const std::vector<TimedView>& views,
                                    std::span<const std::size_t> frames) {
  std::vector<std::vector<ReportCrop>> places;
  for (const std::size_t frame : frames) {
    places.push_back(slantedPlaces(slantPicture(engine, views[frame]), kMost));
    for (ReportCrop& crop : places.back()) crop.frame = static_cast<int>(frame);
  }
  std::vector<ReportCrop> crops;
  for (std::size_t rank = 0; rank < kMost; ++rank)
    for (const std::vector<ReportCrop>& of : places)
      if (rank < of.size() && crops.size() < kMost) crops.push_back(of[rank]);
  return crops;
}

Image cropped(const Image& image, const ReportCrop& crop) {
  Image part{crop.width, crop.height, {}};
  for (int y = crop.y; y < crop.y + crop.height; ++y)
    part.pixels.insert(part.pixels.end(), image.at(crop.x, y),
                       image.at(crop.x, y) + std::ptrdiff_t{4} * crop.width);
  return part;
}

}  // namespace tessera::app
