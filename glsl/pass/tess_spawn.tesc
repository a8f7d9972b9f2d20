// Spawns a tessellation vertex a sample (Hladky 2019, sec. 3.1 to 3.3). An L of up to 64 levels is the uniform pattern of
// its level. What has more samples than a tessellator spawns at once is several pieces, which count through the texels;
// so do Oversampling's blocks. A triangle of one texel is shaded here, and spawns nothing.
#include "lib/tess_shade.glsl"
#include "lib/tess_samples.glsl"
#include "lib/tess_store.glsl"
#include "lib/tess_image.glsl"

layout(vertices = 1) out;
layout(std430, binding = BIND_TESS_PIECES) readonly buffer Pieces { uvec2 pieces[]; };  // entry, first sample
layout(location = 0) flat in uint vPiece[];
layout(location = 0) patch out uvec4 pSpawn;  // entry, first sample, samples; 0 for the uniform pattern

void main() {
  uvec2 piece = pieces[vPiece[0]];
  TessEntry e = entries[piece.x];
  uint kind = kindOf(e.shape.kind);
  TessLevels levels = TessLevels(0u, 0u, 0u, 0u);
  uint count = 0u;
  if (kind == kTessSingle) {
    storeSample(piece.x, singleSample(e));
  } else if (kind == kTessL && levelOfKind(e.shape.kind) <= kTessLargest) {
    levels = tessUniform(levelOfKind(e.shape.kind));
  } else {
    count = min(texelsOfShape(e.shape) - piece.y, kTessMostSamples);
    levels = tessLevelsFor(count);
  }
  pSpawn = uvec4(piece, count, 0u);
  gl_TessLevelOuter[0] = float(levels.outer0);
  gl_TessLevelOuter[1] = float(levels.outer1);
  gl_TessLevelOuter[2] = float(levels.outer2);
  gl_TessLevelInner[0] = float(levels.inner);
}
