// As tess_spawn.tesc, but only notes which samples there are; a compute pass shades them.
#include "lib/tess_list.glsl"
#include "lib/tess_spawn.glsl"

layout(vertices = 1) out;
layout(std430, binding = BIND_TESS_PIECES) readonly buffer Pieces { uvec2 pieces[]; };  // entry, first sample
layout(location = 0) flat in uint vPiece[];
layout(location = 0) patch out uvec4 pSpawn;  // entry, first sample, samples; 0 for the uniform pattern

void main() {
  uvec2 piece = pieces[vPiece[0]];
  TessEntry e = entries[piece.x];
  if (kindOf(e.shape.kind) == kTessSingle) listSample(piece.x, 0u);
  TessWork work = workOf(e.shape, piece.y);
  pSpawn = uvec4(piece, work.count, 0u);
  SPAWN(work);
}
