// As entry_triangle.glsl, for the tessellation gatherer. Needs view in scope.
#include "shared/tess_atlas.h"
#include "lib/tess_place.glsl"

vec3 seenCorner(TessVertex v) { return vec3(v.x, v.y, v.z) - view.eye.xyz; }

// Atlas coordinates, in texels, of what the view sees along `ray` on the triangle of `id`.
vec2 atlasTexel(uint id, vec3 ray) {
  uint entry = entryOfTriangle[id - 4u];
  TessVertex a = drawVertices[3u * entry];
  TessVertex b = drawVertices[3u * entry + 1u];
  TessVertex c = drawVertices[3u * entry + 2u];
  return atlasOfEntry(entry, rayBarycentrics(ray, seenCorner(a), seenCorner(b), seenCorner(c)) * vec3(a.w, b.w, c.w));
}
