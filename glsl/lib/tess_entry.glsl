// As entry_triangle.glsl, for the tessellation gatherer. Needs view in scope.
#include "shared/tess_atlas.h"
#include "lib/tess_decode.glsl"
layout(std430, binding = BIND_DRAW_VERTICES) readonly buffer DrawVertices { TessVertex drawVertices[]; };
layout(std430, binding = BIND_DRAW_ENTRIES) readonly buffer DrawEntries { uint entryOfTriangle[]; };
layout(std430, binding = BIND_GATHER_VERTICES) readonly buffer Entries { TessEntry entries[]; };

vec3 seenCorner(TessVertex v) { return vec3(v.x, v.y, v.z) - view.eye.xyz; }

// Atlas coordinates, in texels, of what the view sees along `ray` on the triangle of `id`.
vec2 atlasTexel(uint id, vec3 ray) {
  uint entry = entryOfTriangle[id - 4u];
  TessVertex a = drawVertices[3u * entry];
  TessVertex b = drawVertices[3u * entry + 1u];
  TessVertex c = drawVertices[3u * entry + 2u];
  vec3 even = rayBarycentrics(ray, seenCorner(a), seenCorner(b), seenCorner(c)) * vec3(a.w, b.w, c.w);
  even = max(even, vec3(0.0));
  even /= max(even.x + even.y + even.z, 1e-30);
  return atlasOfEven(entries[entry].shape, entries[entry].place0, entries[entry].place1, even);
}
