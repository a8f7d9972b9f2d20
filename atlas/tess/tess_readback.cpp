// What a report says of the tessellation gatherer's atlas.
#include "atlas/tess/tess_atlas.hpp"

namespace tessera {

namespace {

enum Kind : std::uint8_t { kL = 1, kInside, kOutside, kSingle };  // 1 + index in GatherStatistics::kinds

/// Calls visit(columns, place) for each block of a shape.
template <class Visit>
void eachBlock(const glsl::TessState& state, const glsl::OverShape& over, Visit&& visit) {
  if (over.columns0 > 0) visit(over.columns0, state.place0);
  if (over.columns1 > 0) visit(over.columns1, state.place1);
}

std::uint64_t areaOf(glsl::uvec2 size) { return std::uint64_t{size.x} * size.y; }

}  // namespace

GatherStatistics TessAtlas::readStatistics() const {
  const TessStatistics memory = memory_.readStatistics();
  GatherStatistics statistics;
  statistics.samples = memory.lSamples + memory.inside + memory.outside + memory.singles;
  statistics.kinds = {{"L", {70, 190, 90}, memory.lSamples},
                      {"Oversampling inside", {50, 110, 230}, memory.inside},
                      {"Oversampling outside", {110, 210, 240}, memory.outside},
                      {"single", {240, 150, 40}, memory.singles}};
  statistics.visible = memory.visible;
  statistics.slanted = memory.slanted;
  statistics.liveTexels = memory.liveTexels;
  statistics.usedTexels = memory.cellTexels + memory.singles;
  statistics.failures = memory.failures;
  statistics.resets = memory.resets;
  statistics.bias = static_cast<double>(memory.bias);

  GatherPacking ls{"L", memory.lSamples, 0};
  GatherPacking blocks{"Oversampling", memory.inside + memory.outside, 0};
  // Halves of cells: one may have half a texel more than another.
  constexpr std::uint64_t kKindAndPlace = sizeof(glsl::TessShape::kind) + sizeof(glsl::TessEntry::place0);
  constexpr std::uint64_t kShapeAndPlaces = sizeof(glsl::TessShape) + 2 * sizeof(glsl::TessEntry::place0);
  const auto states = memory_.readStates();
  for (const glsl::uint triangle : memory_.readVisible()) {
    const glsl::TessState& state = states[triangle];
    const glsl::uint kind = glsl::kindOf(state.shape.kind);
    if (kind == glsl::kTessL) ls.texels += areaOf(glsl::lPairSize(glsl::levelOfKind(state.shape.kind)));
    if (kind == glsl::kTessOver) {
      const glsl::OverShape over = glsl::overOfShape(state.shape);
      eachBlock(state, over, [&](glsl::uint columns, glsl::uint) {
        blocks.texels += areaOf(glsl::overPairSize(columns, over.rows));
      });
    }
    statistics.decodeBytes += kind == glsl::kTessOver ? kShapeAndPlaces : kKindAndPlace;
  }
  ls.texels /= 2;
  blocks.texels /= 2;
  for (const GatherPacking& packing : {ls, blocks})
    if (packing.texels > 0) statistics.packings.push_back(packing);
  statistics.displayBytes = std::uint64_t{memory.visible} * 3 * sizeof(glsl::TessCorner);
  return statistics;
}

std::vector<std::uint8_t> TessAtlas::readKinds() const {
  const auto width = static_cast<std::size_t>(memory_.textureWidth());
  const auto height = static_cast<std::size_t>(memory_.textureHeight());
  std::vector<std::uint8_t> kinds(width * height, 0);
  const auto paint = [&](glsl::uvec2 texel, Kind kind) {
    kinds[(height - 1 - texel.y) * width + texel.x] = kind;
  };
  const auto states = memory_.readStates();
  for (const glsl::uint triangle : memory_.readVisible()) {
    const glsl::TessState& state = states[triangle];
    const glsl::uint kind = glsl::kindOf(state.shape.kind);
    const auto origin = [](glsl::uint place) {
      return glsl::uvec2(glsl::placeX(place), glsl::placeY(place));
    };
    if (kind == glsl::kTessSingle) paint(origin(state.place0), kSingle);
    if (kind == glsl::kTessL) {
      const glsl::uint level = glsl::levelOfKind(state.shape.kind);
      const bool turned = glsl::placeTurned(state.place0) != 0;
      for (glsl::uvec2 at(0); at.y <= level; ++at.y)
        for (at.x = 0; at.x <= level && glsl::lContains(at, level); ++at.x)
          paint(glsl::lAtlasTexel(at, origin(state.place0), level, turned), kL);
    }
    if (kind != glsl::kTessOver) continue;
    const glsl::OverShape over = glsl::overOfShape(state.shape);
    eachBlock(state, over, [&](glsl::uint columns, glsl::uint place) {
      const bool turned = glsl::placeTurned(place) != 0;
      const glsl::uvec2 corner = glsl::overCorner(origin(place), columns, over.rows, turned);
      for (glsl::uvec2 at(0); at.y < over.rows; ++at.y)
        for (at.x = 0; at.x < glsl::overRow(columns, over.rows, at.y); ++at.x)
          paint(glsl::overAtlasTexel(at, corner, turned),
                glsl::overInside(at, columns, over.rows) ? kInside : kOutside);
    });
  }
  return kinds;
}

}  // namespace tessera
