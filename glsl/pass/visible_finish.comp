// The size of the visible list as the arguments of indirect dispatches over it.
#include "shared/bindings.h"

layout(local_size_x = 1) in;
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_DISPATCH) writeonly buffer Dispatch { uint groups[3]; uint empty; };

void main() {
  groups[0] = (visibleCount + 63u) / 64u;
  groups[1] = 1u;
  groups[2] = 1u;
}
