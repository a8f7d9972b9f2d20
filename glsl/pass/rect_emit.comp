// Writes what shading and display draw: for each visible patch four corners with their world place and their place in
// the atlas, binned by batch so that a batch is one draw. A triple has two entries, one behind the other.
// CHARTS: their place in the patch's chart, in halves of its sides, and the patch; see shared/texel.h.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/blocks.h"
#include "shared/levels.h"
#include "shared/rect_memory.h"
#ifdef CHARTS
#include "shared/texel.h"
#endif

layout(local_size_x = 64) in;
layout(std430, binding = BIND_POSITIONS) readonly buffer Positions { float positions[]; };
layout(std430, binding = BIND_INSTANCES) readonly buffer Instances { InstanceGpu instances[]; };
layout(std430, binding = BIND_PATCHES) readonly buffer Patches { PatchGeometry patches[]; };
layout(std430, binding = BIND_PATCH_INSTANCE) readonly buffer PatchInstances { uint instanceOfPatch[]; };
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };
#ifndef CHARTS
layout(std430, binding = BIND_PATCH_STATE) readonly buffer PatchStates { PatchState patchStates[]; };
#endif
layout(std430, binding = BIND_BATCHES) readonly buffer Batches { BatchGpu batches[]; };
layout(std430, binding = BIND_DRAW_COMMANDS) buffer DrawCommands { DrawCommand commands[]; };
layout(std430, binding = BIND_DRAW_ENTRIES) writeonly buffer DrawEntries { uint entryOfPatch[]; };
layout(std430, binding = BIND_DRAW_VERTICES) writeonly buffer DrawVertices { DisplayVertex drawVertices[]; };
layout(std430, binding = BIND_GATHER_VERTICES) writeonly buffer GatherVertices { GatherVertex gatherVertices[]; };

// A visible patch on its way to draw entries.
struct Placed {
  InstanceGpu instance;
#ifdef CHARTS
  uint chart;  // the patch, and whether this is another entry of it
};
#else
  uint instanceIndex;
  uint origin;       // of its block, see PatchState
  uvec2 log2Size;    // of its block, along the atlas's axes
  bool transposed;   // the patch's x axis runs along the block's y
};
#endif

// side: corner of the patch's own axes, 0 low, 1 middle, 2 high.
void writeCorner(Placed placed, uint slot, uint vertex, uvec2 side) {
  vec3 local = vec3(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
  vec3 p = transformPoint(placed.instance, local);
#ifdef CHARTS
  drawVertices[slot] = DisplayVertex(p.x, p.y, p.z, side.x | (side.y << 16u), 0u);
  gatherVertices[slot] = GatherVertex(vertex, placed.chart);
#else
  if (placed.transposed) side = uvec2(side.y, side.x);
  uvec2 corner = unpackOrigin(placed.origin);
  uint x = 2u * corner.x + cornerHalfTexel(side.x, placed.log2Size.x);
  uint y = 2u * corner.y + cornerHalfTexel(side.y, placed.log2Size.y);
  drawVertices[slot] = DisplayVertex(p.x, p.y, p.z, x | (y << 16u), placed.log2Size.x | (placed.log2Size.y << 4u));
  uint bits = (side.x << kCornerSideX) | (side.y << kCornerSideY) |
              (placed.log2Size.x == 0u ? 1u << kCornerSingleX : 0u) |
              (placed.log2Size.y == 0u ? 1u << kCornerSingleY : 0u);
  gatherVertices[slot] = GatherVertex(vertex, (placed.instanceIndex << kCornerBits) | bits);
#endif
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= visibleCount) return;
  uint patchId = visibleIds[i];
  uint index = instanceOfPatch[patchId];
  InstanceGpu instance = instances[index];
#ifdef CHARTS
  Placed placed = Placed(instance, patchId);
#else
  PatchState state = patchStates[patchId];
  Placed placed = Placed(instance, index, state.origin, uvec2(levelWidth(state.level), levelHeight(state.level)),
                         levelTransposed(state.level));
#endif
  PatchGeometry geometry = patches[instance.patchOffset + patchId - instance.patchBase];
  bool mirrored = (instance.flags & kInstanceMirrored) != 0u;
  uint parts = geometry.triangles == 3u ? 2u : 1u;
  uint entry = batches[instance.batch].firstEntry + atomicAdd(commands[instance.batch].count, 6u * parts) / 6u;
  entryOfPatch[patchId] = entry | (mirrored ? 0x80000000u : 0u);
  // Mirrored instances swap corners 1 and 3: every entry is counter-clockwise in the world.
  uint slot = 4u * entry;
  uint one = mirrored ? 3u : 1u;
  uint three = mirrored ? 1u : 3u;
  bool triple = parts == 2u;
  writeCorner(placed, slot, geometry.v0, triple ? uvec2(1u, 0u) : uvec2(0u, 0u));
  writeCorner(placed, slot + one, geometry.v1, uvec2(2u, 0u));
  writeCorner(placed, slot + 2u, geometry.v2, uvec2(2u, 2u));
  writeCorner(placed, slot + three, geometry.v3, uvec2(0u, 2u));
  if (triple) {
#ifdef CHARTS
    placed.chart |= kChartRepeated;
#endif
    // The third triangle (v0, v3, v4), and an empty one.
    writeCorner(placed, slot + 4u, geometry.v0, uvec2(1u, 0u));
    writeCorner(placed, slot + 4u + (mirrored ? 2u : 1u), geometry.v3, uvec2(0u, 2u));
    writeCorner(placed, slot + 4u + (mirrored ? 1u : 2u), geometry.v4, uvec2(0u, 0u));
    writeCorner(placed, slot + 7u, geometry.v0, uvec2(1u, 0u));
  }
}
