// Shading of the forward renderer's fragments, and of the rectangular atlas's texels (GATHER).
#include "shared/bindings.h"
#include "lib/varyings.glsl"
#include "lib/shade.glsl"

layout(location = 0) out vec4 oColor;

void main() {
  Surface s;
  s.position = vPosition;
  s.normal = vNormal;
#ifdef NORMAL_TEX
  s.tangent = vTangent;
#endif
#ifdef USES_UV0
  s.uv0 = vUv0;
#endif
#ifdef USES_UV1
  s.uv1 = vUv1;
#endif
#ifdef VERTEX_COLOR
  s.color = vColor;
#endif
#if defined(DOUBLE_SIDED) && defined(GATHER)
  s.side = vFacing;
#elif defined(DOUBLE_SIDED)
  s.side = gl_FrontFacing ? 1.0 : -1.0;
#endif
  vec4 base = baseColorOf(s);
#if defined(MASK) && !defined(GATHER)
  if (base.a < material.emissive.a) discard;
#endif
  oColor = shadeSurface(s, base);
}
