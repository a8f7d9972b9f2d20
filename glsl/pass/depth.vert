// Positions only: the id pass, the depth pre-pass and shadow maps.
#define STAGE_VERTEX
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "lib/mask_vertex.glsl"

layout(std430, binding = BIND_INSTANCES) readonly buffer Instances { InstanceGpu instances[]; };
#ifdef SHADOW_LAYER
layout(std430, binding = BIND_SHADOWS) readonly buffer Shadows { ShadowGpu shadows[]; };
layout(location = LOCATION_VIEW) uniform uint uLayer;
#else
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu view; };
#endif

layout(location = 0) in vec3 aPosition;
#if defined(MASK) && defined(BASE_TEX)
layout(location = 3) in vec2 aUv0;
#ifdef USES_UV1
layout(location = 4) in vec2 aUv1;
#endif
#endif
#if defined(MASK) && defined(VERTEX_COLOR)
layout(location = 5) in vec4 aColor;
#endif
#ifdef WRITE_ID
layout(location = 2) flat out uint vInstance;
#endif

invariant gl_Position;

void main() {
  uint index = uint(gl_BaseInstance + gl_InstanceID);
  vec3 position = transformPoint(instances[index], aPosition);
#ifdef SHADOW_LAYER
  gl_Position = shadows[uLayer].viewProjection * vec4(position, 1.0);
#else
  gl_Position = view.viewProjection * vec4(position, 1.0);
#endif
#ifdef WRITE_ID
  vInstance = index;
#endif
#ifdef MASK
#ifdef BASE_TEX
#ifdef USES_UV1
  writeMaskUv(aUv0, aUv1);
#else
  writeMaskUv(aUv0, aUv0);
#endif
#endif
#ifdef VERTEX_COLOR
  vMaskAlpha = aColor.a;
#endif
#endif
}
