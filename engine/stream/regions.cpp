#include "engine/stream/regions.hpp"

#include <algorithm>
#include <array>
#include <unordered_map>
#include <unordered_set>

#include "glsl/shared/levels.h"
#include "glsl/shared/tess_atlas.h"

namespace tessera {

namespace {

constexpr double kLeastImportance = 0.25;
constexpr double kMostImportance = 4.0;
constexpr int kMacroblock = 16;  // texels a side: the quantizer moves by no less

double texelsOf(const ShownBlock& block) { return static_cast<double>(block.width) * block.height; }

/// Of wire::VisibleElement::words of the tessellation gatherer, one or two, without pixels.
std::vector<ShownBlock> blocksOfTess(const wire::VisibleElement& element) {
  const glsl::TessShape shape{element.words[0], element.words[1], element.words[2]};
  const std::array<glsl::uint, 2> places = {element.words[3], element.words[4]};
  std::vector<ShownBlock> blocks;
  const auto add = [&](glsl::uint place, glsl::uvec2 size) {
    blocks.push_back({glsl::placeX(place), glsl::placeY(place), size.x, size.y, 0.0});
  };
  const glsl::uint kind = glsl::kindOf(shape.kind);
  if (kind == glsl::kTessSingle) add(places[0], {1, 1});
  // Half of a cell that it shares with another triangle: as good as all of it where macroblocks are the
  // grain.
  if (kind == glsl::kTessL) add(places[0], glsl::lPairSize(glsl::levelOfKind(shape.kind)));
  if (kind == glsl::kTessOver) {
    const glsl::OverShape over = glsl::overOfShape(shape);
    for (glsl::uint side = 0; side < 2; ++side) {
      const glsl::uint columns = glsl::overColumns(over, side);
      if (columns != 0) add(places[side], glsl::overPairSize(columns, over.rows));
    }
  }
  return blocks;
}

}  // namespace

std::vector<ShownBlock> shownBlocks(const Engine& engine, std::span<const wire::VisibleElement> elements) {
  const std::vector<std::uint32_t> pixels = engine.readVisiblePixels();
  if (pixels.empty()) return {};
  const std::vector<std::uint32_t> numbers = engine.visibleSet()->read();
  std::unordered_map<std::uint32_t, std::uint32_t> pixelsOf;
  for (std::size_t i = 0; i < numbers.size(); ++i) pixelsOf.emplace(numbers[i], pixels[i]);
  // A split triangle is shown by its pieces, once there are any: its own samples then count for nothing.
  std::unordered_set<std::uint32_t> split;
  for (const wire::VisibleElement& element : elements)
    if (element.parent != wire::kNone) split.insert(element.parent);
  std::unordered_map<std::uint32_t, double> texelsOfOwner;
  std::vector<ShownBlock> all;
  std::vector<std::uint32_t> owners;
  for (const wire::VisibleElement& element : elements) {
    const bool piece = element.parent != wire::kNone;
    const std::uint32_t owner = piece ? element.parent : element.id;
    std::vector<ShownBlock> blocks;
    if (engine.tess() != nullptr) {
      if (!piece && split.contains(element.id)) continue;
      blocks = blocksOfTess(element);
    } else {
      blocks.push_back({element.words[0] & 0xffffu, element.words[0] >> 16u,
                        1u << glsl::levelWidth(element.words[1]), 1u << glsl::levelHeight(element.words[1]),
                        0.0});
    }
    for (const ShownBlock& block : blocks) {
      all.push_back(block);
      owners.push_back(owner);
      texelsOfOwner[owner] += texelsOf(block);
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto shown = pixelsOf.find(owners[i]);
    if (shown != pixelsOf.end()) all[i].pixels = shown->second * texelsOf(all[i]) / texelsOfOwner[owners[i]];
  }
  return all;
}

std::vector<Region> regionsOf(std::span<const ShownBlock> blocks, int width, int height) {
  const auto cells = [](int side) {
    return static_cast<std::size_t>((side + kMacroblock - 1) / kMacroblock);
  };
  const std::size_t across = cells(width);
  const std::size_t down = cells(height);
  constexpr std::size_t kSide = kMacroblock;
  std::vector<double> pixels(across * down, 0.0);
  for (const ShownBlock& block : blocks) {
    if (block.pixels <= 0.0) continue;
    const double share = block.pixels / texelsOf(block);
    const std::size_t right = std::size_t{block.x} + block.width;
    const std::size_t top = std::size_t{block.y} + block.height;
    for (std::size_t v = block.y / kSide; v < std::min((top + kSide - 1) / kSide, down); ++v)
      for (std::size_t u = block.x / kSide; u < std::min((right + kSide - 1) / kSide, across); ++u) {
        // Of the macroblock's texels, those of this block.
        const std::size_t wide = std::min(right, (u + 1) * kSide) - std::max<std::size_t>(block.x, u * kSide);
        const std::size_t high = std::min(top, (v + 1) * kSide) - std::max<std::size_t>(block.y, v * kSide);
        pixels[v * across + u] += share * static_cast<double>(wide * high);
      }
  }
  double sum = 0.0;
  std::size_t seen = 0;
  for (const double value : pixels) {
    sum += value;
    seen += value > 0.0 ? 1 : 0;
  }
  std::vector<Region> regions;
  if (seen == 0) return regions;
  regions.reserve(pixels.size());
  const double mean = sum / static_cast<double>(seen);
  for (std::size_t v = 0; v < down; ++v)
    for (std::size_t u = 0; u < across; ++u) {
      Region region;
      region.x = static_cast<int>(u) * kMacroblock;
      region.y = static_cast<int>(v) * kMacroblock;
      region.width = std::min(kMacroblock, width - region.x);
      region.height = std::min(kMacroblock, height - region.y);
      region.importance = std::clamp(pixels[v * across + u] / mean, kLeastImportance, kMostImportance);
      regions.push_back(region);
    }
  return regions;
}

}  // namespace tessera
