// The arrays of streamed geometry, and positions relative to the eye that they were bound for.
#include "shared/streamed_bindings.h"
#include "shared/streamed.h"
layout(std430, binding = BIND_STREAMED_VERTICES) readonly buffer StreamedVertices { StreamedVertex streamedVertices[]; };
layout(std430, binding = BIND_STREAMED_TRIANGLES) readonly buffer StreamedTriangles { StreamedTriangle streamedTriangles[]; };
layout(std430, binding = BIND_STREAMED_OBJECTS) readonly buffer StreamedObjects { vec4 objectRows[]; };  // three an object
#ifdef TESS
layout(std430, binding = BIND_STREAMED_ELEMENTS) readonly buffer StreamedElements { StreamedTess streamedElements[]; };
#else
layout(std430, binding = BIND_STREAMED_ELEMENTS) readonly buffer StreamedElements { StreamedPatch streamedElements[]; };
#endif

vec3 streamedPosition(uint number) {
  StreamedVertex v = streamedVertices[number];
  vec4 at = vec4(v.x, v.y, v.z, 1.0);
  uint row = 3u * v.object;
  return vec3(dot(objectRows[row], at), dot(objectRows[row + 1u], at), dot(objectRows[row + 2u], at));
}
