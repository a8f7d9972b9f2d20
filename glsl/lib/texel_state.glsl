// The buffers of Texel Shading's memory, and its table: a hash of tile numbers with linear probing, one for the frame
// that is written and one for the frame before.
// DISPLAYED: only read, and of the frame that display shows.
#include "shared/bindings.h"
#include "shared/texel.h"
#ifdef DISPLAYED
#define TEXEL_ACCESS readonly
#else
#define TEXEL_ACCESS coherent
#endif

layout(std430, binding = BIND_TEXEL_CHARTS) readonly buffer Charts { TexelChart charts[]; };
layout(std430, binding = BIND_ATLAS_STATE) TEXEL_ACCESS buffer TexelStates { TexelState texels; };
layout(std430, binding = BIND_TEXEL_TABLE) TEXEL_ACCESS buffer Table { uint table[]; };  // a number and a slot + 1 each
#ifndef DISPLAYED
layout(std430, binding = BIND_TEXEL_TILES) buffer Tiles { TexelTile tiles[]; };
layout(std430, binding = BIND_TEXEL_WANTED) buffer Wanted { uvec2 wantedTiles[]; };  // patch instance, tile
#endif

const uint kNoPlaceInTable = 0xffffffffu;

uint tableStart(uint number, uint slots) { return (number * 0x9e3779b1u) >> (32u - uint(findMSB(slots))); }

// The word of the table that holds `number` in one of its halves, or kNoPlaceInTable.
uint placeInTable(uint number, uint which) {
  uint slots = texels.config.table;
  uint at = tableStart(number, slots);
  for (uint i = 0u; i < kTexelProbes; ++i) {
    uint word = 2u * (which * slots + ((at + i) & (slots - 1u)));
    uint held = table[word];
    if (held == number) return word;
    if (held == 0u) break;
  }
  return kNoPlaceInTable;
}
