// Takes each wanted tile a level coarser. What was a chart's coarsest is left to its record.
#include "lib/texel_want.glsl"

layout(local_size_x = TEXEL_GROUP) in;

void main() {
  uint i = gl_GlobalInvocationID.x;
  uint source = texels.source;
  if (i >= (source == 0u ? texels.wanted0 : texels.wanted1)) return;
  uvec2 wanted = wantedTiles[source * texels.config.wanted + i];
  TexelChart chart = charts[wanted.x];
  if (tileLevel(wanted.y) + 1u >= recordLevel(chart)) return;
  wantTile(wanted.x, coarserTile(chart, wanted.y), chart, 1u - source);
}
