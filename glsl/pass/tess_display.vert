// The display stage of the tessellation gatherer: corners of the visible triangles with their weights, for any camera.
#define STAGE_VERTEX
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "shared/tess_atlas.h"
#include "lib/mask_vertex.glsl"

layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu view; };
layout(std430, binding = BIND_GATHER_VERTICES) readonly buffer Entries { TessEntry entries[]; };
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

layout(location = 0) in vec4 aCorner;  // world, relative to the anchor; weight
layout(location = 2) out vec3 vWeighted;  // of each corner: interpolated with perspective, proportional to even coordinates
layout(location = 3) flat out uvec3 vShape;
layout(location = 4) flat out uvec4 vPlaces;

invariant gl_Position;

void main() {
  gl_Position = view.viewProjection * vec4(aCorner.xyz, 1.0);
  uint corner = uint(gl_VertexID) % 3u;
  vWeighted = vec3(corner == 0u ? aCorner.w : 0.0, corner == 1u ? aCorner.w : 0.0, corner == 2u ? aCorner.w : 0.0);
  TessEntry e = entries[uint(gl_VertexID) / 3u];
  vShape = uvec3(e.shape.kind, e.shape.size, e.shape.form);
  vPlaces = uvec4(e.place0, e.place1, e.split, uint(gl_VertexID) / 3u);
  // The whole triangle is drawn, so that its edges are those of its neighbours; its pieces are only sampled.
  if (e.piece != 0u) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
#ifdef MASK
  uint v = corner == 0u ? e.vertex0 : (corner == 1u ? e.vertex1 : e.vertex2);
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
