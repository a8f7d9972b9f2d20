// Shading of a point of a surface: the one text for the forward renderer and for the atlas.
// Output: display-referred linear rgb in 0..1, always finite; a = 1, or the material's alpha with BLEND.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "shared/tone.h"
#include "lib/normal.glsl"
#include "lib/varyings.glsl"
#include "lib/brdf.glsl"

#include "lib/material.glsl"
layout(std140, binding = BIND_FRAME) uniform Frame { FrameGpu frame; };
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu view; };
#ifdef LIGHTS
layout(std140, binding = BIND_LIGHTS) uniform Lights { LightGpu lights[kMaxLights]; };
#endif
#ifdef SHADOWS
#include "lib/shadow.glsl"
#endif

#ifdef BASE_TEX
layout(binding = UNIT_MATERIAL + 0) uniform sampler2D uBaseColor;
#endif
#ifdef MR_TEX
layout(binding = UNIT_MATERIAL + 1) uniform sampler2D uMetallicRoughness;
#endif
#ifdef NORMAL_TEX
layout(binding = UNIT_MATERIAL + 2) uniform sampler2D uNormal;
#endif
#ifdef OCCLUSION_TEX
layout(binding = UNIT_MATERIAL + 3) uniform sampler2D uOcclusion;
#endif
#ifdef EMISSIVE_TEX
layout(binding = UNIT_MATERIAL + 4) uniform sampler2D uEmissive;
#endif

layout(location = 0) out vec4 oColor;

#if defined(USES_UV0) || defined(USES_UV1)
vec2 uvOf(uint slot) {
#if defined(UV_TRANSFORM) || (defined(USES_UV0) && defined(USES_UV1))
  vec4 row0 = material.uvRows[2u * slot];
#endif
#if defined(USES_UV0) && defined(USES_UV1)
  vec2 uv = row0.w > 0.5 ? vUv1 : vUv0;
#elif defined(USES_UV1)
  vec2 uv = vUv1;
#else
  vec2 uv = vUv0;
#endif
#ifdef UV_TRANSFORM
  vec4 row1 = material.uvRows[2u * slot + 1u];
  uv = vec2(dot(row0.xyz, vec3(uv, 1.0)), dot(row1.xyz, vec3(uv, 1.0)));
#endif
  return uv;
}
#endif

#ifdef LIGHTS
// Light arriving from a punctual source before the surface's cosine (KHR_lights_punctual): direction to it and radiance.
vec3 arriving(uint i, vec3 position, out vec3 l) {
  if (lights[i].type == kLightDirectional) {
    l = -lights[i].direction.xyz;
    return lights[i].radiance.rgb;
  }
  vec3 d = lights[i].position.xyz - position;
  // A light on the surface: the inverse square is cut at a centimetre.
  float d2 = max(dot(d, d), 1e-4);
  l = d * inversesqrt(d2);
  float window = 1.0;
  if (lights[i].position.w > 0.0) {
    float q = d2 * lights[i].position.w;
    window = clamp(1.0 - q * q, 0.0, 1.0);
  }
  float cone = 1.0;
  if (lights[i].type == kLightSpot) {
    cone = clamp(dot(lights[i].direction.xyz, -l) * lights[i].coneScale + lights[i].coneOffset, 0.0, 1.0);
    cone *= cone;
  }
  return lights[i].radiance.rgb * (window * cone / d2);
}
#endif

