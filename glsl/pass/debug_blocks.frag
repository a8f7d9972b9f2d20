// See debug_blocks.vert. A block's size follows from how fast its sides pass: 1 / derivative.
#include "lib/palette.glsl"

layout(location = 0) in vec2 vSide;
layout(location = 1) flat in uint vEntry;
layout(location = 0) out vec4 oColor;

void main() {
  vec2 size = 1.0 / max(vec2(abs(dFdx(vSide.x)), abs(dFdy(vSide.y))), vec2(1e-5));
  uvec2 log2Size = uvec2(round(log2(max(size, vec2(1.0)))));
  vec3 color = colorOfLevel(max(log2Size.x, log2Size.y), min(log2Size.x, log2Size.y));
  color *= 0.85 + 0.15 * float(scramble(vEntry) & 1u);
  vec2 texels = min(vSide, 1.0 - vSide) * size;
  if (min(texels.x, texels.y) < 0.75 && min(size.x, size.y) >= 8.0) color *= 0.45;
  oColor = vec4(color, 1.0);
}
