// How many pixels show each element of the visible list, in its order.
#include "shared/bindings.h"

layout(local_size_x = 64) in;
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_VISIBLE_PIXELS) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = BIND_VISIBLE_SEEN) writeonly buffer Seen { uint seen[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < visibleCount) seen[i] = pixels[visibleIds[i]];
}
