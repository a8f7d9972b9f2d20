// Iterative image warping (Bowles et al. 2012): for a pixel, the place in the picture whose point it shows, by fixed-point
// iteration from several starts. As seen from the new eye, but in the old one's orientation, the pixel is at `seen`; of a
// point at depth d that is seen there the place in the picture is seen + d * along. Wanted is the d that the picture has
// at its own place; of several the nearest, which hides the others.
#include "shared/bindings.h"

layout(binding = UNIT_PICTURE) uniform sampler2D uPicture;
layout(binding = UNIT_DEPTH) uniform sampler2D uDepth;  // reversed: near plane / distance
layout(std430, binding = BIND_WARP_NEAREST) readonly buffer Nearest { uint nearestBits; };
layout(location = LOCATION_WARP) uniform mat3 uToSource;  // as in warp_time.frag
layout(location = LOCATION_WARP_EYE) uniform vec3 uEye;   // where the new eye is, as (w, pixel w) at depth 1
layout(location = LOCATION_WARP_DEPTH) uniform vec4 uAhead;  // distance ahead of the new eye / its near plane, of (w, pixel w, depth)
layout(location = LOCATION_SIZE) uniform vec3 uSearch;  // most starts; most iterations; pixels within which it has converged
layout(location = LOCATION_BACKGROUND) uniform vec4 uBackground;
layout(location = 0) out vec4 oColor;

const float kStartPixels = 4.0;  // between two starts, where there may be as many

vec2 size = vec2(textureSize(uDepth, 0));

float texel(ivec2 at) { return texelFetch(uDepth, clamp(at, ivec2(0), ivec2(size) - 1), 0).r; }

// Between texels of one surface, else the nearest texel's.
float depthAt(vec2 place) {
  vec2 low = floor(place - 0.5);
  vec2 part = clamp(place - 0.5 - low, 0.0, 1.0);
  ivec2 i = ivec2(clamp(low, vec2(-1.0), size));
  float a = texel(i);
  float b = texel(i + ivec2(1, 0));
  float c = texel(i + ivec2(0, 1));
  float d = texel(i + ivec2(1, 1));
  float near = max(max(a, b), max(c, d));
  float far = min(min(a, b), min(c, d));
  if (far >= 0.9 * near) return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
  return part.y < 0.5 ? (part.x < 0.5 ? a : b) : (part.x < 0.5 ? c : d);
}

vec2 inside(vec2 place) { return clamp(place, vec2(0.5), size - 0.5); }

void main() {
  oColor = uBackground;
  gl_FragDepth = 0.0;
  vec3 place = uToSource * vec3(1.0, gl_FragCoord.xy);
  if (!(place.x > 0.0)) return;
  vec2 seen = place.yz / place.x;
  vec2 along = uEye.yz - seen * uEye.x;
  float pixels = length(along);  // that a depth of 1 shifts
  float nearest = uintBitsToFloat(nearestBits);
  int starts = int(clamp(ceil(nearest * pixels / kStartPixels), 1.0, uSearch.x));
  float found = -1.0;         // the nearest that converged
  float farthest = 2.0;       // of what did not converge: behind what moved away the background is drawn out
  vec2 at = inside(seen);
  vec2 fill = at;
  for (int start = 0; start <= starts; ++start) {
    float depth = nearest * float(start) / float(starts);
    float last = depth;
    bool converged = false;
    vec2 here = at;
    for (int i = 0; i < int(uSearch.y) && !converged; ++i) {
      here = inside(seen + depth * along);
      last = depth;
      depth = depthAt(here);
      converged = abs(depth - last) * pixels <= uSearch.z;
    }
    if (converged && depth > found && depth * uEye.x < 1.0) {
      found = depth;
      at = inside(seen + depth * along);
    }
    if (!converged && depth < farthest) {
      farthest = depth;
      fill = here;
    }
  }
  float depth = found;
  if (found < 0.0) {
    at = fill;
    depth = max(farthest < 2.0 ? farthest : 0.0, 0.0);
  }
  oColor = textureLod(uPicture, at / vec2(textureSize(uPicture, 0)), 0.0);
  float ahead = dot(uAhead, vec4(1.0, at, depth));
  gl_FragDepth = ahead > 0.0 ? min(depth / ahead, 1.0) : 0.0;
}
