// Where the corners of a patch sit in its block, and what the gather and display passes draw.
#ifndef TESSERA_GLSL_SHARED_BLOCKS_H
#define TESSERA_GLSL_SHARED_BLOCKS_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN

// A vertex of the visible set with its place in the atlas: all that display needs. 20 bytes.
struct DisplayVertex {
  float x;  // world, relative to the anchor
  float y;
  float z;
  uint texel;  // atlas coordinates in half texels: x in bits 0-15, y in bits 16-31
  uint block;  // log2 of its block's width in bits 0-3, of its height in bits 4-7
};

// What shading needs besides: the vertex whose attributes it takes, and how its corner meets the block's edge.
struct GatherVertex {
  uint vertex;    // index into the scene's vertices
  uint instance;  // InstanceGpu << 6 | corner bits
};

SHARED_CONST uint kCornerSideX = 0u;      // bits 0-1: 0 left edge, 1 middle, 2 right edge
SHARED_CONST uint kCornerSideY = 2u;      // bits 2-3: 0 top edge, 1 middle, 2 bottom edge
SHARED_CONST uint kCornerSingleX = 4u;    // bit 4: the block is one texel wide
SHARED_CONST uint kCornerSingleY = 5u;    // bit 5: the block is one texel high
SHARED_CONST uint kCornerBits = 6u;

struct DrawCommand {
  uint count;
  uint instanceCount;
  uint firstIndex;
  uint baseVertex;
  uint baseInstance;
};

// A run of patch instances that share material and draw state. Draw entries of batch b are
// firstEntry .. firstEntry + count / 6 - 1, four vertices and two triangles each.
struct BatchGpu {
  uint firstEntry;
  uint entryCapacity;
};

// Block coordinate of a corner along one axis, in half texels from the block's start, where bilinear filtering stays
// inside the block: half a texel in from the edges, the middle of a block of one texel (Mueller 2021, sec. 3.3).
// side: 0 low edge, 1 middle, 2 high edge; log2Size: the block's size along the axis.
SHARED_FN uint cornerHalfTexel(uint side, uint log2Size) {
  uint size = 1u << log2Size;
  if (log2Size == 0u) return 1u;
  return side == 0u ? 1u : (side == 1u ? size : 2u * size - 1u);
}

// The first texel of the block that a half-texel coordinate lies in: blocks are aligned to their size.
SHARED_FN uint blockStart(uint halfTexel, uint log2Size) { return ((halfTexel >> 1u) >> log2Size) << log2Size; }

// Where bilinear filtering stays in a block: its lowest and highest places, in texels. halfTexel: of any of its corners.
SHARED_FN vec4 insideOfBlock(uvec2 halfTexel, uvec2 log2Size) {
  vec2 start = vec2(float(blockStart(halfTexel.x, log2Size.x)), float(blockStart(halfTexel.y, log2Size.y)));
  vec2 end = start + vec2(float(1u << log2Size.x), float(1u << log2Size.y));
  return vec4(start.x + 0.5, start.y + 0.5, end.x - 0.5, end.y - 0.5);
}

// How far past its texel centre an edge corner is drawn when shading, in texels. The rasterizer's fill rule leaves the
// texels exactly on the right and bottom edges out; four steps of the 8-bit subpixel grid bring them in, and shift the
// sample by at most this much of a texel. A block of one texel is drawn edge to edge.
SHARED_CONST float kGatherMargin = 1.0 / 64.0;

// Where a corner is drawn when shading, in texels, from its half-texel coordinate.
SHARED_FN float gatherCoordinate(uint halfTexel, uint side, bool single) {
  float outward = side == 0u ? -1.0 : (side == 1u ? 0.0 : 1.0);
  return 0.5 * float(halfTexel) + outward * (single ? 0.5 : kGatherMargin);
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::DisplayVertex) == 20);
static_assert(sizeof(tessera::glsl::GatherVertex) == 8);
static_assert(sizeof(tessera::glsl::DrawCommand) == 20);
static_assert(sizeof(tessera::glsl::BatchGpu) == 8);
#endif
#endif
