// What a report says of the rectangular atlas.
#include "atlas/rect/rect_atlas.hpp"

namespace tessera {

namespace {

enum Kind : std::uint8_t { kBlock = 1, kSingle = 2 };  // 1 + index in GatherStatistics::kinds

}  // namespace

GatherStatistics RectAtlas::readStatistics() const {
  const RectStatistics memory = memory_.readStatistics();
  GatherStatistics statistics;
  statistics.samples = memory.samples;
  statistics.kinds = {{"block", {176, 128, 214}, memory.liveTexels},
                      {"single", {240, 150, 40}, memory.records}};
  statistics.packings = {{"blocks", memory.liveTexels, memory.liveTexels}};
  statistics.visible = memory.visiblePatches;
  statistics.liveTexels = memory.liveTexels;
  statistics.usedTexels =
      memory.liveTexels + memory.endTexels + memory.stackTexels + memory.inaccessibleTexels + memory.records;
  const std::uint64_t vertices = draw_.readVertices();
  statistics.displayBytes = vertices * sizeof(glsl::DisplayVertex);
  statistics.decodeBytes =
      vertices * (sizeof(glsl::DisplayVertex::texel) + sizeof(glsl::DisplayVertex::block));
  statistics.failures = memory.failures;
  statistics.resets = memory.resets;
  statistics.bias = static_cast<double>(memory.bias);
  return statistics;
}

std::vector<std::uint8_t> RectAtlas::readKinds() const {
  const auto width = static_cast<std::size_t>(memory_.textureWidth());
  const auto height = static_cast<std::size_t>(memory_.textureHeight());
  std::vector<std::uint8_t> kinds(width * height, 0);
  for (const glsl::PatchState& patch : memory_.readVisible()) {
    const glsl::uvec2 at = glsl::unpackOrigin(patch.origin);
    const glsl::uint columns = 1u << glsl::levelWidth(patch.level);
    const glsl::uint rows = 1u << glsl::levelHeight(patch.level);
    for (glsl::uint y = 0; y < rows; ++y)
      for (glsl::uint x = 0; x < columns; ++x)
        kinds[(height - 1 - (at.y + y)) * width + at.x + x] = columns * rows == 1 ? kSingle : kBlock;
  }
  return kinds;
}

}  // namespace tessera
