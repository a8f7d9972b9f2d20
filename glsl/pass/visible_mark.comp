// Marks the patch instances, or with TRIANGLES the triangles, that the id buffer shows, and compacts them into the
// visible list. Run once a view, or once over LAYERS, so that the union of several views is one list. An element is
// appended by whoever marks it first. With PIXELS, counts the pixels of each as well.
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
layout(std430, binding = BIND_VISIBLE) buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_VISIBLE_MARK) coherent buffer Marks { uint marks[]; };
#ifdef PIXELS
layout(std430, binding = BIND_VISIBLE_PIXELS) buffer Pixels { uint pixels[]; };
#endif
layout(location = LOCATION_FRAME) uniform uint uFrame;

#ifdef TRIANGLES
uint elementOf(uint id) { return id - 4u; }  // see triangleNumber
#else
uint elementOf(uint id) { return (id >> 2u) - 1u; }
#endif

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = textureSize(uIds, 0).xy;
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  uint id = idAt(pixel);
  if (id == 0u) return;
  // Of a run of equal ids along x only the first asks: most pixels end here.
  if (gl_LocalInvocationID.x > 0u && elementOf(idAt(pixel - ivec2(1, 0))) == elementOf(id)) return;
  uint element = elementOf(id);
#ifdef PIXELS
  int run = 1;
  int most = min(16 - int(gl_LocalInvocationID.x), size.x - pixel.x);
  while (run < most && elementOf(idAt(pixel + ivec2(run, 0))) == element) ++run;
  atomicAdd(pixels[element], uint(run));
#endif
  if (marks[element] == uFrame) return;
  if (atomicExchange(marks[element], uFrame) == uFrame) return;
  visibleIds[atomicAdd(visibleCount, 1u)] = element;
}
