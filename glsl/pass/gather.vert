// Vertices of the shading pass: each patch drawn over its block of the atlas (Mueller 2021, sec. 3.1).
#define STAGE_VERTEX
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/blocks.h"
#include "shared/normal.h"
#include "lib/varyings.glsl"

layout(std430, binding = BIND_NORMALS) readonly buffer Normals { float normals[]; };
layout(std430, binding = BIND_INSTANCES) readonly buffer Instances { InstanceGpu instances[]; };
layout(std430, binding = BIND_GATHER_VERTICES) readonly buffer GatherVertices { GatherVertex gatherVertices[]; };
#ifdef NORMAL_TEX
layout(std430, binding = BIND_TANGENTS) readonly buffer Tangents { vec4 tangents[]; };
#endif
#ifdef USES_UV0
layout(std430, binding = BIND_UV0) readonly buffer Uv0 { vec2 uv0[]; };
#endif
#ifdef USES_UV1
layout(std430, binding = BIND_UV1) readonly buffer Uv1 { vec2 uv1[]; };
#endif
#ifdef VERTEX_COLOR
layout(std430, binding = BIND_COLORS) readonly buffer Colors { vec4 colors[]; };
#endif
#ifdef DOUBLE_SIDED
layout(std430, binding = BIND_POSITIONS) readonly buffer Positions { float positions[]; };
layout(std430, binding = BIND_DRAW_VERTICES) readonly buffer DrawVertices { DisplayVertex drawVertices[]; };
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu view; };
#endif
layout(location = LOCATION_SIZE) uniform vec2 uTexelToClip;  // 2 / size of the atlas texture

layout(location = 0) in vec3 aPosition;  // world, relative to the anchor
layout(location = 1) in uint aTexel;

#ifdef DOUBLE_SIDED
vec3 corner(uint index) { return vec3(drawVertices[index].x, drawVertices[index].y, drawVertices[index].z); }

// The side of the provoking vertex's triangle that the eye is on: vertex 2 speaks for (0, 1, 2), 3 for (0, 2, 3).
float facing(uint index, uint flags) {
  uint first = index & ~3u;
  bool second = (index & 3u) == 3u;
  vec3 a = corner(first);
  vec3 b = corner(first + (second ? 2u : 1u));
  vec3 c = corner(first + (second ? 3u : 2u));
  return dot(cross(b - a, c - a), view.eye.xyz - a) >= 0.0 ? 1.0 : -1.0;
}
#endif

void main() {
  GatherVertex gathered = gatherVertices[gl_VertexID];
  InstanceGpu instance = instances[gathered.instance >> kCornerBits];
  uint bits = gathered.instance;
  uint v = gathered.vertex;
  vec2 texel = vec2(
      gatherCoordinate(aTexel & 0xffffu, (bits >> kCornerSideX) & 3u, ((bits >> kCornerSingleX) & 1u) != 0u),
      gatherCoordinate(aTexel >> 16u, (bits >> kCornerSideY) & 3u, ((bits >> kCornerSingleY) & 1u) != 0u));
  gl_Position = vec4(texel * uTexelToClip - 1.0, 0.5, 1.0);
  vPosition = aPosition;
  vNormal = transformNormal(instance, vec3(normals[3u * v], normals[3u * v + 1u], normals[3u * v + 2u]));
#ifdef NORMAL_TEX
  vTangent = vec4(transformDirection(instance, tangents[v].xyz),
                  (instance.flags & kInstanceMirrored) != 0u ? -tangents[v].w : tangents[v].w);
#endif
#ifdef USES_UV0
  vUv0 = uv0[v];
#endif
#ifdef USES_UV1
  vUv1 = uv1[v];
#endif
#ifdef VERTEX_COLOR
  vColor = colors[v];
#endif
#ifdef DOUBLE_SIDED
  vFacing = facing(uint(gl_VertexID), instance.flags);
#endif
}
