// The nearest depth of a picture: the largest, as bits of a float that is not negative.
#include "shared/bindings.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = UNIT_DEPTH) uniform sampler2D uDepth;  // reversed: near plane / distance
layout(std430, binding = BIND_WARP_NEAREST) buffer Nearest { uint nearestBits; };

shared uint groupBits;

void main() {
  if (gl_LocalInvocationIndex == 0u) groupBits = 0u;
  barrier();
  ivec2 pixel = min(ivec2(gl_GlobalInvocationID.xy), textureSize(uDepth, 0) - 1);
  atomicMax(groupBits, floatBitsToUint(max(texelFetch(uDepth, pixel, 0).r, 0.0)));
  barrier();
  if (gl_LocalInvocationIndex == 0u) atomicMax(nearestBits, groupBits);
}
