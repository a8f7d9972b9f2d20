// The alpha test of MASK materials, the same in every pass that draws geometry to the screen or a shadow map.
#ifdef MASK
layout(std430, binding = BIND_MATERIALS) readonly buffer Materials { MaterialGpu materials[]; };
layout(location = LOCATION_MATERIAL) uniform uint uMaterial;
#ifdef BASE_TEX
layout(binding = UNIT_MATERIAL + 0) uniform sampler2D uBaseColor;
layout(location = 0) in vec2 vMaskUv;
#endif
#ifdef VERTEX_COLOR
layout(location = 1) in float vMaskAlpha;
#endif

bool maskedOut() {
  float alpha = materials[uMaterial].baseColor.a;
#ifdef BASE_TEX
  alpha *= texture(uBaseColor, vMaskUv).a;
#endif
#ifdef VERTEX_COLOR
  alpha *= vMaskAlpha;
#endif
  return alpha < materials[uMaterial].emissive.a;
}
#endif
