// A triangle of the scene, or a piece of one, by its number in the visible set: counter-clockwise in the world.
#include "shared/tess_split.h"
layout(std430, binding = BIND_POSITIONS) readonly buffer Positions { float positions[]; };
layout(std430, binding = BIND_INSTANCES) readonly buffer Instances { InstanceGpu instances[]; };
layout(std430, binding = BIND_PATCHES) readonly buffer Patches { PatchGeometry patches[]; };
layout(std430, binding = BIND_PATCH_INSTANCE) readonly buffer PatchInstances { uint instanceOfPatch[]; };
#ifndef SPLIT_ACCESS
#define SPLIT_ACCESS readonly
#endif
layout(std430, binding = BIND_SPLIT_PIECES) SPLIT_ACCESS buffer SplitPieces { TessPieceGpu splitPieces[]; };

struct SceneTriangle {
  uint instance;
  uint vertex0;
  uint vertex1;
  uint vertex2;
};

SceneTriangle sceneTriangle(uint number) {
  uint patchId = number >> 2u;
  uint part = number & 3u;
  uint index = instanceOfPatch[patchId];
  PatchGeometry geometry = patches[instances[index].patchOffset + patchId - instances[index].patchBase];
  uint second = part == 0u ? geometry.v1 : (part == 1u ? geometry.v2 : geometry.v3);
  uint third = part == 0u ? geometry.v2 : (part == 1u ? geometry.v3 : geometry.v4);
  bool mirrored = (instances[index].flags & kInstanceMirrored) != 0u;
  return SceneTriangle(index, geometry.v0, mirrored ? third : second, mirrored ? second : third);
}

vec3 worldCorner(SceneTriangle triangle, uint vertex) {
  return transformPoint(instances[triangle.instance],
                        vec3(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]));
}
// Columns 0 to 2.
mat3 worldCorners(SceneTriangle triangle) {
  return mat3(worldCorner(triangle, triangle.vertex0), worldCorner(triangle, triangle.vertex1),
              worldCorner(triangle, triangle.vertex2));
}

// What the number stands for: a whole triangle, or a piece of one.
struct TriangleElement {
  SceneTriangle triangle;
  uint piece;  // see packPiece; 0 for a whole one
  mat3 corners;  // world
};
TriangleElement triangleElement(uint number, uint triangles) {
  TriangleElement element;
  element.piece = 0u;
  if (number < triangles) {
    element.triangle = sceneTriangle(number);
    element.corners = worldCorners(element.triangle);
    return element;
  }
  TessPieceGpu part = splitPieces[number - triangles];
  element.piece = part.piece;
  element.triangle = sceneTriangle(part.triangle);
  element.corners = worldCorners(element.triangle) * pieceCorners(pieceOf(part.piece));
  return element;
}
