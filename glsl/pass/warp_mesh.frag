#include "shared/bindings.h"

layout(binding = UNIT_PICTURE) uniform sampler2D uPicture;
layout(location = 0) in vec2 vPlace;
layout(location = 0) out vec4 oColor;

void main() { oColor = textureLod(uPicture, vPlace, 0.0); }