void main() {
  vec4 base = material.baseColor;
#ifdef BASE_TEX
  base *= texture(uBaseColor, uvOf(kSlotBaseColor));
#endif
#ifdef VERTEX_COLOR
  base *= vColor;
#endif
#if defined(MASK) && !defined(GATHER)
  if (base.a < material.emissive.a) discard;
#endif

#ifdef UNLIT
  // KHR_materials_unlit: the colour as it is, neither exposed nor tone-mapped.
  oColor.rgb = clamp(base.rgb, 0.0, 1.0);
#else
#if defined(DOUBLE_SIDED) && defined(GATHER)
  float side = vFacing;
#elif defined(DOUBLE_SIDED)
  float side = gl_FrontFacing ? 1.0 : -1.0;
#else
  float side = 1.0;
#endif
  vec3 v = safeNormalize(view.eye.xyz - vPosition, vec3(0.0, 1.0, 0.0));
  vec3 surfaceNormal = safeNormalize(vNormal, v) * side;
  vec3 n = surfaceNormal;
#ifdef NORMAL_TEX
  vec3 t = safeNormalize(vTangent.xyz - surfaceNormal * dot(surfaceNormal, vTangent.xyz), vec3(0.0));
  vec3 b = cross(surfaceNormal * side, t) * vTangent.w;
  vec3 bump = texture(uNormal, uvOf(kSlotNormal)).xyz * 2.0 - 1.0;
  bump.xy *= material.factors.z;
  // On a back face the whole frame turns with the surface, so the bumps keep their light.
  n = safeNormalize(t * bump.x * side + b * bump.y * side + surfaceNormal * bump.z, surfaceNormal);
#endif
  float metallic = material.factors.x;
  float roughness = material.factors.y;
#ifdef MR_TEX
  vec2 mr = texture(uMetallicRoughness, uvOf(kSlotMetallicRoughness)).bg;
  metallic *= mr.x;
  roughness *= mr.y;
#endif
  metallic = clamp(metallic, 0.0, 1.0);
  roughness = clamp(roughness, 0.0, 1.0);
  Lobe lobe;
  lobe.diffuse = base.rgb * (1.0 - metallic);
  lobe.f0 = mix(vec3(0.04), base.rgb, metallic);
  lobe.alpha = max(roughness * roughness, kMinAlpha);
  float nv = clamp(dot(n, v), 1e-4, 1.0);

  float occlusion = 1.0;
#ifdef OCCLUSION_TEX
  occlusion = 1.0 + material.factors.w * (texture(uOcclusion, uvOf(kSlotOcclusion)).r - 1.0);
#endif
#ifdef HEMISPHERE
  vec3 around = mix(frame.ambientGround.rgb, frame.ambientSky.rgb, 0.5 + 0.5 * n.y);
  vec3 r = reflect(-v, n);
  vec3 mirrored = mix(frame.ambientGround.rgb, frame.ambientSky.rgb, clamp(0.5 + r.y / (0.5 + roughness) * 0.5, 0.0, 1.0));
#else
  vec3 around = frame.ambientSky.rgb;
  vec3 mirrored = around;
#endif
  vec3 color = (lobe.diffuse * around + ambientSpecular(lobe.f0, roughness, nv) * mirrored) * occlusion;

#ifdef LIGHTS
  for (uint i = 0u; i < frame.lightCount; ++i) {
    vec3 l;
    vec3 radiance = arriving(i, vPosition, l);
    float nl = dot(n, l);
    if (nl <= 0.0 || dot(radiance, vec3(1.0)) <= 0.0) continue;
#ifdef SHADOWS
    if (lights[i].shadowLayer != kNoShadow) {
      float reaching = dot(surfaceNormal, l) <= 0.0 ? 0.0 : lightReaching(i, vPosition, surfaceNormal);
      if (reaching <= 0.0) continue;
      radiance *= reaching;
    }
#endif
    color += reflectLight(lobe, n, v, l, nv, nl) * radiance * nl;
  }
#endif

  vec3 emissive = material.emissive.rgb;
#ifdef EMISSIVE_TEX
  emissive *= texture(uEmissive, uvOf(kSlotEmissive)).rgb;
#endif
  color += emissive;

  color *= frame.ambientSky.w;
  oColor.rgb = vec3(toneCurve(color.r), toneCurve(color.g), toneCurve(color.b));
#endif  // UNLIT
  // A NaN that slips through every guard above must not reach the atlas, where it would live for many frames.
  if (any(isnan(oColor.rgb))) oColor.rgb = vec3(0.0);
#ifdef BLEND
  oColor.a = clamp(base.a, 0.0, 1.0);
#else
  oColor.a = 1.0;
#endif
}
