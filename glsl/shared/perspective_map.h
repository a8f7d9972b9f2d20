// placeholder until the checked formulas arrive
#ifndef TESSERA_GLSL_SHARED_PERSPECTIVE_MAP_H
#define TESSERA_GLSL_SHARED_PERSPECTIVE_MAP_H
#include "shared/dialect.h"
#include "shared/levels.h"
TESSERA_SHARED_BEGIN
SHARED_CONST float kLeastWeight = 1.0e-4;
SHARED_FN vec3 perspectiveWeights(vec3 v0, vec3 v1, vec3 v2) {
  vec3 axis = v0 + v1 + v2;
  vec3 w = vec3(dot(v0, axis), dot(v1, axis), dot(v2, axis));
  float most = max(w.x, max(w.y, w.z));
  if (!isFiniteNumber(most) || !(most > 0.0)) return vec3(1.0);
  w = w / most;
  return vec3(max(w.x, kLeastWeight), max(w.y, kLeastWeight), max(w.z, kLeastWeight));
}
SHARED_FN vec3 surfaceOfEven(vec3 p, vec3 w) {
  vec3 q = p / w;
  return q / (q.x + q.y + q.z);
}
TESSERA_SHARED_END
#endif
