// Positions only: the id pass, the depth pre-pass and shadow maps.
// LAYERS: several views in one pass, a layer of the target each. Instances come once a view; their
// records step after the last view.
#ifdef LAYERS
#extension GL_ARB_shader_viewport_layer_array : require
#endif
#define STAGE_VERTEX
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "lib/mask_vertex.glsl"

#include "lib/instance.glsl"
#ifdef SHADOW_LAYER
layout(std140, binding = BIND_SHADOWS) uniform Shadows { ShadowGpu shadows[kMaxShadowLayers]; };
layout(location = LOCATION_VIEW) uniform uint uLayer;
#elif defined(LAYERS)
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu views[ID_VIEWS]; };
layout(location = LOCATION_COUNT) uniform uint uViews;
#else
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu view; };
#endif

layout(location = 0) in vec3 aPosition;
#if defined(MASK) && defined(BASE_TEX)
layout(location = 3) in vec2 aUv0;
#ifdef USES_UV1
layout(location = 4) in vec2 aUv1;
#endif
#endif
#if defined(MASK) && defined(VERTEX_COLOR)
layout(location = 5) in vec4 aColor;
#endif
#ifdef WRITE_ID
layout(location = 2) flat out uvec3 vPatches;  // patchBase, pairs, triples
#endif

invariant gl_Position;

void main() {
  InstanceGpu instance = drawnInstance();
  vec3 position = transformPoint(instance, aPosition);
#ifdef SHADOW_LAYER
  gl_Position = shadows[uLayer].viewProjection * vec4(position, 1.0);
#elif defined(LAYERS)
  uint layer = uint(gl_InstanceID) % uViews;
  gl_Position = views[layer].viewProjection * vec4(position, 1.0);
  gl_Layer = int(layer);
#else
  gl_Position = view.viewProjection * vec4(position, 1.0);
#endif
#ifdef WRITE_ID
  vPatches = uvec3(instance.patchBase, instance.pairs, instance.triples);
#endif
#ifdef MASK
#ifdef BASE_TEX
#ifdef USES_UV1
  writeMaskUv(aUv0, aUv1);
#else
  writeMaskUv(aUv0, aUv0);
#endif
#endif
#ifdef VERTEX_COLOR
  vMaskAlpha = aColor.a;
#endif
#endif
}
