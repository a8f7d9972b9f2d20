// Time warping (Van Waveren 2016): the picture turned as the view turned, as if all of it were at infinity. Beyond its
// edges they go on.
#include "shared/bindings.h"

layout(binding = UNIT_PICTURE) uniform sampler2D uPicture;
layout(location = LOCATION_WARP) uniform mat3 uToSource;  // (1, pixel) to (w, pixel w) of the picture, see image_warp.cpp
layout(location = LOCATION_BACKGROUND) uniform vec4 uBackground;
layout(location = 0) out vec4 oColor;

void main() {
  vec3 place = uToSource * vec3(1.0, gl_FragCoord.xy);
  oColor = uBackground;
  if (place.x > 0.0) oColor = textureLod(uPicture, place.yz / place.x / vec2(textureSize(uPicture, 0)), 0.0);
  gl_FragDepth = 0.0;  // of nothing it knows the distance
}
