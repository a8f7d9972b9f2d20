// From an id-buffer value to its triangle of the draw entries, and to a place in the atlas. Needs view in scope.
layout(std430, binding = BIND_DRAW_VERTICES) readonly buffer DrawVertices { DisplayVertex drawVertices[]; };
layout(std430, binding = BIND_DRAW_ENTRIES) readonly buffer DrawEntries { uint entryOfPatch[]; };

vec3 placeOf(DisplayVertex v) { return vec3(v.x, v.y, v.z) - view.eye.xyz; }
vec2 halfTexelOf(DisplayVertex v) { return vec2(float(v.texel & 0xffffu), float(v.texel >> 16u)); }

// Atlas coordinates, in texels, of what the view sees along `ray` on the triangle of `id`.
vec2 atlasTexel(uint id, vec3 ray) {
  uint entry = entryOfPatch[(id >> 2u) - 1u];
  uint part = id & 3u;
  // Third triangles of triples have an entry of their own behind the first (see rect_emit.comp). Mirrored instances
  // have their corners swapped, so their first two triangles change places, and a third's corners turn.
  uint first = 4u * ((entry & 0x7fffffffu) + (part == 2u ? 1u : 0u));
  bool second = part != 2u && ((part == 1u) != ((entry >> 31u) != 0u));
  DisplayVertex a = drawVertices[first];
  DisplayVertex b = drawVertices[first + (second ? 2u : 1u)];
  DisplayVertex c = drawVertices[first + (second ? 3u : 2u)];
  vec3 w = rayBarycentrics(ray, placeOf(a), placeOf(b), placeOf(c));
  // A pixel centre that the rasterizer gave to the triangle lies in it but for rounding: keep the fetch in the block.
  w = max(w, vec3(0.0));
  w /= max(w.x + w.y + w.z, 1e-30);
  return 0.5 * (w.x * halfTexelOf(a) + w.y * halfTexelOf(b) + w.z * halfTexelOf(c));
}
