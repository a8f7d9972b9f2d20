// The display stage: one fetch from the atlas; the alpha test where the material asks for it.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "lib/mask.glsl"

layout(binding = UNIT_ATLAS) uniform sampler2D uAtlas;
layout(location = 2) in vec2 vAtlas;
layout(location = 0) out vec4 oColor;

void main() {
#ifdef MASK
  if (maskedOut()) discard;
#endif
  oColor = vec4(textureLod(uAtlas, vAtlas, 0.0).rgb, 1.0);
}
