// Where an entry's samples are, for display. Of a split triangle those of the piece that a point lies in; its own, coarse
// ones where that piece was not seen when the atlas was filled.
#include "lib/tess_decode.glsl"
layout(std430, binding = BIND_DRAW_VERTICES) readonly buffer DrawVertices { TessVertex drawVertices[]; };
layout(std430, binding = BIND_DRAW_ENTRIES) readonly buffer DrawEntries { uint entryOfTriangle[]; };
layout(std430, binding = BIND_GATHER_VERTICES) readonly buffer Entries { TessEntry entries[]; };

vec3 weightsOf(uint entry) {
  return vec3(drawVertices[3u * entry].w, drawVertices[3u * entry + 1u].w, drawVertices[3u * entry + 2u].w);
}

// Atlas texels of a point of an entry, by its barycentric coordinates times the corners' weights.
vec2 atlasOfEntry(uint entry, vec3 weighted) {
  TessEntry e = entries[entry];
  if (e.split != 0u) {
    PiecePoint point = pieceAt(evenOf(weighted / weightsOf(entry)), e.split);
    uint part = entryOfTriangle[e.firstPiece + point.index];
    if (part != kNoEntry) {
      e = entries[part];
      weighted = point.at * weightsOf(part);
    }
  }
  return atlasOfEven(e.shape, e.place0, e.place1, evenOf(weighted));
}
