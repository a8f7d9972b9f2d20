// The display stage: geometry of the visible set with its atlas coordinates, for any camera.
// CHARTS: with its coordinates in the patches' charts, (0,0) to (1,1).
#define STAGE_VERTEX
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "shared/blocks.h"
#ifdef CHARTS
#include "shared/texel.h"
#endif
#include "lib/mask_vertex.glsl"

layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu view; };
#if defined(MASK) || defined(CHARTS)
layout(std430, binding = BIND_GATHER_VERTICES) readonly buffer GatherVertices { GatherVertex gatherVertices[]; };
#endif
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
#ifndef CHARTS
layout(location = LOCATION_SIZE) uniform vec2 uTexelToUv;  // 1 / size of the atlas texture
#endif

layout(location = 0) in vec3 aPosition;
layout(location = 1) in uint aTexel;
#ifndef CHARTS
layout(location = 2) in uint aBlock;
#endif
layout(location = 2) out vec2 vAtlas;
#ifdef CHARTS
layout(location = 3) flat out uint vPatch;
#else
layout(location = 3) flat out vec4 vWithin;  // see insideOfBlock
#endif

invariant gl_Position;

void main() {
  gl_Position = view.viewProjection * vec4(aPosition, 1.0);
  vAtlas = 0.5 * vec2(float(aTexel & 0xffffu), float(aTexel >> 16u));
#ifdef CHARTS
  vPatch = gatherVertices[gl_VertexID].instance & ~kChartRepeated;
#else
  vWithin = insideOfBlock(uvec2(aTexel & 0xffffu, aTexel >> 16u), uvec2(aBlock & 15u, aBlock >> 4u)) * uTexelToUv.xyxy;
  vAtlas *= uTexelToUv;
#endif
#ifdef MASK
  uint v = gatherVertices[gl_VertexID].vertex;
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
