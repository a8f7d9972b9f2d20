// From a place in a patch's chart to atlas coordinates, in texels: those of the level that is asked for, or of the one
// nearest to it that has the tile, and in the end the patch's record.
#define DISPLAYED
#include "lib/texel_state.glsl"

vec2 texelOfChart(uint patchId, vec2 seen, vec2 dx, vec2 dy) {
  TexelChart chart = charts[patchId];
  vec2 at = placeInChart(chart, seen);
  int record = int(recordLevel(chart));
  int level = min(int(texelLevel(chart, dx, dy, texels.shownBias) + texels.shownCoarser), record);
  TexelConfig config = texels.config;
  // From a display's own level outwards: finer first, where both are there.
  for (int i = 0; level < record && i < 2 * record; ++i) {
    int l = level + ((i & 1) == 0 ? (i + 1) / 2 : -(i + 1) / 2);
    if (l < 0 || l >= record) continue;
    uint tile = tileAt(chart, uint(l), at);
    uint word = placeInTable(tileNumber(chart, tile), texels.shown);
    uint slot = word == kNoPlaceInTable ? 0u : table[word + 1u];
    if (slot == 0u) continue;
    vec2 cells = vec2(cellsAlong(chartX(chart), uint(l)), cellsAlong(chartY(chart), uint(l)));
    vec2 inTile = at * cells - float(kTexelCells) * vec2(tileX(tile), tileY(tile));
    uvec2 corner = kTexelTile * uvec2((slot - 1u) % config.columns, (slot - 1u) / config.columns);
    return vec2(corner) + 0.5 + clamp(inTile, 0.0, float(kTexelCells));
  }
  uint width = kTexelTile * config.columns;
  return vec2(patchId % width, config.recordRow + patchId / width) + 0.5;
}
