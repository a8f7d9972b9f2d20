// Alpha of streamed elements, to test or to blend by. All masks of a stream lie in one buffer, so that one draw call has any of them:
// their levels one behind the other, each half of the last, four texels a word, rows from the top.
#include "shared/streamed_mask.h"
layout(std430, binding = BIND_STREAMED_MASKS) readonly buffer StreamedMasks { StreamedMask streamedMasks[]; };
layout(std430, binding = BIND_STREAMED_ALPHA) readonly buffer StreamedAlpha { uint streamedAlpha[]; };

float maskTexel(uint start, uvec2 size, ivec2 at, StreamedMask m) {
  uint x = maskWrapped(at.x, size.x, m.wrapAcross);
  uint y = maskWrapped(at.y, size.y, m.wrapUp);
  uint i = start + y * size.x + x;
  return float((streamedAlpha[i / 4u] >> (8u * (i % 4u))) & 255u) / 255.0;
}

float maskLevel(StreamedMask m, uint level, vec2 at) {
  uint start = m.start;
  uvec2 size = uvec2(m.width, m.height);
  for (uint i = 0u; i < level; ++i) {
    start += size.x * size.y;
    size = max(size / 2u, uvec2(1u));
  }
  // Far outside of what floats tell texels apart, any texel will do.
  vec2 place = clamp(at * vec2(size) - 0.5, vec2(-1.0e9), vec2(1.0e9));
  vec2 low = floor(place);
  vec2 part = place - low;
  ivec2 i = ivec2(low);
  float top = mix(maskTexel(start, size, i, m), maskTexel(start, size, i + ivec2(1, 0), m), part.x);
  float bottom = mix(maskTexel(start, size, i + ivec2(0, 1), m), maskTexel(start, size, i + ivec2(1, 1), m), part.x);
  return mix(top, bottom, part.y);
}

// As a texture with linear filters within and between levels gives it. dx, dy: change of `at` to the next pixels.
float maskAlpha(StreamedMask m, vec2 at, vec2 dx, vec2 dy) {
  vec2 size = vec2(float(m.width), float(m.height));
  float across = max(length(dx * size), length(dy * size));
  float level = clamp(log2(max(across, 1.0e-6)), 0.0, float(m.levels - 1u));
  uint fine = uint(level);
  float alpha = maskLevel(m, fine, at);
  if (fine + 1u < m.levels) alpha = mix(alpha, maskLevel(m, fine + 1u, at), level - float(fine));
  return alpha;
}

// Of one that there is not, there are no holes.
bool streamedMaskKnown(uint number) {
  return number < uint(streamedMasks.length()) && streamedMasks[number].width != 0u;
}
bool streamedMaskedOut(uint number, vec2 at, vec2 dx, vec2 dy) {
  return streamedMaskKnown(number) && maskAlpha(streamedMasks[number], at, dx, dy) < streamedMasks[number].cutoff;
}
float streamedMaskAlpha(uint number, vec2 at, vec2 dx, vec2 dy) {
  return streamedMaskKnown(number) ? maskAlpha(streamedMasks[number], at, dx, dy) : 1.0;
}
