// Vertices of the forward renderer, from plain vertex attributes.
#define STAGE_VERTEX
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/normal.h"
#include "lib/varyings.glsl"

#include "lib/instance.glsl"
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu view; };

layout(location = 0) in vec3 aPosition;
layout(location = 1) in vec3 aNormal;
#ifdef NORMAL_TEX
layout(location = 2) in vec4 aTangent;
#endif
#ifdef USES_UV0
layout(location = 3) in vec2 aUv0;
#endif
#ifdef USES_UV1
layout(location = 4) in vec2 aUv1;
#endif
#ifdef VERTEX_COLOR
layout(location = 5) in vec4 aColor;
#endif

// The depth pre-pass and the id pass must give bit-equal depths.
invariant gl_Position;

void main() {
  InstanceGpu instance = drawnInstance();
  vPosition = transformPoint(instance, aPosition);
  gl_Position = view.viewProjection * vec4(vPosition, 1.0);
  vNormal = transformNormal(instance, aNormal);
#ifdef NORMAL_TEX
  vTangent = vec4(transformDirection(instance, aTangent.xyz),
                  (instance.flags & kInstanceMirrored) != 0u ? -aTangent.w : aTangent.w);
#endif
#ifdef USES_UV0
  vUv0 = aUv0;
#endif
#ifdef USES_UV1
  vUv1 = aUv1;
#endif
#ifdef VERTEX_COLOR
  vColor = aColor;
#endif
}
