// Marks the patch instances, or with TRIANGLES the triangles, that the id buffer shows, and compacts them into the
// visible list. Run once a view, or once over LAYERS, so that the union of several views is one list. An element is
// appended by whoever marks it first. Counts the pixels that show nothing, and with PIXELS those of each as well.
#include "shared/bindings.h"
#include "shared/scene.h"

layout(local_size_x = 16, local_size_y = 16) in;
#ifdef LAYERS
layout(binding = UNIT_ID) uniform usampler2DArray uIds;
uint idAt(ivec2 pixel) { return texelFetch(uIds, ivec3(pixel, gl_WorkGroupID.z), 0).r; }
#else
layout(binding = UNIT_ID) uniform usampler2D uIds;
uint idAt(ivec2 pixel) { return texelFetch(uIds, pixel, 0).r; }
#endif
#include "lib/visible_mark.glsl"
layout(std430, binding = BIND_DISPATCH) buffer Dispatch { uint groups[3]; uint emptyPixels; };

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = textureSize(uIds, 0).xy;
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  uint id = idAt(pixel);
  // Of a run of equal ids along x only the first asks: most pixels end here.
  if (gl_LocalInvocationID.x > 0u && elementOf(idAt(pixel - ivec2(1, 0))) == elementOf(id)) return;
  uint element = elementOf(id);
  uint run = 1u;
  uint most = min(16u - gl_LocalInvocationID.x, uint(size.x - pixel.x));
#ifndef PIXELS
  if (id != 0u) most = 1u;
#endif
  while (run < most && elementOf(idAt(pixel + ivec2(run, 0))) == element) ++run;
  if (id == 0u)
    atomicAdd(emptyPixels, run);
  else
    markVisible(element, run);
}
