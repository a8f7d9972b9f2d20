#include "apps/tessera/compare/pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tessera::app {

std::size_t coveredPixels(const Image& image) {
  std::size_t covered = 0;
  for (std::size_t i = 3; i < image.pixels.size(); i += 4) covered += image.pixels[i] > 0 ? 1 : 0;
  return covered;
}

std::size_t holesOf(const Image& reference, const Image& test) {
  std::size_t holes = 0;
  for (std::size_t i = 3; i < reference.pixels.size(); i += 4)
    holes += reference.pixels[i] > 0 && test.pixels[i] == 0 ? 1 : 0;
  return holes;
}

Image halved(const Image& image, int largestSide) {
  Image small = image;
  while (std::max(small.width, small.height) > largestSide && small.width > 1 && small.height > 1) {
    Image next{small.width / 2, small.height / 2, {}};
    next.pixels.resize(static_cast<std::size_t>(next.width) * static_cast<std::size_t>(next.height) * 4);
    for (int y = 0; y < next.height; ++y)
      for (int x = 0; x < next.width; ++x)
        for (int c = 0; c < 4; ++c)
          next.at(x, y)[c] = static_cast<std::uint8_t>(
              (small.at(2 * x, 2 * y)[c] + small.at(2 * x + 1, 2 * y)[c] + small.at(2 * x, 2 * y + 1)[c] +
               small.at(2 * x + 1, 2 * y + 1)[c] + 2) /
              4);
    small = std::move(next);
  }
  return small;
}

bool colorByKind(Image& atlas, const std::vector<std::uint8_t>& kinds, const std::vector<GatherKind>& names) {
  if (kinds.empty() || 4 * kinds.size() != atlas.pixels.size()) return false;
  constexpr std::array<std::uint8_t, 3> kNothing = {22, 24, 28};
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    std::uint8_t* texel = atlas.pixels.data() + 4 * i;
    const bool known = kinds[i] > 0 && kinds[i] <= names.size();
    const std::array<std::uint8_t, 3>& color = known ? names[kinds[i] - 1U].color : kNothing;
    for (std::size_t c = 0; c < 3; ++c)
      texel[c] = known ? static_cast<std::uint8_t>((3 * color[c] + 2 * texel[c]) / 5) : color[c];
  }
  return true;
}

ReportCrop fullestPart(int width, int height, const std::vector<std::uint8_t>& kinds, int partWidth,
                       int partHeight) {
  ReportCrop best;
  best.width = std::min(partWidth, width);
  best.height = std::min(partHeight, height);
  constexpr std::size_t kKinds = 16;  // what is beyond counts as the last
  // Texels of each kind in each of the tiles that parts begin at.
  constexpr int kTile = 32;
  const auto across = static_cast<std::size_t>((width + kTile - 1) / kTile);
  const auto down = static_cast<std::size_t>((height + kTile - 1) / kTile);
  std::vector<std::array<std::uint32_t, kKinds>> tiles(across * down);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t at =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
      const std::size_t tile =
          static_cast<std::size_t>(y / kTile) * across + static_cast<std::size_t>(x / kTile);
      ++tiles[tile][std::min<std::size_t>(kinds[at], kKinds - 1)];
    }
  double most = -1.0;
  double fullest = 0.0;
  for (int y = 0; y + best.height <= height; y += kTile)
    for (int x = 0; x + best.width <= width; x += kTile) {
      std::array<double, kKinds> texels{};
      for (int row = y / kTile; row < (y + best.height) / kTile; ++row)
        for (int column = x / kTile; column < (x + best.width) / kTile; ++column)
          for (std::size_t kind = 1; kind < kKinds; ++kind)
            texels[kind] +=
                tiles[static_cast<std::size_t>(row) * across + static_cast<std::size_t>(column)][kind];
      // Roots: half of one kind and half of another is more than all of one.
      double score = 0.0;
      double held = 0.0;
      for (const double count : texels) {
        score += std::sqrt(count);
        held += count;
      }
      if (score <= most) continue;
      most = score;
      fullest = held / (static_cast<double>(best.width) * best.height);
      best.x = x;
      best.y = y;
    }
  // Half empty: a smaller part is fuller.
  if (fullest < 0.5 && partWidth >= 12 * kTile && partHeight >= 6 * kTile)
    return fullestPart(width, height, kinds, partWidth / 2, partHeight / 2);
  return best;
}

PictureBudget pictureBudget(std::size_t frames, std::size_t runs) {
  constexpr std::size_t kMany = 30;  // more than four scenes by five methods
  const bool many = runs > kMany;
  const std::size_t pictures = many ? 1 : 3;
  PictureBudget budget;
  for (std::size_t i = 0; i < std::min(pictures, frames); ++i)
    budget.frames.push_back(frames <= pictures ? i : (2 * i + 1) * frames / (2 * pictures));
  if (many) {
    budget.quality = 80;
    budget.atlasSide = 1024;
  }
  return budget;
}

}  // namespace tessera::app
