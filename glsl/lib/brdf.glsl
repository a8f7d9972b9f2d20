// Metallic-roughness reflection: GGX distribution, height-correlated Smith visibility, Schlick Fresnel, Lambert
// diffuse (glTF 2.0, appendix B; Heitz 2014; Schlick 1994).
const float kBrdfPi = 3.14159265358979;

// The smallest alpha: below it the distribution's peak leaves float32, and the lobe is smaller than any light.
const float kMinAlpha = 0.0016;

struct Lobe {
  vec3 diffuse;   // albedo of the diffuse part
  vec3 f0;        // reflectance at normal incidence
  float alpha;    // roughness squared
};

vec3 reflectLight(Lobe lobe, vec3 n, vec3 v, vec3 l, float nv, float nl) {
  vec3 h = safeNormalize(v + l, n);
  float nh = clamp(dot(n, h), 0.0, 1.0);
  float vh = clamp(dot(v, h), 0.0, 1.0);
  float a2 = lobe.alpha * lobe.alpha;
  // 1 - nh^2 by the cross product keeps its digits where nh is near 1 and the peak is narrow.
  vec3 nxh = cross(n, h);
  float d0 = dot(nxh, nxh) + nh * nh * a2;
  float distribution = a2 / (kBrdfPi * d0 * d0);
  float visibility = 0.5 / max(nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2), 1e-6);
  float m = 1.0 - vh;
  float m2 = m * m;
  vec3 fresnel = lobe.f0 + (1.0 - lobe.f0) * (m2 * m2 * m);
  return (1.0 - fresnel) * lobe.diffuse * (1.0 / kBrdfPi) + fresnel * (distribution * visibility);
}

// A split-sum fit of the environment's specular share without a table (Karis 2014, mobile form).
vec3 ambientSpecular(vec3 f0, float roughness, float nv) {
  vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float a004 = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
  vec2 ab = vec2(-1.04, 1.04) * a004 + r.zw;
  return f0 * ab.x + ab.y;
}
