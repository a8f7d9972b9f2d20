// The display stage of the tessellation gatherer: decodes a fragment's place in its triangle, and one fetch.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "shared/tess_atlas.h"
#include "lib/mask.glsl"
#include "lib/tess_place.glsl"

layout(binding = UNIT_ATLAS) uniform sampler2D uAtlas;
layout(location = LOCATION_SIZE) uniform vec2 uTexelToUv;  // 1 / size of the atlas texture
layout(location = 2) in vec3 vWeighted;
layout(location = 3) flat in uvec3 vShape;
layout(location = 4) flat in uvec4 vPlaces;  // two places, whether it is split, entry
layout(location = 0) out vec4 oColor;

void main() {
#ifdef MASK
  if (maskedOut()) discard;
#endif
  vec2 texel = vPlaces.z != 0u ? atlasOfEntry(vPlaces.w, vWeighted)
                               : atlasOfEven(TessShape(vShape.x, vShape.y, vShape.z), vPlaces.x, vPlaces.y, evenOf(vWeighted));
  oColor = vec4(textureLod(uAtlas, texel * uTexelToUv, 0.0).rgb, 1.0);
}
