// Shades a batch's part of the queue, a group a tile and a thread a texel; or the records of its patches, a thread
// each.
#define SURFACE_STEPS
#include "shared/bindings.h"
#include "shared/blocks.h"
#include "shared/texel.h"
#include "lib/shade.glsl"
#include "lib/triangle.glsl"
#include "lib/tess_store.glsl"

layout(local_size_x = TEXEL_GROUP) in;
layout(binding = 0) writeonly uniform image2D uAtlasImage;
layout(std430, binding = BIND_NORMALS) readonly buffer Normals { float normals[]; };
layout(std430, binding = BIND_TEXEL_BATCHES) readonly buffer Batches { TexelBatch batches[]; };
layout(std430, binding = BIND_TEXEL_QUEUE) readonly buffer Queue { TexelTile queue[]; };
layout(std430, binding = BIND_GATHER_VERTICES) readonly buffer GatherVertices { GatherVertex gatherVertices[]; };
#ifdef NORMAL_TEX
layout(std430, binding = BIND_TANGENTS) readonly buffer Tangents { vec4 tangents[]; };
#endif
#ifdef USES_UV0
layout(std430, binding = BIND_UV0) readonly buffer Uv0 { vec2 uv0[]; };
#endif
#ifdef USES_UV1
layout(std430, binding = BIND_UV1) readonly buffer Uv1 { vec2 uv1[]; };
#endif
#ifdef VERTEX_COLOR
layout(std430, binding = BIND_COLORS) readonly buffer Colors { vec4 colors[]; };
#endif
layout(location = LOCATION_COUNT) uniform uint uBatch;
layout(location = LOCATION_FRAME) uniform uint uRecords;  // 1 + the first row of records, or 0 for tiles

vec3 normalOf(uint v) { return vec3(normals[3u * v], normals[3u * v + 1u], normals[3u * v + 2u]); }

uint trianglesOf(uint patchId) {
  InstanceGpu instance = instances[instanceOfPatch[patchId]];
  return patches[instance.patchOffset + patchId - instance.patchBase].triangles;
}

// The patch at a place of its chart; texels are `between` apart.
vec4 shadeChart(uint patchId, uint triangles, vec2 at, vec2 between) {
  uint part = chartPart(triangles, at);
  SceneTriangle triangle = sceneTriangle(4u * patchId + part);
  InstanceGpu instance = instances[triangle.instance];
  bool mirrored = (instance.flags & kInstanceMirrored) != 0u;
  uint turn = mirrored ? 1u : 0u;
  vec2 p0 = chartCorner(triangles, 0u);
  vec2 p1 = chartCorner(triangles, part + 1u + turn);
  vec2 p2 = chartCorner(triangles, part + 2u - turn);
  vec3 b = chartBarycentrics(p0, p1, p2, at);
  vec3 c0 = worldCorner(triangle, triangle.vertex0);
  vec3 c1 = worldCorner(triangle, triangle.vertex1);
  vec3 c2 = worldCorner(triangle, triangle.vertex2);

  Surface s;
  s.position = b.x * c0 + b.y * c1 + b.z * c2;
  s.normal = transformNormal(
      instance, b.x * normalOf(triangle.vertex0) + b.y * normalOf(triangle.vertex1) + b.z * normalOf(triangle.vertex2));
#if defined(USES_UV0) || defined(USES_UV1)
  mat3 steps = mat3(chartBarycentrics(p0, p1, p2, at + vec2(between.x, 0.0)) - b,
                    chartBarycentrics(p0, p1, p2, at + vec2(0.0, between.y)) - b, vec3(0.0));
#endif
#ifdef NORMAL_TEX
  vec4 tangent = b.x * tangents[triangle.vertex0] + b.y * tangents[triangle.vertex1] + b.z * tangents[triangle.vertex2];
  s.tangent = vec4(transformDirection(instance, tangent.xyz), mirrored ? -tangent.w : tangent.w);
#endif
#ifdef USES_UV0
  mat3x2 corners0 = mat3x2(uv0[triangle.vertex0], uv0[triangle.vertex1], uv0[triangle.vertex2]);
  s.uv0 = corners0 * b;
  for (int i = 0; i < 3; ++i) s.uv0Steps[i] = corners0 * steps[i];
#endif
#ifdef USES_UV1
  mat3x2 corners1 = mat3x2(uv1[triangle.vertex0], uv1[triangle.vertex1], uv1[triangle.vertex2]);
  s.uv1 = corners1 * b;
  for (int i = 0; i < 3; ++i) s.uv1Steps[i] = corners1 * steps[i];
#endif
#ifdef VERTEX_COLOR
  s.color = b.x * colors[triangle.vertex0] + b.y * colors[triangle.vertex1] + b.z * colors[triangle.vertex2];
#endif
#ifdef DOUBLE_SIDED
  s.side = dot(cross(c1 - c0, c2 - c0), view.eye.xyz - c0) >= 0.0 ? 1.0 : -1.0;
#endif
  return shadeSurface(s, baseColorOf(s));
}

void shadeTile() {
  uint number = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  if (number >= batches[uBatch].tiles) return;
  TexelTile item = queue[batches[uBatch].firstTile + number];
  uvec2 inTile = uvec2(gl_LocalInvocationIndex % kTexelTile, gl_LocalInvocationIndex / kTexelTile);
  uvec2 texel = kTexelCells * uvec2(tileX(item.tile), tileY(item.tile)) + inTile;
  uint level = tileLevel(item.tile);
  uvec2 cells = uvec2(cellsAlong(tileChartX(item.tile), level), cellsAlong(tileChartY(item.tile), level));
  uint triangles = trianglesOf(item.patchId);
  if (!texelNeeded(triangles, texel.x, texel.y, cells.x, cells.y)) return;
  uint columns = uint(imageSize(uAtlasImage).x) / kTexelTile;
  uvec2 corner = kTexelTile * uvec2(item.slot % columns, item.slot / columns);
  vec2 between = 1.0 / vec2(cells);
  imageStore(uAtlasImage, ivec2(corner + inTile),
             atlasValue(shadeChart(item.patchId, triangles, vec2(texel) * between, between)));
}

void shadeRecord() {
  uint entry = gl_GlobalInvocationID.x;
  if (entry >= batches[uBatch].entries) return;
  uint patchId = gatherVertices[4u * (batches[uBatch].firstEntry + entry)].instance;
  if ((patchId & kChartRepeated) != 0u) return;
  uint triangles = trianglesOf(patchId);
  uint width = uint(imageSize(uAtlasImage).x);
  vec2 middle = triangles == 1u ? vec2(2.0 / 3.0, 1.0 / 3.0) : vec2(0.5);
  imageStore(uAtlasImage, ivec2(patchId % width, uRecords - 1u + patchId / width),
             atlasValue(shadeChart(patchId, triangles, middle, vec2(1.0))));
}

void main() {
  if (uRecords == 0u) shadeTile();
  else shadeRecord();
}
