// Geometry that a viewer was sent and draws from, by numbers alone: it has neither the scene nor its materials. A vertex
// shader takes triangle gl_VertexID / 3 and its corner gl_VertexID % 3, the corner's vertex, that vertex's object's
// matrix, and the triangle's element, which says where in the atlas the corner lies.
#ifndef TESSERA_GLSL_SHARED_STREAMED_H
#define TESSERA_GLSL_SHARED_STREAMED_H
#include "shared/blocks.h"
#include "shared/dialect.h"
#include "shared/levels.h"
TESSERA_SHARED_BEGIN

// 16 bytes.
struct StreamedVertex {
  float x;  // in its object's space
  float y;
  float z;
  uint object;
};

// 16 bytes; counter-clockwise in the world. One that is free has three times the same vertex and no owner.
struct StreamedTriangle {
  uint v0;
  uint v1;
  uint v2;
  uint owner;  // see packOwner
};

// Rectangular gatherer: where a patch's block is. 16 bytes.
struct StreamedPatch {
  uint origin;  // first texel: x | y << 16
  uint level;   // see packLevel in levels.h
  uint style;   // see kStyle...
  uint spare;
};

// Tessellation gatherer: where a triangle's samples are, or a piece's of a split one. 40 bytes. The weights that decoding
// takes are depthWeights() of the corners from the eye of the frame's camera: of a split triangle 1, 1, 1.
struct StreamedTess {
  uint kind;   // as TessShape in tess_atlas.h
  uint size;
  uint form;
  uint place0;  // see packPlace
  uint place1;
  uint piece;       // of a piece: see packPiece; of a whole triangle: pieces along an edge, 0 for one that is not split
  uint triangle;    // number of its triangle, or of the triangle that it is a piece of
  uint firstPiece;  // of a split one: where in the table of pieces its own start, see kSplitBlock
  uint style;
  uint spare;
};

SHARED_CONST uint kNoOwner = 0xffffffffu;
SHARED_CONST uint kMostElements = 1u << 26u;

SHARED_CONST uint kStyleDoubleSided = 1u;
SHARED_CONST uint kStyleMasked = 2u;       // bits 16-31: number of its mask image
// Blended over what lies behind, in linear light; bits 8-15: alpha, times the mask's where it is masked too.
SHARED_CONST uint kStyleTransparent = 4u;
SHARED_FN uint styleAlpha(uint style) { return (style >> 8u) & 255u; }
SHARED_FN uint styleMask(uint style) { return style >> 16u; }

// Which element, which of its triangles (0 to 2), whether it has three of them, and whether its instance is mirrored.
SHARED_FN uint packOwner(uint element, uint part, bool triple, bool mirrored) {
  return (element << 4u) | (mirrored ? 8u : 0u) | (triple ? 4u : 0u) | part;
}
SHARED_FN uint ownerElement(uint owner) { return owner >> 4u; }

// Of PatchGeometry's corners (see scene.h) the one that corner `corner` of a streamed triangle is. Mirrored ones have
// their last two corners swapped.
SHARED_FN uint ownerCorner(uint owner, uint corner) {
  if (corner == 0u) return 0u;
  bool swapped = (owner & 8u) != 0u;
  return (owner & 3u) + (swapped ? 3u - corner : corner);
}

// Where that corner is in its patch's block: 0 low edge, 1 middle, 2 high edge, along the patch's axes.
SHARED_FN uvec2 ownerSide(uint owner, uint corner) {
  uint at = ownerCorner(owner, corner);
  bool triple = (owner & 4u) != 0u;
  if (at == 0u) return uvec2(triple ? 1u : 0u, 0u);
  if (at == 1u) return uvec2(2u, 0u);
  if (at == 2u) return uvec2(2u, 2u);
  return uvec2(0u, at == 3u ? 2u : 0u);
}

// And in the atlas, in half texels: what DisplayVertex::texel has, unpacked.
SHARED_FN uvec2 streamedHalfTexel(StreamedPatch place, uint owner, uint corner) {
  uvec2 side = ownerSide(owner, corner);
  bool transposed = levelTransposed(place.level);
  uint x = cornerHalfTexel(transposed ? side.y : side.x, levelWidth(place.level));
  uint y = cornerHalfTexel(transposed ? side.x : side.y, levelHeight(place.level));
  return uvec2((place.origin & 0xffffu) * 2u + x, (place.origin >> 16u) * 2u + y);
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::StreamedVertex) == 16);
static_assert(sizeof(tessera::glsl::StreamedTriangle) == 16);
static_assert(sizeof(tessera::glsl::StreamedPatch) == 16);
static_assert(sizeof(tessera::glsl::StreamedTess) == 40);
#endif
#endif
