// A texture of display-encoded colours as planes of video, a thread eight texels in each of two rows: that much is
// whole words of every plane. SIDE is of the square that shares a chroma value, 1 or 2: the mean over the square.
// Beyond the texture's edges its last texels repeat.
#include "shared/bindings.h"
#include "shared/yuv.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = UNIT_PICTURE) uniform sampler2D uColors;
layout(location = LOCATION_FRAME) uniform uint uFrame;
layout(std430, binding = BIND_YUV_PLANES) writeonly buffer Planes {
  YuvHeader header;
  uint planes[];
};

ivec3 texels[2][8];

void store(uint word, uint row, uint rows, uint stride, uint value, uint start) {
  if (word < stride && row < rows) planes[start + row * stride + word] = value;
}

void main() {
  ivec2 size = textureSize(uColors, 0);
  uvec2 wide = uvec2(size);
  ivec2 corner = ivec2(gl_GlobalInvocationID.xy) * ivec2(8, 2);
  if (gl_GlobalInvocationID.xy == uvec2(0u)) header = YuvHeader(uFrame, wide.x, wide.y, uint(SIDE));
  if (corner.x >= size.x || corner.y >= size.y) return;

  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 8; ++x)
      texels[y][x] = ivec3(texelFetch(uColors, min(corner + ivec2(x, y), size - 1), 0).rgb * 255.0 + 0.5);

  uint stride = yuvStride(wide.x);
  for (int y = 0; y < 2; ++y)
    for (int word = 0; word < 2; ++word) {
      uint luma = 0u;
      for (int i = 0; i < 4; ++i) {
        ivec3 c = texels[y][4 * word + i];
        luma |= uint(lumaOf(c.r, c.g, c.b)) << uint(8 * i);
      }
      store(gl_GlobalInvocationID.x * 2u + uint(word), uint(corner.y + y), wide.y, stride, luma, 0u);
    }

  uvec2 chroma = uvec2(yuvChromaSize(wide.x, uint(SIDE)), yuvChromaSize(wide.y, uint(SIDE)));
  uint chromaStride = yuvStride(chroma.x);
  const int kRows = 2 / SIDE;
  const int kWords = 2 / SIDE;
  for (int y = 0; y < kRows; ++y)
    for (int word = 0; word < kWords; ++word) {
      uint blue = 0u;
      uint red = 0u;
      for (int i = 0; i < 4; ++i) {
        ivec3 sum = ivec3(0);
        for (int v = 0; v < SIDE; ++v)
          for (int u = 0; u < SIDE; ++u) sum += texels[y * SIDE + v][(4 * word + i) * SIDE + u];
        blue |= uint(blueChromaOf(sum.r, sum.g, sum.b, SIDE * SIDE)) << uint(8 * i);
        red |= uint(redChromaOf(sum.r, sum.g, sum.b, SIDE * SIDE)) << uint(8 * i);
      }
      uint at = gl_GlobalInvocationID.x * uint(kWords) + uint(word);
      uint row = gl_GlobalInvocationID.y * uint(kRows) + uint(y);
      store(at, row, chroma.y, chromaStride, blue, yuvPlane(1u, wide.x, wide.y, uint(SIDE)));
      store(at, row, chroma.y, chromaStride, red, yuvPlane(2u, wide.x, wide.y, uint(SIDE)));
    }
}
