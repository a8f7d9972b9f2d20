// The normal matrix as cofactors: no inverse, so singular scales stay finite, and mirrored ones keep their side.
vec3 transformNormal(InstanceGpu instance, vec3 n) {
  vec3 a = instance.row0.xyz;
  vec3 b = instance.row1.xyz;
  vec3 c = instance.row2.xyz;
  vec3 transformed = vec3(dot(cross(b, c), n), dot(cross(c, a), n), dot(cross(a, b), n));
  return (instance.flags & kInstanceMirrored) != 0u ? -transformed : transformed;
}

vec3 transformDirection(InstanceGpu instance, vec3 d) {
  return vec3(dot(instance.row0.xyz, d), dot(instance.row1.xyz, d), dot(instance.row2.xyz, d));
}

// A vector of length 1, or `fallback` where v has no direction.
vec3 safeNormalize(vec3 v, vec3 fallback) {
  float longest = max(abs(v.x), max(abs(v.y), abs(v.z)));
  if (!(longest > 0.0) || isinf(longest)) return fallback;
  v /= longest;  // keeps the squares of tiny and huge vectors in range
  return v * inversesqrt(dot(v, v));
}
