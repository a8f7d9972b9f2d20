// Writes down tiles that a frame wants, each once.
#include "lib/texel_state.glsl"

void loseTile() { atomicAdd(texels.lost, 1u); }

void wantTile(uint patchId, uint tile, TexelChart chart, uint source) {
  uint number = tileNumber(chart, tile);
  uint slots = texels.config.table;
  uint at = tableStart(number, slots);
  for (uint i = 0u; i < kTexelProbes; ++i) {
    uint word = 2u * (texels.current * slots + ((at + i) & (slots - 1u)));
    uint held = table[word];
    if (held == 0u) held = atomicCompSwap(table[word], 0u, number);
    if (held == number) return;
    if (held != 0u) continue;
    uint count = source == 0u ? atomicAdd(texels.wanted0, 1u) : atomicAdd(texels.wanted1, 1u);
    // Too many are made coarser, which empties the table: no place in it lasts that is not in the list.
    if (count < texels.config.wanted) wantedTiles[source * texels.config.wanted + count] = uvec2(patchId, tile);
    else loseTile();
    return;
  }
  loseTile();
}
