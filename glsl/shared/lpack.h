// placeholder until the checked formulas arrive
#ifndef TESSERA_GLSL_SHARED_LPACK_H
#define TESSERA_GLSL_SHARED_LPACK_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN
SHARED_CONST uint kLargestLevel = 254u;
SHARED_FN uint lCellWidth(uint level) { return level + level / 2u + 2u; }
SHARED_FN uint lCellHeight(uint level) { return level + 2u; }
SHARED_FN uint lTexels(uint level) { return (level + 1u) * (level + 1u) - (level / 2u) * (level / 2u); }
// even coordinates of texel (x, y) of an L
SHARED_FN vec3 lCoordinates(uint level, uint X, uint Y) {
  uint h = level / 2u;
  uint tip = X > h ? 1u : (Y > h ? 2u : 0u);
  uint x = tip == 1u ? Y : (tip == 2u ? level - Y : X);
  uint y = tip == 1u ? level - X : (tip == 2u ? X : Y);
  float l = float(level);
  float next = x >= y ? (float(x) - float(y) / 3.0) / l : 2.0 * float(x) / (3.0 * l);
  float prev = x >= y ? 2.0 * float(y) / (3.0 * l) : (float(y) - float(x) / 3.0) / l;
  float own = 1.0 - next - prev;
  return tip == 0u ? vec3(own, next, prev) : (tip == 1u ? vec3(prev, own, next) : vec3(next, prev, own));
}
// where p is in the L, texels from the first texel's centre (plain)
SHARED_FN vec2 lDecode(uint level, vec3 p) {
  uint tip = p.y > p.x && p.y >= p.z ? 1u : (p.z > p.x ? 2u : 0u);
  float next = tip == 0u ? p.y : (tip == 1u ? p.z : p.x);
  float prev = tip == 0u ? p.z : (tip == 1u ? p.x : p.y);
  float l = float(level);
  float least = next < prev ? next : prev;
  float med = next < prev ? prev : next;
  float row = least * 1.5 * l;
  float column = (med + 0.5 * least) * l;
  float x = next >= prev ? column : row;
  float y = next >= prev ? row : column;
  return tip == 0u ? vec2(x, y) : (tip == 1u ? vec2(l - y, x) : vec2(y, l - x));
}
TESSERA_SHARED_END
#endif
