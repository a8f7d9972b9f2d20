// Which triangle is in front: (patch-instance id + 1) << 2 | triangle of the patch; 0 where nothing is.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "lib/mask.glsl"

layout(location = 2) flat in uvec3 vPatches;  // patchBase, pairs, triples
layout(location = 0) out uint oId;

void main() {
#ifdef MASK
  if (maskedOut()) discard;
#endif
  oId = idOfTriangle(vPatches.x, vPatches.y, vPatches.z, uint(gl_PrimitiveID));
}
