// Debug pictures of a view, from its id buffer. MODE: 0 ids, 1 patches, 2 levels, 3 texel density.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/blocks.h"
#include "shared/interpolate.h"
#include "shared/levels.h"
#include "shared/rect_memory.h"
#include "lib/palette.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = UNIT_ID) uniform usampler2D uIds;
layout(binding = 0) writeonly uniform image2D uColor;
layout(std430, binding = BIND_PATCH_STATE) readonly buffer PatchStates { PatchState patchStates[]; };
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu view; };
layout(location = LOCATION_VIEW) uniform mat3 uPixelToRay;

#include "lib/entry_triangle.glsl"

// Atlas texels a pixel covers: the Jacobian of atlas coordinates by the pixel's.
float texelsPerPixel(uint id, vec2 pixel) {
  vec2 at = atlasTexel(id, uPixelToRay * vec3(1.0, pixel));
  vec2 dx = atlasTexel(id, uPixelToRay * vec3(1.0, pixel + vec2(0.5, 0.0))) - at;
  vec2 dy = atlasTexel(id, uPixelToRay * vec3(1.0, pixel + vec2(0.0, 0.5))) - at;
  return abs(dx.x * dy.y - dx.y * dy.x) * 4.0;
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = textureSize(uIds, 0);
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  uint id = texelFetch(uIds, pixel, 0).r;
  vec3 color = vec3(0.08);
  if (id != 0u) {
    uint patchId = (id >> 2u) - 1u;
    uint level = patchStates[patchId].level;
#if MODE == 0
    color = colorOfId(id);
#elif MODE == 1
    color = colorOfId(patchId) * (1.0 - 0.15 * float(id & 3u));
#elif MODE == 2
    color = colorOfLevel(levelWidth(level), levelHeight(level));
#else
    // Green is one texel a pixel, red four and more, blue a quarter and less.
    float density = texelsPerPixel(id, vec2(pixel) + 0.5);
    color = density > 0.0 ? heat(0.5 + 0.25 * log2(density)) : vec3(0.3);
#endif
  }
  imageStore(uColor, pixel, vec4(color, 1.0));
}
