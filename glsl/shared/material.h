// Materials, lights and the frame's constants as the GPU sees them. std430-safe.
#ifndef TESSERA_GLSL_SHARED_MATERIAL_H
#define TESSERA_GLSL_SHARED_MATERIAL_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN

SHARED_CONST uint kSlotBaseColor = 0u;
SHARED_CONST uint kSlotMetallicRoughness = 1u;
SHARED_CONST uint kSlotNormal = 2u;
SHARED_CONST uint kSlotOcclusion = 3u;
SHARED_CONST uint kSlotEmissive = 4u;
SHARED_CONST uint kSlotCount = 5u;

struct MaterialGpu {
  vec4 baseColor;    // linear RGBA factor
  vec4 emissive;     // linear rgb factor; a = alpha cutoff
  vec4 factors;      // metallic, roughness, normal scale, occlusion strength
  // Two rows of the 2x3 uv transform a slot: uv' = (dot(row0.xyz, (u, v, 1)), dot(row1.xyz, ...)); row0.w = uv set.
  vec4 uvRows[10];
};

SHARED_CONST uint kLightDirectional = 0u;
SHARED_CONST uint kLightPoint = 1u;
SHARED_CONST uint kLightSpot = 2u;
SHARED_CONST uint kNoShadow = 0xffffffffu;

struct LightGpu {
  vec4 position;   // relative to the anchor; w = 1 / range^2, 0 = unlimited
  vec4 direction;  // unit, the way light travels; w unused
  vec4 radiance;   // lux or candela, linear rgb; w unused
  float coneScale;   // spot: scale and offset of cos(angle) (KHR_lights_punctual)
  float coneOffset;
  uint type;
  uint shadowLayer;  // first layer of the shadow map, kNoShadow if none; a point light has six
};

// Uniform blocks of 16 KiB are the least that GL promises; lights and shadow layers are kept within that.
SHARED_CONST uint kMaxLights = 256u;
SHARED_CONST uint kMaxShadowLayers = 200u;

struct FrameGpu {
  vec4 ambientSky;     // rgb radiance from above; w = exposure
  vec4 ambientGround;  // rgb radiance from below; w unused
  uint lightCount;
  uint shadowReach;  // texels of shadow maps blended on each side of the nearest four
  uint reserved1;
  uint reserved2;
};

// A shadow map layer: world (relative to the anchor) to its clip space, depth 0 at the near plane.
struct ShadowGpu {
  mat4 viewProjection;
  vec4 texel;  // x = world size of a texel at distance 1 (perspective) or anywhere (orthographic); y = 1 if perspective
};

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::MaterialGpu) == 208);
static_assert(sizeof(tessera::glsl::LightGpu) == 64);
static_assert(sizeof(tessera::glsl::LightGpu) * tessera::glsl::kMaxLights <= 16384);
static_assert(sizeof(tessera::glsl::ShadowGpu) * tessera::glsl::kMaxShadowLayers <= 16384);
static_assert(sizeof(tessera::glsl::FrameGpu) == 48);
static_assert(sizeof(tessera::glsl::ShadowGpu) == 80);
#endif
#endif
