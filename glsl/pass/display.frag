// The display stage: one fetch from the atlas; the alpha test where the material asks for it.
// CHARTS: the place in a patch's chart is looked up in the table first.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "lib/mask.glsl"

layout(binding = UNIT_ATLAS) uniform sampler2D uAtlas;
layout(location = 2) in vec2 vAtlas;
#ifdef CHARTS
#include "lib/texel_find.glsl"
layout(location = LOCATION_SIZE) uniform vec2 uTexelToUv;
layout(location = 3) flat in uint vPatch;
#else
layout(location = 3) flat in vec4 vWithin;
#endif
layout(location = 0) out vec4 oColor;

void main() {
#ifdef CHARTS
  // Before what may be discarded: the neighbours must be there.
  vec2 dx = dFdxFine(vAtlas);
  vec2 dy = dFdyFine(vAtlas);
#endif
#ifdef MASK
  if (maskedOut()) discard;
#endif
#ifdef CHARTS
  vec2 at = texelOfChart(vPatch, vAtlas, dx, dy) * uTexelToUv;
#else
  // The rasterizer snaps corners to its grid, so a pixel's centre may lie outside of a triangle that covers it: of a
  // needle by as much as it is high, and the place by a block.
  vec2 at = clamp(vAtlas, vWithin.xy, vWithin.zw);
#endif
  oColor = vec4(textureLod(uAtlas, at, 0.0).rgb, 1.0);
}
