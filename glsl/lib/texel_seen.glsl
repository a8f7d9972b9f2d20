// What a pixel of the id buffer sees of a patch's chart: its place, and how that changes to the next pixels of its
// quad, as the derivatives of a fragment shader do.
#include "shared/scene.h"
#include "shared/interpolate.h"
#include "shared/texel.h"
#include "lib/triangle.glsl"

struct ChartPoint {
  vec2 at;
  vec2 dx;
  vec2 dy;
};

ChartPoint chartPoint(uint id, ivec2 pixel, mat3 pixelToRay, vec3 eye) {
  SceneTriangle triangle = sceneTriangle(id - 4u);
  uint part = id & 3u;
  InstanceGpu instance = instances[triangle.instance];
  uint triangles = patches[instance.patchOffset + ((id >> 2u) - 1u) - instance.patchBase].triangles;
  uint turn = (instance.flags & kInstanceMirrored) != 0u ? 1u : 0u;
  mat3x2 corners = mat3x2(chartCorner(triangles, 0u), chartCorner(triangles, part + 1u + turn),
                          chartCorner(triangles, part + 2u - turn));
  vec3 a = worldCorner(triangle, triangle.vertex0) - eye;
  vec3 b = worldCorner(triangle, triangle.vertex1) - eye;
  vec3 c = worldCorner(triangle, triangle.vertex2) - eye;
  vec2 here = vec2(pixel) + 0.5;
  vec2 way = vec2(1 - 2 * (pixel & 1));
  vec3 w = rayBarycentrics(pixelToRay * vec3(1.0, here), a, b, c);
  vec3 wx = rayBarycentrics(pixelToRay * vec3(1.0, here.x + way.x, here.y), a, b, c);
  vec3 wy = rayBarycentrics(pixelToRay * vec3(1.0, here.x, here.y + way.y), a, b, c);
  ChartPoint point;
  point.dx = corners * (wx - w);
  point.dy = corners * (wy - w);
  // A pixel centre that the rasterizer gave to the triangle lies in it but for rounding.
  w = max(w, vec3(0.0));
  point.at = corners * (w / max(w.x + w.y + w.z, 1e-30));
  return point;
}
