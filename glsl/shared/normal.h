// Directions through an instance's matrix.
#ifndef TESSERA_GLSL_SHARED_NORMAL_H
#define TESSERA_GLSL_SHARED_NORMAL_H
#include "shared/dialect.h"
#include "shared/scene.h"
TESSERA_SHARED_BEGIN
#ifdef __cplusplus
using glm::abs;
using glm::cross;
using glm::dot;
using glm::inversesqrt;
using glm::isinf;
using glm::max;
#endif

SHARED_FN vec3 linearRow(vec4 row) { return vec3(row.x, row.y, row.z); }

// The normal matrix as cofactors: no inverse, so singular scales stay finite, and mirrored ones keep their side.
SHARED_FN vec3 transformNormal(InstanceGpu instance, vec3 n) {
  vec3 a = linearRow(instance.row0);
  vec3 b = linearRow(instance.row1);
  vec3 c = linearRow(instance.row2);
  vec3 transformed = vec3(dot(cross(b, c), n), dot(cross(c, a), n), dot(cross(a, b), n));
  return (instance.flags & kInstanceMirrored) != 0u ? -transformed : transformed;
}

SHARED_FN vec3 transformDirection(InstanceGpu instance, vec3 d) {
  return vec3(dot(linearRow(instance.row0), d), dot(linearRow(instance.row1), d), dot(linearRow(instance.row2), d));
}

// A vector of length 1, or `fallback` where v has no direction.
SHARED_FN vec3 safeNormalize(vec3 v, vec3 fallback) {
  float longest = max(abs(v.x), max(abs(v.y), abs(v.z)));
  if (!(longest > 0.0) || isinf(longest)) return fallback;
  v /= longest;  // keeps the squares of tiny and huge vectors in range
  return v * inversesqrt(dot(v, v));
}

TESSERA_SHARED_END
#endif
