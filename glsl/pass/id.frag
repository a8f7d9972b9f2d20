// Which triangle is in front: (patch-instance id + 1) << 2 | triangle of the patch; 0 where nothing is.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "lib/mask.glsl"

layout(std430, binding = BIND_INSTANCES) readonly buffer Instances { InstanceGpu instances[]; };
layout(location = 2) flat in uint vInstance;
layout(location = 0) out uint oId;

void main() {
#ifdef MASK
  if (maskedOut()) discard;
#endif
  InstanceGpu instance = instances[vInstance];
  oId = idOfTriangle(instance, uint(gl_PrimitiveID));
}
