// Streamed geometry: the alpha test where an element asks for it, its place in the atlas, and one fetch.
#include "lib/streamed_geometry.glsl"
#ifdef MASK
#include "lib/streamed_mask.glsl"
#endif
#ifdef TESS
#include "shared/scene.h"
#include "shared/tess_atlas.h"
#include "shared/tess_measure.h"
#include "lib/tess_decode.glsl"
layout(std430, binding = BIND_STREAMED_PIECES) readonly buffer StreamedPieces { uint streamedPieces[]; };
#endif

layout(binding = UNIT_ATLAS) uniform sampler2D uAtlas;
layout(location = LOCATION_STREAMED_SHADED) uniform vec3 uShadedEye;
layout(location = LOCATION_SIZE) uniform vec2 uTexelToUv;
#ifdef TESS
layout(location = 0) in vec4 vPoint;
layout(location = 1) flat in uint vElement;
#else
layout(location = 0) in vec2 vAtlas;
layout(location = 1) flat in uint vElement;
layout(location = 3) flat in vec4 vWithin;
#endif
#ifdef MASK
layout(location = 2) in vec2 vMaskAt;
#endif
layout(location = 0) out vec4 oColor;

#ifdef TESS
TessShape shapeOf(StreamedTess e) { return TessShape(e.kind, e.size, e.form); }

// Of a split triangle the samples of the piece that the point lies in; its own, coarse ones where there is no such piece.
vec2 atlasTexel(uint element, vec3 weighted) {
  StreamedTess e = streamedElements[element];
  vec3 even = evenOf(weighted);
  if (e.piece != 0u) {
    PiecePoint point = pieceAt(even, e.piece);
    uint part = streamedPieces[e.firstPiece + point.index];
    if (part != kNoOwner) {
      StreamedTriangle t = streamedTriangles[e.triangle];
      mat3 corners = mat3(streamedPosition(t.v0) - uShadedEye, streamedPosition(t.v1) - uShadedEye,
                          streamedPosition(t.v2) - uShadedEye) *
                     pieceCorners(SplitPiece(point.index, e.piece));
      e = streamedElements[part];
      even = evenOf(point.at * depthWeights(corners[0], corners[1], corners[2]));
    }
  }
  return atlasOfEven(shapeOf(e), e.place0, e.place1, even);
}
#endif

void main() {
#ifdef MASK
  // Derivatives before what may be discarded: the neighbours must be there.
  vec2 dx = dFdx(vMaskAt);
  vec2 dy = dFdy(vMaskAt);
  uint style = streamedElements[vElement].style;
  if ((style & kStyleMasked) != 0u && streamedMaskedOut(styleMask(style), vMaskAt, dx, dy)) discard;
#endif
#ifdef TESS
  vec2 at = atlasTexel(vElement, vPoint.xyz) * uTexelToUv;
#else
  vec2 at = clamp(vAtlas, vWithin.xy, vWithin.zw);  // as in display.frag
#endif
  oColor = vec4(textureLod(uAtlas, at, 0.0).rgb, 1.0);
}
