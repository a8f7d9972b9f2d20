// The display stage in its deferred form: for each pixel of the id buffer, where in its patch's block it is.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/blocks.h"
#include "shared/interpolate.h"
#include "shared/tone.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = UNIT_ID) uniform usampler2D uIds;
layout(binding = UNIT_ATLAS) uniform sampler2D uAtlas;
layout(binding = 0) writeonly uniform image2D uColor;
layout(std430, binding = BIND_DRAW_VERTICES) readonly buffer DrawVertices { DisplayVertex drawVertices[]; };
layout(std430, binding = BIND_DRAW_ENTRIES) readonly buffer DrawEntries { uint entryOfPatch[]; };
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu view; };
layout(location = LOCATION_SIZE) uniform vec2 uHalfTexelToUv;
// Columns: the ray through pixel (x, y) is c0 + x * c1 + y * c2, relative to the eye.
layout(location = LOCATION_VIEW) uniform mat3 uPixelToRay;
layout(location = LOCATION_BACKGROUND) uniform vec4 uBackground;

vec3 place(DisplayVertex v) { return vec3(v.x, v.y, v.z) - view.eye.xyz; }
vec2 texel(DisplayVertex v) { return vec2(float(v.texel & 0xffffu), float(v.texel >> 16u)); }

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = textureSize(uIds, 0);
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  uint id = texelFetch(uIds, pixel, 0).r;
  if (id == 0u) {
    imageStore(uColor, pixel, uBackground);
    return;
  }
  uint entry = entryOfPatch[(id >> 2u) - 1u];
  uint part = id & 3u;
  // Third triangles of triples have an entry of their own behind the first (see rect_emit.comp). Mirrored instances
  // have their corners swapped, so their first two triangles change places.
  uint first = 4u * ((entry & 0x7fffffffu) + (part == 2u ? 1u : 0u));
  bool second = part != 2u && ((part == 1u) != ((entry >> 31u) != 0u));
  DisplayVertex a = drawVertices[first];
  DisplayVertex b = drawVertices[first + (second ? 2u : 1u)];
  DisplayVertex c = drawVertices[first + (second ? 3u : 2u)];
  vec3 ray = uPixelToRay * vec3(1.0, vec2(pixel) + 0.5);
  vec3 w = rayBarycentrics(ray, place(a), place(b), place(c));
  // A pixel centre that the rasterizer gave to the triangle lies in it but for rounding: keep the fetch in the block.
  w = max(w, vec3(0.0));
  w /= w.x + w.y + w.z;
  vec2 halfTexels = w.x * texel(a) + w.y * texel(b) + w.z * texel(c);
  vec3 color = textureLod(uAtlas, halfTexels * uHalfTexelToUv, 0.0).rgb;
#ifdef LINEAR_ATLAS
  color = vec3(encodeSrgb(color.r), encodeSrgb(color.g), encodeSrgb(color.b));
#endif
  imageStore(uColor, pixel, vec4(color, 1.0));
}
