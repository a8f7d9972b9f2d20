// Writes what shading and display draw, binned by batch so that a batch is one draw: for each visible triangle, and each
// piece of one, an entry and three corners; and for each triangle three more in the list that it is displayed from.
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
layout(std430, binding = BIND_TESS_CORNERS) writeonly buffer Corners { TessCorner displayCorners[]; };
layout(std430, binding = BIND_TESS_PIECES) writeonly buffer Pieces { uvec2 pieces[]; };
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu views[TESS_VIEWS]; };
layout(location = LOCATION_COUNT) uniform uint uBatches;
layout(location = LOCATION_FRAME) uniform uint uTriangles;

// Where texel (0, 0) of a half's block lies.
uint cornerPlace(OverShape over, uint side, TessState state) {
  uint place = side == 0u ? state.place0 : state.place1;
  bool turned = placeTurned(place) != 0u;
  uvec2 texel = overCorner(uvec2(placeX(place), placeY(place)), overColumns(over, side), over.rows, turned);
  return packPlace(texel.x, texel.y, turned ? 1u : 0u);
}

// Where in its list's buffer a triangle goes. The affine list fills its batch's range from the start and Ls fill it from
// the end; behind that is room for split ones, since each has a piece at least.
uint displayPlace(uint list, uint batch) {
  uint command = (3u + list) * uBatches + batch;
  uint before = atomicAdd(commands[command].count, 3u);
  return list == kDisplayL ? atomicAdd(commands[command].first, uint(-3)) - 3u : commands[command].first + before;
}

void emitDisplay(uint entry, uint batch, TessState state, uvec3 vertices, mat3 corners, vec3 weights) {
  uint kind = kindOf(state.shape.kind);
  uint list = state.split != 0u ? kDisplaySplit : (kind == kTessL ? kDisplayL : kDisplayAffine);
  uint first = displayPlace(list, batch);
  OverShape over = overOfShape(state.shape);
  // A triangle of one half has it on either side.
  uint near = over.columns0 > 0u ? 0u : 1u;
  uint far = over.columns1 > 0u ? 1u : 0u;
  bool halves = list == kDisplayAffine && kind == kTessOver;
  uint place0 = list == kDisplaySplit ? entry : (halves ? cornerPlace(over, near, state) : state.place0);
  uint place1 = list == kDisplayL ? levelOfKind(state.shape.kind) : (halves ? cornerPlace(over, far, state) : state.place0);
  for (uint c = 0u; c < 3u; ++c) {
    vec3 at = vec3(0.0);
    if (halves) at = vec3(overCornerAt(c, near, over).x, overCornerAt(c, far, over));
    else if (list != kDisplayAffine) at[c] = 1.0;
    at *= weights[c];
    displayCorners[first + c] = TessCorner(corners[c].x, corners[c].y, corners[c].z, weights[c], at.x, at.y, at.z, place0,
                                           place1, vertices[c]);
  }
}

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
  vec3 at = views[0].eye.xyz;
  // A split triangle's own samples are for views from elsewhere, and may reach around the eye: even on its plane.
#ifdef SURFACE_SAMPLES
  vec3 w = vec3(1.0);
#else
  vec3 w = state.split != 0u ? vec3(1.0) : depthWeights(element.corners[0] - at, element.corners[1] - at, element.corners[2] - at);
#endif
  for (uint c = 0u; c < 3u; ++c)
    drawVertices[3u * entry + c] = TessVertex(element.corners[c].x, element.corners[c].y, element.corners[c].z, w[c]);
  // The whole triangle is drawn, so that its edges are those of its neighbours; its pieces are only sampled.
  if (element.piece == 0u)
    emitDisplay(entry, batch, state, uvec3(triangle.vertex0, triangle.vertex1, triangle.vertex2), element.corners, w);
}
