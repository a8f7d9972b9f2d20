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
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu view; };
layout(location = LOCATION_SIZE) uniform vec2 uTexelToUv;
// Columns: the ray through pixel (x, y) is c0 + x * c1 + y * c2, relative to the eye.
layout(location = LOCATION_VIEW) uniform mat3 uPixelToRay;
layout(location = LOCATION_BACKGROUND) uniform vec4 uBackground;

// What two of the branches include: the first one to do so is the only one to get it.
#include "shared/tess_split.h"
#if defined(CHARTS)
#include "lib/texel_seen.glsl"
#include "lib/texel_find.glsl"
#elif defined(TRIANGLES)
#include "lib/tess_entry.glsl"
#else
#include "lib/entry_triangle.glsl"
#endif

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = textureSize(uIds, 0);
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  uint id = texelFetch(uIds, pixel, 0).r;
  if (id == 0u) {
    imageStore(uColor, pixel, uBackground);
    return;
  }
#ifdef CHARTS
  ChartPoint point = chartPoint(id, pixel, uPixelToRay, view.eye.xyz);
  vec2 texel = texelOfChart((id >> 2u) - 1u, point.at, point.dx, point.dy);
#else
  vec2 texel = atlasTexel(id, uPixelToRay * vec3(1.0, vec2(pixel) + 0.5));
#endif
  vec3 color = textureLod(uAtlas, texel * uTexelToUv, 0.0).rgb;
#ifdef LINEAR_ATLAS
  color = vec3(encodeSrgb(color.r), encodeSrgb(color.g), encodeSrgb(color.b));
#endif
  imageStore(uColor, pixel, vec4(color, 1.0));
}
