// The vertex half of lib/mask.glsl.
#ifdef MASK
#ifdef BASE_TEX
layout(std430, binding = BIND_MATERIALS) readonly buffer Materials { MaterialGpu materials[]; };
layout(location = LOCATION_MATERIAL) uniform uint uMaterial;
layout(location = 0) out vec2 vMaskUv;
#endif
#ifdef VERTEX_COLOR
layout(location = 1) out float vMaskAlpha;
#endif

#ifdef BASE_TEX
void writeMaskUv(vec2 uv0, vec2 uv1) {
  vec4 row0 = materials[uMaterial].uvRows[2u * kSlotBaseColor];
  vec4 row1 = materials[uMaterial].uvRows[2u * kSlotBaseColor + 1u];
  vec3 uv = vec3(row0.w > 0.5 ? uv1 : uv0, 1.0);
  vMaskUv = vec2(dot(row0.xyz, uv), dot(row1.xyz, uv));
}
#endif
#endif
