// Empties this frame's table.
#include "lib/texel_state.glsl"

layout(local_size_x = TEXEL_GROUP) in;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < texels.config.table) table[2u * (texels.current * texels.config.table + i)] = 0u;
}
