// Where in the atlas an error is seen most: regions of interest for the encoder.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/region.hpp"
#include "codec/wire/visible_delta.hpp"
#include "engine/frame/engine.hpp"

namespace tessera {

/// A rectangle of the atlas, in texels, and how many pixels show it.
struct ShownBlock {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  double pixels = 0.0;
};

/// Blocks of the visible elements (GeometryFeed::visible of the engine's present frame), with the pixels of
/// all views that the set was found for. A split triangle's pixels are spread over its pieces by their
/// texels. Empty without EngineOptions::visiblePixels. Blocking.
std::vector<ShownBlock> shownBlocks(const Engine& engine, std::span<const wire::VisibleElement> elements);

/// Macroblocks of an atlas of this size, by the pixels that a texel of theirs fills against the mean of all
/// that are seen, [1/4, 4]: two halvings of what an error counts either way. What no pixel shows counts
/// least. Empty where nothing is seen.
std::vector<Region> regionsOf(std::span<const ShownBlock> blocks, int width, int height);

}  // namespace tessera
