// See tess_raster.vert: a fragment is a texel, and inverts the map of its slot.
#include "lib/tess_shade.glsl"

layout(location = 0) flat in uint vEntry;
layout(location = 0) out vec4 oColor;

void main() { oColor = shadeTexel(vEntry, uvec2(gl_FragCoord.xy)); }
