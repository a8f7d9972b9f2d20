// What the vertex stages of forward and gather hand to shade.frag. One text, so both shade the same.
#ifdef STAGE_VERTEX
#define VARYING out
#else
#define VARYING in
#endif
layout(location = 0) VARYING vec3 vPosition;  // relative to the anchor
layout(location = 1) VARYING vec3 vNormal;
#ifdef NORMAL_TEX
layout(location = 2) VARYING vec4 vTangent;
#endif
#ifdef USES_UV0
layout(location = 3) VARYING vec2 vUv0;
#endif
#ifdef USES_UV1
layout(location = 4) VARYING vec2 vUv1;
#endif
#ifdef VERTEX_COLOR
layout(location = 5) VARYING vec4 vColor;
#endif
#if defined(DOUBLE_SIDED) && defined(GATHER)
// +1 where the eye sees the front of the triangle, -1 where it sees the back. Forward has gl_FrontFacing for that.
layout(location = 6) flat VARYING float vFacing;
#endif
