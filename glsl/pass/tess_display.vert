// The display stage of the tessellation gatherer: corners of a list of triangles, for any camera.
#define STAGE_VERTEX
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "lib/mask_vertex.glsl"

layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu view; };
#ifdef MASK
#ifdef BASE_TEX
layout(std430, binding = BIND_UV0) readonly buffer Uv0 { vec2 uv0[]; };
#ifdef USES_UV1
layout(std430, binding = BIND_UV1) readonly buffer Uv1 { vec2 uv1[]; };
#endif
#endif
#ifdef VERTEX_COLOR
layout(std430, binding = BIND_COLORS) readonly buffer Colors { vec4 colors[]; };
#endif
#endif

// A TessCorner.
layout(location = 0) in vec4 aCorner;  // world, relative to the anchor; weight
layout(location = 1) in vec3 aPoint;
layout(location = 2) in uvec3 aPlace;
layout(location = 2) out vec4 vPoint;  // interpolated with perspective, proportional to the point's coordinates; weight
layout(location = 3) flat out uvec2 vPlace;

invariant gl_Position;

void main() {
  gl_Position = view.viewProjection * vec4(aCorner.xyz, 1.0);
  vPoint = vec4(aPoint, aCorner.w);
  vPlace = aPlace.xy;
#ifdef MASK
  uint v = aPlace.z;
#ifdef BASE_TEX
#ifdef USES_UV1
  writeMaskUv(uv0[v], uv1[v]);
#else
  writeMaskUv(uv0[v], uv0[v]);
#endif
#endif
#ifdef VERTEX_COLOR
  vMaskAlpha = colors[v].a;
#endif
#endif
}
