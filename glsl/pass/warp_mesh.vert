// A mesh of a depth buffer, seen from elsewhere: a row of pixels an instance, a vertex a pixel's centre, and a border
// around them that carries the edges on outwards by the picture's size.
#include "shared/bindings.h"

layout(binding = UNIT_DEPTH) uniform sampler2D uDepth;  // reversed: near plane / distance
// Columns: clip space is c0 + x c1 + y c2 + depth c3 for pixel (x, y). This is the point divided by its distance, so a
// depth of 0 is a direction, and the place in the picture is interpolated as the homography between both views has it.
layout(location = LOCATION_VIEW) uniform mat4 uToClip;
layout(location = 0) out vec2 vPlace;  // in the picture, 0 to 1

void main() {
  ivec2 size = textureSize(uDepth, 0);
  ivec2 place = ivec2(gl_VertexID >> 1, gl_InstanceID + (gl_VertexID & 1)) - 1;
  ivec2 pixel = clamp(place, ivec2(0), size - 1);
  vec2 centre = vec2(pixel) + 0.5;
  float depth = texelFetch(uDepth, pixel, 0).r;
  gl_Position = uToClip * vec4(1.0, centre + vec2((place - pixel) * size), depth);
  vPlace = centre / vec2(size);
}
