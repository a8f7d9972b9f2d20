// Spawns a tessellation vertex a sample (Hladky 2019, sec. 3.1 to 3.3). A triangle of one texel is shaded here, and spawns
// nothing.
#include "lib/tess_shade.glsl"
#include "lib/tess_samples.glsl"
#include "lib/tess_store.glsl"
#include "lib/tess_image.glsl"
#include "lib/tess_spawn.glsl"

layout(vertices = 1) out;
layout(std430, binding = BIND_TESS_PIECES) readonly buffer Pieces { uvec2 pieces[]; };  // entry, first sample
layout(location = 0) flat in uint vPiece[];
layout(location = 0) patch out uvec4 pSpawn;  // entry, first sample, samples; 0 for the uniform pattern

void main() {
  uvec2 piece = pieces[vPiece[0]];
  TessEntry e = entries[piece.x];
  if (kindOf(e.shape.kind) == kTessSingle) storeSample(piece.x, singleSample(e));
  TessWork work = workOf(e.shape, piece.y);
  pSpawn = uvec4(piece, work.count, 0u);
  SPAWN(work);
}
