// Colours for debug pictures.

// Integer hash (Wellons 2018, lowbias32): neighbours get unlike colours.
uint scramble(uint x) {
  x ^= x >> 16u;
  x *= 0x7feb352du;
  x ^= x >> 15u;
  x *= 0x846ca68bu;
  x ^= x >> 16u;
  return x;
}

vec3 colorOfId(uint id) {
  uint h = scramble(id);
  vec3 c = vec3(float(h & 255u), float((h >> 8u) & 255u), float((h >> 16u) & 255u)) / 255.0;
  return 0.25 + 0.7 * c;
}

// 0 blue, 0.5 green, 1 red, in steps of even lightness.
vec3 heat(float t) {
  t = clamp(t, 0.0, 1.0);
  return clamp(vec3(2.0 * t - 0.6, 1.0 - 2.2 * abs(t - 0.5) + 0.15, 1.1 - 2.2 * t), 0.05, 1.0);
}

// A level by its area: log2 of texels over the range of blocks, darker for flat blocks.
vec3 colorOfLevel(uint width, uint height) {
  return heat(float(width + height) / 16.0) * (1.0 - 0.06 * float(width - min(width, height)));
}
