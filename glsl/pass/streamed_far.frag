// What no triangle covers: the samples that pass here are counted.
#include "shared/bindings.h"
layout(location = LOCATION_BACKGROUND) uniform vec4 uBackground;
layout(location = 0) out vec4 oColor;
void main() { oColor = uBackground; }
