// Splits the visible triangles that want more samples than a slot has (the pre-tessellation of Hladky 2019, as a compute
// pass: pieces keep their numbers from frame to frame, and with them their places). A thread a visible triangle: as few
// pieces as all of them in view have room for, evenly over its plane. The list of what is sampled has the whole triangle,
// then coarse, and the pieces that a view has in its frustum.
#define SPLIT_ACCESS
#include "shared/scene.h"
#include "shared/tess_measure.h"
#include "lib/split_state.glsl"
#include "lib/triangle.glsl"

layout(local_size_x = TESS_GROUP) in;
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_ATLAS_STATE) readonly buffer AtlasStates { TessAtlasState atlas; };
layout(std430, binding = BIND_PATCH_STATE) buffer States { TessState states[]; };
layout(std430, binding = BIND_SPLIT_ELEMENTS) buffer Elements { uint elementCount; uint elementIds[]; };
layout(std430, binding = BIND_DRAW_ENTRIES) writeonly buffer DrawEntries { uint entryOfTriangle[]; };
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu views[TESS_VIEWS]; };
layout(location = LOCATION_FRAME) uniform uint uFrame;

// How much wider than chosen sizes must be for a split triangle to have fewer pieces: cameras that sway change nothing.
const float kKeeps = 1.1;

// Read before any loop: Mesa 22.3's software drivers keep one value of a load for a loop and what follows it, and take 0
// for threads that left the loop while others went on.
uint viewCount = 0u;
TessLimits limits = TessLimits(0.0, 0.0, 0.0);

bool seenBy(uint view, mat3 corners) {
  mat3x4 clip;
  for (int i = 0; i < 3; ++i) clip[i] = views[view].viewProjection * vec4(corners[i], 1.0);
  bvec3 left = bvec3(false), right = bvec3(false), below = bvec3(false), above = bvec3(false), behind = bvec3(false);
  for (int i = 0; i < 3; ++i) {
    left[i] = clip[i].x < -clip[i].w;
    right[i] = clip[i].x > clip[i].w;
    below[i] = clip[i].y < -clip[i].w;
    above[i] = clip[i].y > clip[i].w;
    behind[i] = clip[i].w <= 0.0;
  }
  return !(all(left) || all(right) || all(below) || all(above) || all(behind));
}

bool isSeen(mat3 corners) {
  for (uint view = 0u; view < viewCount; ++view)
    if (seenBy(view, corners)) return true;
  return false;
}

// Whether slots have room for what the views want of it.
bool fits(mat3 corners, float scale) {
  for (uint view = 0u; view < viewCount; ++view) {
    vec3 at = views[view].eye.xyz;
    TessMeasure seen = measureTriangle(corners[0] - at, corners[1] - at, corners[2] - at, views[view].eye.w);
    if (scaleWithin(seen, scale, limits) < scale) return false;
  }
  return true;
}

bool piecesFit(mat3 corners, uint n, float scale) {
  for (uint index = 0u; index < n * n; ++index) {
    mat3 part = corners * pieceCorners(SplitPiece(index, n));
    if (isSeen(part) && !fits(part, scale)) return false;
  }
  return true;
}

uint piecesFor(mat3 corners, float scale) {
  if (fits(corners, scale)) return 1u;
  uint n = 2u;
  while (n < kSplitMost && !piecesFit(corners, n, scale)) n += n;
  return n;
}

// The numbers of a triangle's pieces, as a block of them; kSplitBlocks where all are taken.
uint takeBlock() {
  int left = atomicAdd(split.freeCount, -1);
  return left > 0 ? split.freeBlocks[left - 1] : kSplitBlocks;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= visibleCount) return;
  viewCount = atlas.config.views;
  limits = atlas.config.limits;
  uint triangles = atlas.config.triangles;
  uint number = visibleIds[i];
  elementIds[i] = number;
  SceneTriangle triangle = sceneTriangle(number);
  mat3 corners = worldCorners(triangle);
  uint held = states[number].split;
  float scale = exp2(-0.5 * (atlas.config.constantBias + atlas.bias));
  uint n = piecesFor(corners, scale);
  if (held != 0u && n < splitCount(held)) n = max(n, min(splitCount(held), piecesFor(corners, scale * kKeeps)));
  uint block = held != 0u ? splitBlock(held) : kSplitBlocks;
  if (n > 1u && held == 0u) block = takeBlock();
  if (block == kSplitBlocks) return;
  states[number].split = n > 1u ? packSplit(n, block) : 0u;
  split.owners[block] = n > 1u ? number : kNoEntry;
  if (n == 1u) return;
  uint batch = instances[triangle.instance].batch;
  uint seen = 0u;
  for (uint index = 0u; index < n * n; ++index) {
    SplitPiece piece = SplitPiece(index, n);
    uint at = block * kSplitBlock + index;
    uint pieceNumber = triangles + at;
    entryOfTriangle[pieceNumber] = kNoEntry;  // until it is emitted
    if (!isSeen(corners * pieceCorners(piece))) continue;
    splitPieces[at] = TessPieceGpu(number, packPiece(n, index), uFrame, 0u);
    elementIds[atomicAdd(elementCount, 1u)] = pieceNumber;
    ++seen;
  }
  // Room for one at least: display's list of split triangles is as long.
  atomicAdd(piecesOfBatch[batch], max(seen, 1u));
}
