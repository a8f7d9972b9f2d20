// Streamed geometry for any camera, without vertex attributes: vertex gl_VertexID is corner gl_VertexID % 3 of triangle
// gl_VertexID / 3. Triangles that are free, or turn a single side away, become a point outside of the picture.
#include "lib/streamed_geometry.glsl"
#ifdef TESS
#include "shared/scene.h"
#include "shared/tess_measure.h"
#endif
#ifdef MASK
layout(std430, binding = BIND_STREAMED_MASK_AT) readonly buffer MaskAt { vec2 maskAt[]; };
layout(location = 2) out vec2 vMaskAt;
#endif

layout(location = LOCATION_VIEW) uniform mat4 uViewProjection;  // from positions relative to the eye
layout(location = LOCATION_STREAMED_SHADED) uniform vec3 uShadedEye;  // the atlas frame's eye, relative to this one's
#ifndef TESS
layout(location = LOCATION_SIZE) uniform vec2 uTexelToUv;  // 1 / size of the atlas texture
#endif

#ifdef TESS
layout(location = 0) out vec4 vPoint;  // barycentric coordinates times the corners' weights; the weights' own blend
layout(location = 1) flat out uint vElement;
#else
layout(location = 0) out vec2 vAtlas;
layout(location = 1) flat out uint vElement;
layout(location = 3) flat out vec4 vWithin;  // see insideOfBlock
#endif

invariant gl_Position;

void main() {
  uint number = uint(gl_VertexID) / 3u;
  uint corner = uint(gl_VertexID) % 3u;
  StreamedTriangle t = streamedTriangles[number];
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  vElement = 0u;
#ifdef TESS
  vPoint = vec4(0.0);
#else
  vAtlas = vec2(0.0);
  vWithin = vec4(0.0);
#endif
#ifdef MASK
  vMaskAt = vec2(0.0);
#endif
  if (t.owner == kNoOwner) return;
  uint element = ownerElement(t.owner);
  vec3 a = streamedPosition(t.v0);
  vec3 b = streamedPosition(t.v1);
  vec3 c = streamedPosition(t.v2);
  uint style = streamedElements[element].style;
  if ((style & kStyleDoubleSided) == 0u && !(dot(cross(b - a, c - a), a) < 0.0)) return;
  vec3 at = corner == 0u ? a : (corner == 1u ? b : c);
  gl_Position = uViewProjection * vec4(at, 1.0);
  vElement = element;
#ifdef TESS
  vec3 weights = depthWeights(a - uShadedEye, b - uShadedEye, c - uShadedEye);
  if (streamedElements[element].piece != 0u) weights = vec3(1.0);
  vec3 point = vec3(0.0);
  point[corner] = weights[corner];
  vPoint = vec4(point, weights[corner]);
#else
  StreamedPatch place = streamedElements[element];
  uvec2 texel = streamedHalfTexel(place, t.owner, corner);
  vAtlas = 0.5 * vec2(float(texel.x), float(texel.y)) * uTexelToUv;
  vWithin = insideOfBlock(texel, uvec2(levelWidth(place.level), levelHeight(place.level))) * uTexelToUv.xyxy;
#endif
#ifdef MASK
  vMaskAt = maskAt[corner == 0u ? t.v0 : (corner == 1u ? t.v1 : t.v2)];
#endif
}
