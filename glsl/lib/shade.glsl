// Shading of a point of a surface: the one text for the forward renderer and for every gatherer.
// Output: display-referred linear rgb in 0..1, always finite; a = 1, or the material's alpha with BLEND.
// Needs SURFACE_STEPS where no neighbouring invocations give texture lookups their derivatives.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "shared/tone.h"
#include "shared/normal.h"
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

#if (defined(GATHER) || defined(SURFACE_STEPS)) && (defined(USES_UV0) || defined(USES_UV1))
layout(location = LOCATION_TEXTURE_BIAS) uniform float uTextureBias;  // mip levels, where texels are shaded
#endif

struct Surface {
  vec3 position;  // relative to the anchor
  vec3 normal;    // of any length
#ifdef NORMAL_TEX
  vec4 tangent;
#endif
#ifdef USES_UV0
  vec2 uv0;
#endif
#ifdef USES_UV1
  vec2 uv1;
#endif
#ifdef VERTEX_COLOR
  vec4 color;
#endif
#ifdef DOUBLE_SIDED
  float side;  // +1 where the eye sees the front, -1 where it sees the back
#endif
#ifdef SURFACE_STEPS
  // How the coordinates change to the next shading sample, along three directions.
#ifdef USES_UV0
  vec2 uv0Steps[3];
#endif
#ifdef USES_UV1
  vec2 uv1Steps[3];
#endif
#endif
};

#if defined(USES_UV0) || defined(USES_UV1)
bool readsUv1(uint slot) {
#if defined(USES_UV0) && defined(USES_UV1)
  return material.uvRows[2u * slot].w > 0.5;
#elif defined(USES_UV1)
  return true;
#else
  return false;
#endif
}

// A texture coordinate (z = 1) or a step of one (z = 0), as the slot's transform leaves it.
vec2 transformUv(uint slot, vec3 uv) {
#ifdef UV_TRANSFORM
  return vec2(dot(material.uvRows[2u * slot].xyz, uv), dot(material.uvRows[2u * slot + 1u].xyz, uv));
#else
  return uv.xy;
#endif
}

vec2 uvOf(Surface s, uint slot) {
#if defined(USES_UV0) && defined(USES_UV1)
  vec2 uv = readsUv1(slot) ? s.uv1 : s.uv0;
#elif defined(USES_UV1)
  vec2 uv = s.uv1;
#else
  vec2 uv = s.uv0;
#endif
  return transformUv(slot, vec3(uv, 1.0));
}

#ifdef SURFACE_STEPS
// The mip level whose texels are as far apart as the samples are, along the direction where they are farthest,
// and the bias.
float lodOf(Surface s, uint slot, vec2 size) {
  float longest = 0.0;
  for (int i = 0; i < 3; ++i) {
#if defined(USES_UV0) && defined(USES_UV1)
    vec2 uvStep = readsUv1(slot) ? s.uv1Steps[i] : s.uv0Steps[i];
#elif defined(USES_UV1)
    vec2 uvStep = s.uv1Steps[i];
#else
    vec2 uvStep = s.uv0Steps[i];
#endif
    vec2 texels = transformUv(slot, vec3(uvStep, 0.0)) * size;
    longest = max(longest, dot(texels, texels));
  }
  return 0.5 * log2(clamp(longest, 1e-20, 1e20)) + uTextureBias;
}
#define SURFACE_TEXTURE(map, slot) textureLod(map, uvOf(s, slot), lodOf(s, slot, vec2(textureSize(map, 0))))
#elif defined(GATHER)
#define SURFACE_TEXTURE(map, slot) texture(map, uvOf(s, slot), uTextureBias)
#else
#define SURFACE_TEXTURE(map, slot) texture(map, uvOf(s, slot))
#endif
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

vec4 baseColorOf(Surface s) {
  vec4 base = material.baseColor;
#ifdef BASE_TEX
  base *= SURFACE_TEXTURE(uBaseColor, kSlotBaseColor);
#endif
#ifdef VERTEX_COLOR
  base *= s.color;
#endif
  return base;
}

