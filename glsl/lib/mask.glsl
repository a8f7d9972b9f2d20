// The alpha test of MASK materials, the same in every pass that draws geometry to the screen or a shadow map.
#ifdef MASK
#include "lib/material.glsl"
#ifdef BASE_TEX
layout(binding = UNIT_MATERIAL + 0) uniform sampler2D uBaseColor;
layout(location = 0) in vec2 vMaskUv;
#endif
#ifdef VERTEX_COLOR
layout(location = 1) in float vMaskAlpha;
#endif

bool maskedOut() {
  float alpha = material.baseColor.a;
#ifdef BASE_TEX
  alpha *= texture(uBaseColor, vMaskUv).a;
#endif
#ifdef VERTEX_COLOR
  alpha *= vMaskAlpha;
#endif
  return alpha < material.emissive.a;
}
#endif
