// Shading of one texel of a triangle's slot: the same text for every way to spawn samples.
#define SURFACE_STEPS
#include "shared/bindings.h"
#include "shared/tess_atlas.h"
#include "shared/perspective_map.h"
#include "lib/shade.glsl"

layout(std430, binding = BIND_NORMALS) readonly buffer Normals { float normals[]; };
layout(std430, binding = BIND_INSTANCES) readonly buffer Instances { InstanceGpu instances[]; };
layout(std430, binding = BIND_GATHER_VERTICES) readonly buffer Entries { TessEntry entries[]; };
layout(std430, binding = BIND_DRAW_VERTICES) readonly buffer DrawVertices { TessVertex drawVertices[]; };
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

vec3 normalOf(uint v) { return vec3(normals[3u * v], normals[3u * v + 1u], normals[3u * v + 2u]); }
vec3 cornerOf(TessVertex v) { return vec3(v.x, v.y, v.z); }

// A place on a triangle in even coordinates, and how far apart its samples are along each edge.
struct Place {
  vec3 even;
  float between;
};

Place placeOf(uint shape, uint place, uvec2 texel) {
  if (kindOf(shape) != kTessL) return Place(vec3(1.0 / 3.0), 1.0);
  uint level = levelOfShape(shape);
  uvec2 at = texel - uvec2(placeX(place), placeY(place));
  if (placeTurned(place) != 0u) at = uvec2(lCellWidth(level) - 1u, lCellHeight(level) - 1u) - at;
  return Place(lCoordinates(level, at.x, at.y), 1.0 / float(level));
}

// How surface coordinates b change with a step of even ones.
vec3 surfaceStep(vec3 b, vec3 even, vec3 w, vec3 evenStep) {
  vec3 q = evenStep / w;
  vec3 whole = even / w;
  return (q - b * (q.x + q.y + q.z)) / (whole.x + whole.y + whole.z);
}

vec4 shadeTexel(uint entry, uvec2 texel) {
  TessEntry e = entries[entry];
  TessVertex c0 = drawVertices[3u * entry];
  TessVertex c1 = drawVertices[3u * entry + 1u];
  TessVertex c2 = drawVertices[3u * entry + 2u];
  vec3 w = vec3(c0.w, c1.w, c2.w);
  Place at = placeOf(e.shape, e.place, texel);
  vec3 b = surfaceOfEven(at.even, w);
  InstanceGpu instance = instances[e.instance];

  Surface s;
  s.position = b.x * cornerOf(c0) + b.y * cornerOf(c1) + b.z * cornerOf(c2);
  s.normal =
      transformNormal(instance, b.x * normalOf(e.vertex0) + b.y * normalOf(e.vertex1) + b.z * normalOf(e.vertex2));
#if defined(USES_UV0) || defined(USES_UV1)
  mat3 steps = mat3(surfaceStep(b, at.even, w, vec3(-at.between, at.between, 0.0)),
                    surfaceStep(b, at.even, w, vec3(0.0, -at.between, at.between)),
                    surfaceStep(b, at.even, w, vec3(at.between, 0.0, -at.between)));
#endif
#ifdef NORMAL_TEX
  vec4 tangent = b.x * tangents[e.vertex0] + b.y * tangents[e.vertex1] + b.z * tangents[e.vertex2];
  s.tangent = vec4(transformDirection(instance, tangent.xyz),
                   (instance.flags & kInstanceMirrored) != 0u ? -tangent.w : tangent.w);
#endif
#ifdef USES_UV0
  mat3x2 corners0 = mat3x2(uv0[e.vertex0], uv0[e.vertex1], uv0[e.vertex2]);
  s.uv0 = corners0 * b;
  for (int i = 0; i < 3; ++i) s.uv0Steps[i] = corners0 * steps[i];
#endif
#ifdef USES_UV1
  mat3x2 corners1 = mat3x2(uv1[e.vertex0], uv1[e.vertex1], uv1[e.vertex2]);
  s.uv1 = corners1 * b;
  for (int i = 0; i < 3; ++i) s.uv1Steps[i] = corners1 * steps[i];
#endif
#ifdef VERTEX_COLOR
  s.color = b.x * colors[e.vertex0] + b.y * colors[e.vertex1] + b.z * colors[e.vertex2];
#endif
#ifdef DOUBLE_SIDED
  s.side = dot(cross(cornerOf(c1) - cornerOf(c0), cornerOf(c2) - cornerOf(c0)), view.eye.xyz - cornerOf(c0)) >= 0.0
               ? 1.0 : -1.0;
#endif
  return shadeSurface(s, baseColorOf(s));
}
