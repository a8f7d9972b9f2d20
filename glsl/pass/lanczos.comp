// Lanczos-3 upsampling, one direction a run: first along rows, from the picture as it is encoded; then, with COLUMNS,
// along columns, from the first run's sums. Only covered pixels take part: a sum carries its weight in alpha, and what
// has less than half of the weight is background. Edges are clamped.
#include "shared/bindings.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = UNIT_PICTURE) uniform sampler2D uSource;
layout(binding = 0) writeonly uniform image2D uResult;
#ifdef COLUMNS
layout(location = LOCATION_BACKGROUND) uniform vec4 uBackground;  // encoded, alpha 0
const int kAxis = 1;
#else
const int kAxis = 0;
#endif

const int kReach = 3;

float sinc(float x) {
  float angle = 3.14159265358979 * x;
  return abs(angle) < 1e-4 ? 1.0 : sin(angle) / angle;
}

vec4 tap(ivec2 place) {
  vec4 value = texelFetch(uSource, place, 0);
#ifdef COLUMNS
  return value;
#else
  return value.a > 0.0 ? vec4(value.rgb, 1.0) : vec4(0.0);
#endif
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = imageSize(uResult);
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  ivec2 sourceSize = textureSize(uSource, 0);
  float at = (float(pixel[kAxis]) + 0.5) * float(sourceSize[kAxis]) / float(size[kAxis]) - 0.5;
  int nearest = int(floor(at));
  vec4 sum = vec4(0.0);
  float weights = 0.0;
  for (int i = 1 - kReach; i <= kReach; ++i) {
    float x = float(nearest + i) - at;
    float weight = abs(x) < float(kReach) ? sinc(x) * sinc(x / float(kReach)) : 0.0;
    ivec2 place = pixel;
    place[kAxis] = clamp(nearest + i, 0, sourceSize[kAxis] - 1);
    sum += weight * tap(place);
    weights += weight;
  }
  sum /= weights;
#ifdef COLUMNS
  sum = sum.a >= 0.5 ? vec4(clamp(sum.rgb / sum.a, 0.0, 1.0), 1.0) : uBackground;
#endif
  imageStore(uResult, pixel, sum);
}
