// What the GPU knows of the scene's geometry and of a view. std430-safe.
#ifndef TESSERA_GLSL_SHARED_SCENE_H
#define TESSERA_GLSL_SHARED_SCENE_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN

// A patch of one primitive: 1 to 3 triangles that share one block (Mueller 2021, sec. 3.3). Vertex indices are
// absolute. Places in the block, (0,0) to (1,1):
//   pair    v0 (0,0)  v1 (1,0)  v2 (1,1)  v3 (0,1); triangles (v0,v1,v2), (v0,v2,v3)
//   single  as a pair with v3 = v1: the second half mirrors the triangle, so no sample leaves it
//   triple  v0 (0.5,0)  v1 (1,0)  v2 (1,1)  v3 (0,1)  v4 (0,0); triangles (v0,v1,v2), (v0,v2,v3), (v0,v3,v4)
// Unused corners repeat an earlier one. Triangles keep the winding of the mesh.
struct PatchGeometry {
  uint v0;
  uint v1;
  uint v2;
  uint v3;
  uint v4;
  uint triangles;  // 1, 2 or 3
};

SHARED_CONST uint kInstanceMirrored = 1u;     // the world matrix has a negative determinant

// A primitive placed in the world. Patch-instance ids are patchBase .. patchBase + patchCount - 1; the triangles of
// a primitive are sorted: pairs first, then triples, then singles, so a patch follows from a triangle's number.
struct InstanceGpu {
  vec4 row0;  // rows of the 3x4 world matrix, relative to the scene's anchor
  vec4 row1;
  vec4 row2;
  uint patchBase;    // first patch-instance id
  uint patchOffset;  // first PatchGeometry of the primitive
  uint pairs;        // patches of two triangles
  uint triples;      // patches of three triangles
  uint singles;      // patches of one triangle
  uint batch;        // which draw state and material, see batches
  uint flags;        // kInstance...
  uint material;
};

// A view, as levels and display need it. Depth is reversed: 1 at the near plane, 0 at infinity.
struct ViewGpu {
  mat4 viewProjection;  // from positions relative to the anchor
  vec4 eye;             // relative to the anchor; w = pixels per radian (r / f of Mueller 2021, eq. 3.1)
};

SHARED_FN vec3 transformPoint(InstanceGpu instance, vec3 p) {
  vec4 h = vec4(p, 1.0);
  return vec3(dot(instance.row0, h), dot(instance.row1, h), dot(instance.row2, h));
}

// The patch-instance id of triangle `triangle` (0-based, in the sorted order) of an instance.
SHARED_FN uint patchOfTriangle(uint patchBase, uint pairs, uint triples, uint triangle) {
  uint inPairs = 2u * pairs;
  if (triangle < inPairs) return patchBase + triangle / 2u;
  uint inTriples = 3u * triples;
  uint rest = triangle - inPairs;
  if (rest < inTriples) return patchBase + pairs + rest / 3u;
  return patchBase + pairs + triples + (rest - inTriples);
}

// Which of its patch's triangles (0, 1 or 2) triangle `triangle` of an instance is.
SHARED_FN uint partOfTriangle(uint pairs, uint triples, uint triangle) {
  uint inPairs = 2u * pairs;
  if (triangle < inPairs) return triangle % 2u;
  uint rest = triangle - inPairs;
  return rest < 3u * triples ? rest % 3u : 0u;
}

// What the id pass writes: (patch-instance id + 1) << 2 | triangle of the patch. 0 is nothing, so 2^30 - 1 patch
// instances can be told apart.
SHARED_FN uint idOfTriangle(uint patchBase, uint pairs, uint triples, uint triangle) {
  return ((patchOfTriangle(patchBase, pairs, triples, triangle) + 1u) << 2u) | partOfTriangle(pairs, triples, triangle);
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::PatchGeometry) == 24);
static_assert(sizeof(tessera::glsl::InstanceGpu) == 80);
static_assert(sizeof(tessera::glsl::ViewGpu) == 80);
#endif
#endif
