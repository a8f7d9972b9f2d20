// Marks the tiles that a view's pixels touch, at the level of each pixel (Hillesland & Yang 2016). Tiles share their
// borders, so a bilinear fetch needs no tile but the one that its place is in.
#include "shared/bindings.h"
#include "lib/texel_want.glsl"
#include "lib/texel_seen.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
#ifdef LAYERS
layout(binding = UNIT_ID) uniform usampler2DArray uIds;
uint idAt(ivec2 pixel, uint layer) { return texelFetch(uIds, ivec3(pixel, layer), 0).r; }
#else
layout(binding = UNIT_ID) uniform usampler2D uIds;
uint idAt(ivec2 pixel, uint layer) { return texelFetch(uIds, pixel, 0).r; }
#endif
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu views[ID_VIEWS]; };
layout(location = LOCATION_VIEW) uniform mat3 uPixelToRay;  // see display_deferred.comp
layout(location = LOCATION_COUNT) uniform uint uView;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = textureSize(uIds, 0).xy;
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  uint id = idAt(pixel, uView);
  if (id == 0u) return;
  uint patchId = (id >> 2u) - 1u;
  TexelChart chart = charts[patchId];
  ChartPoint point = chartPoint(id, pixel, uPixelToRay, views[uView].eye.xyz);
  uint level = texelLevel(chart, point.dx, point.dy, texels.config.constantBias + texels.pressure.bias);
  if (level >= recordLevel(chart)) return;
  wantTile(patchId, tileAt(chart, level, placeInChart(chart, point.at)), chart, 0u);
}
