// Planes of video as a texture of display-encoded colours, a thread a texel; alpha is 1. The texels of a square of SIDE
// take the chroma of their square, unfiltered: squares are aligned as blocks of an atlas are, and across the edge of a
// block lies another surface.
#include "shared/bindings.h"
#include "shared/yuv.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba8) writeonly uniform image2D uColors;
layout(std430, binding = BIND_YUV_PLANES) readonly buffer Planes {
  YuvHeader header;
  uint planes[];
};

int value(uint start, uint stride, uint x, uint y) {
  return int((planes[start + y * stride + x / 4u] >> (8u * (x % 4u))) & 255u);
}

void main() {
  uvec2 texel = gl_GlobalInvocationID.xy;
  uvec2 size = uvec2(imageSize(uColors));
  if (texel.x >= size.x || texel.y >= size.y) return;
  const uint kSide = uint(SIDE);
  uint stride = yuvStride(yuvChromaSize(size.x, kSide));
  uvec2 square = texel / kSide;
  int luma = value(0u, yuvStride(size.x), texel.x, texel.y);
  int blue = value(yuvPlane(1u, size.x, size.y, kSide), stride, square.x, square.y);
  int red = value(yuvPlane(2u, size.x, size.y, kSide), stride, square.x, square.y);
  vec3 color = vec3(redOf(luma, red), greenOf(luma, blue, red), blueOf(luma, blue)) / 255.0;
  imageStore(uColors, ivec2(texel), vec4(color, 1.0));
}
