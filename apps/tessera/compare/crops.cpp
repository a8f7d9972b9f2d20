#include "apps/tessera/compare/crops.hpp"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

namespace tessera::app {

namespace {

constexpr int kParts = 8;  // of the picture's width and height that a crop is
constexpr int kLeastSide = 16;
constexpr int kSteps = 4;  // places looked at over a crop's own width and height
constexpr std::size_t kSeveral = 8;
constexpr int kMost = 3;

bool overlap(const ReportCrop& a, const ReportCrop& b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

}  // namespace

SlantPicture slantPicture(Engine& engine, const TimedView& timed) {
  engine.update(timed.time);
  engine.findVisible({&timed.view, 1});
  SlantPicture picture{timed.view.width, timed.view.height, engine.readIds(), {}};
  const auto threshold = static_cast<double>(TessMemoryOptions().slanted);
  std::unordered_map<std::uint32_t, bool> known = {{0, false}};
  picture.slanted.reserve(picture.ids.size());
  for (const std::uint32_t id : picture.ids) {
    const auto [found, fresh] = known.try_emplace(id);
    if (fresh) found->second = engine.slantOf(id, timed.view) > threshold;
    picture.slanted.push_back(found->second ? 1 : 0);
  }
  return picture;
}

std::vector<ReportCrop> slantedPlaces(const SlantPicture& picture, int count) {
  const int width = std::min(std::max(picture.width / kParts, kLeastSide), picture.width);
  const int height = std::min(std::max(picture.height / kParts, kLeastSide), picture.height);
  std::vector<ReportCrop> places;
  for (int y = 0; y + height <= picture.height; y += std::max(1, height / kSteps))
    for (int x = 0; x + width <= picture.width; x += std::max(1, width / kSteps)) {
      std::size_t pixels = 0;
      std::unordered_set<std::uint32_t> triangles;
      for (int row = y; row < y + height; ++row)
        for (int column = x; column < x + width; ++column) {
          const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(picture.width) +
                          static_cast<std::size_t>(column);
          if (picture.slanted[at] == 0) continue;
          ++pixels;
          triangles.insert(picture.ids[at]);
        }
      if (triangles.size() < kSeveral) continue;
      ReportCrop place;
      place.x = x;
      place.y = y;
      place.width = width;
      place.height = height;
      place.slantedShare = static_cast<double>(pixels) / (width * height);
      places.push_back(std::move(place));
    }
  std::stable_sort(places.begin(), places.end(),
                   [](const ReportCrop& a, const ReportCrop& b) { return a.slantedShare > b.slantedShare; });
  std::vector<ReportCrop> best;
  for (const ReportCrop& place : places) {
    if (static_cast<int>(best.size()) == count) break;
    if (std::none_of(best.begin(), best.end(), [&](const ReportCrop& b) { return overlap(place, b); }))
      best.push_back(place);
  }
  return best;
}

std::vector<ReportCrop> chooseCrops(Engine& engine, const std::vector<TimedView>& views,
                                    std::span<const std::size_t> frames) {
  std::vector<ReportCrop> crops;
  for (const std::size_t frame : frames)
    for (ReportCrop& crop : slantedPlaces(slantPicture(engine, views[frame]), kMost)) {
      crop.frame = static_cast<int>(frame);
      crops.push_back(std::move(crop));
    }
  std::stable_sort(crops.begin(), crops.end(),
                   [](const ReportCrop& a, const ReportCrop& b) { return a.slantedShare > b.slantedShare; });
  crops.resize(std::min<std::size_t>(crops.size(), kMost));
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
