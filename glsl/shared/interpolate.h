// Where a view ray meets a triangle, as barycentric coordinates.
#ifndef TESSERA_GLSL_SHARED_INTERPOLATE_H
#define TESSERA_GLSL_SHARED_INTERPOLATE_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN

// Perspective-correct barycentric coordinates of the ray (from the origin, along `ray`, any length) in the triangle
// a, b, c, given relative to the origin. The three numbers are signed volumes (Moeller and Trumbore 1997 in its
// symmetric form): no division by the plane's distance, so an eye in the plane of the triangle gives finite numbers.
// They sum to 1. A triangle seen edge-on (volumes that cancel) gives its first corner. Each volume is taken about the
// edge's own start, cross(p, q) = cross(p, q - p): far-away small triangles keep their digits.
SHARED_FN vec3 rayBarycentrics(vec3 ray, vec3 a, vec3 b, vec3 c) {
  vec3 volumes = vec3(dot(ray, cross(b, c - b)), dot(ray, cross(c, a - c)), dot(ray, cross(a, b - a)));
  float sum = volumes.x + volumes.y + volumes.z;
  if (sum == 0.0) return vec3(1.0, 0.0, 0.0);
  return volumes / sum;
}

TESSERA_SHARED_END
#endif