// A NaN that slips through every guard must not reach the atlas, where it would live for many frames. Before the tone
// curve, whose comparisons may take it for white.
vec3 withoutNan(vec3 color) { return any(isnan(color)) ? vec3(0.0) : color; }

// `base` is baseColorOf(s): whoever tests its alpha has it already.
vec4 shadeSurface(Surface s, vec4 base) {
  vec4 result;
#ifdef UNLIT
  // KHR_materials_unlit: the colour as it is, neither exposed nor tone-mapped.
  result.rgb = clamp(withoutNan(base.rgb), 0.0, 1.0);
#else
#ifdef DOUBLE_SIDED
  float side = s.side;
#else
  float side = 1.0;
#endif
  vec3 v = safeNormalize(view.eye.xyz - s.position, vec3(0.0, 1.0, 0.0));
  vec3 surfaceNormal = safeNormalize(s.normal, v) * side;
  vec3 n = surfaceNormal;
#ifdef NORMAL_TEX
  vec3 t = safeNormalize(s.tangent.xyz - surfaceNormal * dot(surfaceNormal, s.tangent.xyz), vec3(0.0));
  vec3 b = cross(surfaceNormal * side, t) * s.tangent.w;
  vec3 bump = SURFACE_TEXTURE(uNormal, kSlotNormal).xyz * 2.0 - 1.0;
  bump.xy *= material.factors.z;
  // On a back face the whole frame turns with the surface, so the bumps keep their light.
  n = safeNormalize(t * bump.x * side + b * bump.y * side + surfaceNormal * bump.z, surfaceNormal);
#endif
  float metallic = material.factors.x;
  float roughness = material.factors.y;
#ifdef MR_TEX
  vec2 mr = SURFACE_TEXTURE(uMetallicRoughness, kSlotMetallicRoughness).bg;
  metallic *= mr.x;
  roughness *= mr.y;
#endif
  metallic = clamp(metallic, 0.0, 1.0);
  roughness = clamp(roughness, 0.0, 1.0);
  // A surface reflects at most what it gets; past 1, Fresnel's 1 - f0 turns the sign of the rest.
  vec3 albedo = clamp(base.rgb, 0.0, 1.0);
  Lobe lobe;
  lobe.diffuse = albedo * (1.0 - metallic);
  lobe.f0 = mix(vec3(0.04), albedo, metallic);
  lobe.alpha = max(roughness * roughness, kMinAlpha);
  float nv = clamp(dot(n, v), 1e-4, 1.0);

  float occlusion = 1.0;
#ifdef OCCLUSION_TEX
  occlusion = 1.0 + material.factors.w * (SURFACE_TEXTURE(uOcclusion, kSlotOcclusion).r - 1.0);
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
    vec3 radiance = arriving(i, s.position, l);
    float nl = dot(n, l);
    if (nl <= 0.0 || dot(radiance, vec3(1.0)) <= 0.0) continue;
#ifdef SHADOWS
    if (lights[i].shadowLayer != kNoShadow) {
      float reaching = dot(surfaceNormal, l) <= 0.0 ? 0.0 : lightReaching(i, s.position, surfaceNormal);
      if (reaching <= 0.0) continue;
      radiance *= reaching;
    }
#endif
    color += reflectLight(lobe, n, v, l, nv, nl) * radiance * nl;
  }
#endif

  vec3 emissive = material.emissive.rgb;
#ifdef EMISSIVE_TEX
  emissive *= SURFACE_TEXTURE(uEmissive, kSlotEmissive).rgb;
#endif
  color += emissive;

  color = withoutNan(color * frame.ambientSky.w);
  result.rgb = vec3(toneCurve(color.r), toneCurve(color.g), toneCurve(color.b));
#endif  // UNLIT
#ifdef BLEND
  result.a = clamp(base.a, 0.0, 1.0);
#else
  result.a = 1.0;
#endif
  return result;
}
