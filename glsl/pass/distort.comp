// The picture through a lens, a thread an output pixel (Mueller 2021, eq. 4.4): where in the undistorted picture each
// channel of the pixel lies. The picture is decoded by the sampler, so taps are averaged in linear light.
#include "shared/bindings.h"
#include "shared/acuity.h"
#include "shared/tone.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = UNIT_PICTURE) uniform sampler2D uPicture;
layout(binding = 0) writeonly uniform image2D uDistorted;
layout(location = LOCATION_LENS) uniform vec3 uLens;          // k1, k2, undistorted radius at the picture's corner
layout(location = LOCATION_CHANNELS) uniform vec3 uChannels;  // radius in the picture of red, green, blue

const int kMostTaps = 8;

// From the output's centre in units of half its diagonal, to the picture's texture coordinates.
vec2 placeIn(vec2 at, vec2 size, float channel) {
  float radius = length(at);
  float ratio = radius > kSmallestRadius ? lensUndistort(radius, uLens.x, uLens.y) / radius : 1.0;
  return 0.5 + at * (channel * ratio / uLens.z) * (0.5 * length(size) / size);
}

vec4 tap(vec2 place) {
  if (any(lessThan(place, vec2(0.0))) || any(greaterThan(place, vec2(1.0)))) return vec4(0.0);
  return textureLod(uPicture, place, 0.0);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  ivec2 sizes = imageSize(uDistorted);
  if (pixel.x >= sizes.x || pixel.y >= sizes.y) return;
  vec2 size = vec2(sizes);
  float unit = 2.0 / length(size);  // an output pixel
  vec2 at = (vec2(pixel) + 0.5 - 0.5 * size) * unit;
  float radius = length(at);
  vec2 outward = radius > kSmallestRadius ? at / radius : vec2(1.0, 0.0);
  vec2 around = vec2(-outward.y, outward.x);
  // Pixels of the picture that one of the output covers, along the radius and across: a bilinear tap for each.
  float largest = max(uChannels.r, max(uChannels.g, uChannels.b)) / uLens.z;
  float along = lensSlope(radius, uLens.x, uLens.y) * largest;
  float across =
      (radius > kSmallestRadius ? lensUndistort(radius, uLens.x, uLens.y) / radius : 1.0) * largest;
  int tapsAlong = clamp(int(ceil(along)), 1, kMostTaps);
  int tapsAcross = clamp(int(ceil(across)), 1, kMostTaps);
  vec4 sum = vec4(0.0);
  for (int i = 0; i < tapsAlong; ++i) {
    for (int k = 0; k < tapsAcross; ++k) {
      vec2 within = (vec2(i, k) + 0.5) / vec2(tapsAlong, tapsAcross) - 0.5;
      vec2 from = at + (outward * within.x + around * within.y) * unit;
      vec4 green = tap(placeIn(from, size, uChannels.g));
      sum += vec4(tap(placeIn(from, size, uChannels.r)).r, green.g, tap(placeIn(from, size, uChannels.b)).b, green.a);
    }
  }
  vec4 mean = sum / float(tapsAlong * tapsAcross);
  imageStore(uDistorted, pixel, vec4(encodeSrgb(mean.r), encodeSrgb(mean.g), encodeSrgb(mean.b), mean.a));
}
