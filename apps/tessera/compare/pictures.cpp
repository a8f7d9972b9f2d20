#include "apps/tessera/compare/pictures.hpp"

#include <algorithm>
#include <array>

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
