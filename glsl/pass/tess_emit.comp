// Writes what shading and display draw: for each visible triangle, and each piece of one, an entry and three corners,
// binned by batch so that a batch is one draw.
#include "shared/scene.h"
#include "shared/blocks.h"
#include "shared/tess_measure.h"
#include "shared/bindings.h"
#include "shared/tess_atlas.h"
#include "lib/triangle.glsl"

layout(local_size_x = TESS_GROUP) in;
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_PATCH_STATE) readonly buffer States { TessState states[]; };
layout(std430, binding = BIND_BATCHES) readonly buffer Batches { BatchGpu batches[]; };
layout(std430, binding = BIND_DRAW_COMMANDS) buffer DrawCommands { TessCommand commands[]; };
layout(std430, binding = BIND_DRAW_ENTRIES) writeonly buffer DrawEntries { uint entryOfTriangle[]; };
layout(std430, binding = BIND_DRAW_VERTICES) writeonly buffer DrawVertices { TessVertex drawVertices[]; };
layout(std430, binding = BIND_GATHER_VERTICES) writeonly buffer Entries { TessEntry entries[]; };
layout(std430, binding = BIND_TESS_PIECES) writeonly buffer Pieces { uvec2 pieces[]; };
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu views[TESS_VIEWS]; };
layout(location = LOCATION_COUNT) uniform uint uBatches;
layout(location = LOCATION_FRAME) uniform uint uTriangles;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= visibleCount) return;
  uint number = visibleIds[i];
  TriangleElement element = triangleElement(number, uTriangles);
  SceneTriangle triangle = element.triangle;
  TessState state = states[number];
  uint batch = instances[triangle.instance].batch;
  uint entry = batches[batch].firstEntry + atomicAdd(commands[batch].count, 3u) / 3u;
  atomicAdd(commands[uBatches + batch].count, 12u);
  // For gathering by tessellation: a piece for as many samples as it spawns at once.
  uint samples = kindOf(state.shape.kind) == kTessL && levelOfKind(state.shape.kind) <= kTessLargest
                     ? 1u : texelsOfShape(state.shape);
  uint parts = (samples + kTessMostSamples - 1u) / kTessMostSamples;
  uint piece = commands[2u * uBatches + batch].first + atomicAdd(commands[2u * uBatches + batch].count, parts);
  for (uint part = 0u; part < parts; ++part) pieces[piece + part] = uvec2(entry, part * kTessMostSamples);
  entryOfTriangle[number] = entry;
  entries[entry] = TessEntry(state.shape, state.place0, state.place1, triangle.vertex0, triangle.vertex1,
                             triangle.vertex2, triangle.instance, element.piece, splitCount(state.split),
                             uTriangles + kSplitBlock * splitBlock(state.split));
  vec3 p0 = element.corners[0];
  vec3 p1 = element.corners[1];
  vec3 p2 = element.corners[2];
  vec3 at = views[0].eye.xyz;
  // A split triangle's own samples are for views from elsewhere, and may reach around the eye: even on its plane.
  vec3 w = state.split != 0u ? vec3(1.0) : depthWeights(p0 - at, p1 - at, p2 - at);
  drawVertices[3u * entry] = TessVertex(p0.x, p0.y, p0.z, w.x);
  drawVertices[3u * entry + 1u] = TessVertex(p1.x, p1.y, p1.z, w.y);
  drawVertices[3u * entry + 2u] = TessVertex(p2.x, p2.y, p2.z, w.z);
}
