// The display stage of the tessellation gatherer: a fragment's place in its triangle's samples, and one fetch. LIST is the
// list that is drawn, see kDisplayAffine.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "shared/tess_atlas.h"
#include "lib/mask.glsl"
#include "lib/tess_place.glsl"

layout(binding = UNIT_ATLAS) uniform sampler2D uAtlas;
layout(location = LOCATION_SIZE) uniform vec2 uTexelToUv;  // 1 / size of the atlas texture
layout(location = 2) in vec4 vPoint;
layout(location = 3) flat in uvec2 vPlace;
layout(location = 0) out vec4 oColor;

vec2 atlasTexel() {
#if LIST == 0
  bool far = vPoint.y >= 0.0;
  // A fragment's centre lies in the triangle but for rounding.
  vec2 at = max(vec2(far ? vPoint.y : vPoint.x, vPoint.z), vec2(0.0)) / vPoint.w;
  uint place = far ? vPlace.y : vPlace.x;
  return overAtlasAt(at, uvec2(placeX(place), placeY(place)), placeTurned(place) != 0u);
#elif LIST == 1
  vec2 at = L_DECODE(evenOf(vPoint.xyz), vPlace.y);
  return lAtlasAt(at, uvec2(placeX(vPlace.x), placeY(vPlace.x)), vPlace.y, placeTurned(vPlace.x) != 0u);
#else
  return atlasOfEntry(vPlace.x, vPoint.xyz);
#endif
}

void main() {
#ifdef MASK
  if (maskedOut()) discard;
#endif
  oColor = vec4(textureLod(uAtlas, atlasTexel() * uTexelToUv, 0.0).rgb, 1.0);
}
