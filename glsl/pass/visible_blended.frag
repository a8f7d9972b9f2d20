// Marks the patch instance, or with TRIANGLES the triangle, of each fragment that nothing opaque hides. Drawn over the
// id pass's depths, which stay: of blended surfaces one behind the other all are seen, and so is what they cover.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "lib/visible_mark.glsl"

layout(early_fragment_tests) in;
layout(location = 2) flat in uvec3 vPatches;  // patchBase, pairs, triples

void main() {
  markVisible(elementOf(idOfTriangle(vPatches.x, vPatches.y, vPatches.z, uint(gl_PrimitiveID))), 1u);
}
