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

// A sample: where it lies in even coordinates, and the steps to the samples next to it.
struct Place {
  vec3 even;
  vec3 steps[3];
};

Place singlePlace() { return Place(vec3(1.0 / 3.0), vec3[3](vec3(-1.0, 1.0, 0.0), vec3(0.0, -1.0, 1.0), vec3(1.0, 0.0, -1.0))); }

Place lPlace(uint level, TessPlace place) {
  float between = 1.0 / float(level);
  return Place(tessBary(place, tessUniform(level)),
               vec3[3](vec3(-between, between, 0.0), vec3(0.0, -between, between), vec3(between, 0.0, -between)));
}

Place overPlace(OverShape shape, OverCell cell) {
  Place sampled;
  sampled.even = overEven(cell, shape);
  OverCell right = cell;
  right.at.x += 1u;
  OverCell above = cell;
  above.at.y += 1u;
  sampled.steps[0] = overEven(right, shape) - sampled.even;
  // A flat triangle has one row, as high as the triangle.
  sampled.steps[1] = shape.rows > 1u ? overEven(above, shape) - sampled.even : vec3(0.0);
  sampled.steps[2] = vec3(0.0);
  return sampled;
}

// How surface coordinates b change with a step of even ones.
vec3 surfaceStep(vec3 b, vec3 even, vec3 w, vec3 evenStep) {
  vec3 q = evenStep / w;
  vec3 whole = even / w;
  return (q - b * (q.x + q.y + q.z)) / (whole.x + whole.y + whole.z);
}

vec4 shadePlace(uint entry, Place at) {
  TessEntry e = entries[entry];
  TessVertex c0 = drawVertices[3u * entry];
  TessVertex c1 = drawVertices[3u * entry + 1u];
  TessVertex c2 = drawVertices[3u * entry + 2u];
  vec3 w = vec3(c0.w, c1.w, c2.w);
  vec3 b = surfaceFromEvenOutside(at.even, w);
  // In the whole triangle, whose corners have the attributes.
  mat3 toWhole = e.piece == 0u ? mat3(1.0) : pieceCorners(pieceOf(e.piece));
  InstanceGpu instance = instances[e.instance];

  Surface s;
  s.position = b.x * cornerOf(c0) + b.y * cornerOf(c1) + b.z * cornerOf(c2);
  b = toWhole * b;
  s.normal =
      transformNormal(instance, b.x * normalOf(e.vertex0) + b.y * normalOf(e.vertex1) + b.z * normalOf(e.vertex2));
#if defined(USES_UV0) || defined(USES_UV1)
  // Inside of the triangle: what is extrapolated has the detail of where it leaves.
  vec3 inside = clampedBary(at.even);
  vec3 insideB = surfaceFromEven(inside, w);
  mat3 steps = mat3(surfaceStep(insideB, inside, w, at.steps[0]), surfaceStep(insideB, inside, w, at.steps[1]),
                    surfaceStep(insideB, inside, w, at.steps[2]));
  steps = toWhole * steps;
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
