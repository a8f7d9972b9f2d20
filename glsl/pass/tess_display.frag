// The display stage of the tessellation gatherer: decodes a fragment's place in its triangle, and one fetch.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "shared/tess_atlas.h"
#include "lib/mask.glsl"
#include "lib/tess_decode.glsl"

layout(binding = UNIT_ATLAS) uniform sampler2D uAtlas;
layout(location = LOCATION_SIZE) uniform vec2 uTexelToUv;  // 1 / size of the atlas texture
layout(location = 2) in vec3 vWeighted;
layout(location = 3) flat in uvec3 vShape;
layout(location = 4) flat in uvec2 vPlaces;
layout(location = 0) out vec4 oColor;

void main() {
#ifdef MASK
  if (maskedOut()) discard;
#endif
  // A fragment's centre lies in the triangle but for rounding.
  vec3 even = max(vWeighted, vec3(0.0));
  even /= max(even.x + even.y + even.z, 1e-30);
  oColor = vec4(textureLod(uAtlas, atlasOfEven(TessShape(vShape.x, vShape.y, vShape.z), vPlaces.x, vPlaces.y, even) * uTexelToUv, 0.0).rgb, 1.0);
}
