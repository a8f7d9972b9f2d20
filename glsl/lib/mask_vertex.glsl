// The vertex half of lib/mask.glsl.
#ifdef MASK
#ifdef BASE_TEX
#include "lib/material.glsl"
layout(location = 0) out vec2 vMaskUv;
#endif
#ifdef VERTEX_COLOR
layout(location = 1) out float vMaskAlpha;
#endif

#ifdef BASE_TEX
void writeMaskUv(vec2 uv0, vec2 uv1) {
  vec4 row0 = material.uvRows[2u * kSlotBaseColor];
  vec4 row1 = material.uvRows[2u * kSlotBaseColor + 1u];
  vec3 uv = vec3(row0.w > 0.5 ? uv1 : uv0, 1.0);
  vMaskUv = vec2(dot(row0.xyz, uv), dot(row1.xyz, uv));
}
#endif
#endif
