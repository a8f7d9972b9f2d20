// What the shared headers give for inputs made from a number, once for C++ and for GLSL.
#ifndef TESSERA_TESTS_TESSELLATION_PROBE_H
#define TESSERA_TESTS_TESSELLATION_PROBE_H
#include "shared/tess_measure.h"
TESSERA_SHARED_BEGIN

struct Probe {
  uvec4 place;    // ring, side, step, thread again
  uvec4 texels;   // of the L
  uvec4 back;     // ring, side, step of the second texel's sample; count of the levels for a count
  uvec4 cell;     // x, y, side, used
  uvec4 record;   // packed and unpacked
  uvec4 shape;    // selected: kind, size, form; texels
  vec4 measure;   // edges, height
  vec4 sites;     // bary of the place; weight 2
  vec4 decodes;   // L exact, L plain
  vec4 even;      // of the cell; 0
  vec4 surface;   // extrapolated; weight 0
  vec4 screen;    // even from surface; weight 1
  vec4 atlas;     // L, Oversampling
};

SHARED_FN uint probeNext(uint state) {
  uint mixed = (state ^ (state >> 16u)) * 0x7feb352du;
  mixed = (mixed ^ (mixed >> 15u)) * 0x846ca68bu;
  return mixed ^ (mixed >> 16u);
}
SHARED_FN float probeUnit(uint state) { return float(state & 0xffffu) / float(65536); }

SHARED_FN vec3 probeCorner(uint seed) {
  uint a = probeNext(seed);
  uint b = probeNext(a);
  uint c = probeNext(b);
  float depth = float(1) + float(40) * probeUnit(a);
  return vec3((probeUnit(b) - float(1) / float(2)) * float(3),
              (probeUnit(c) - float(1) / float(2)) * float(3), -depth);
}

SHARED_FN Probe probe(uint index) {
  uint a = probeNext(index + 1u);
  uint b = probeNext(a);
  uint c = probeNext(b);
  uint d = probeNext(c);
  uint e = probeNext(d);
  Probe found;

  uint level = 1u + a % 64u;
  TessLevels uniformLevels = tessUniform(level);
  TessPlace place = tessPlaceOf(b % tessUniformCount(level), uniformLevels);
  vec3 bary = tessBary(place, uniformLevels);
  TessPlace again = tessPlaceAt(bary, uniformLevels);
  found.place = uvec4(again.ring, again.side, again.step, tessThread(place, uniformLevels));
  LTexels texels = lTexelsOf(place, level);
  found.texels = uvec4(texels.first.x, texels.first.y, texels.second.x, texels.second.y);
  TessPlace back = lPlaceOf(texels.second, level);
  found.back = uvec4(back.ring, back.side, back.step, tessCount(tessLevelsFor(c % 4000u)));

  float u = probeUnit(c);
  float v = (float(1) - u) * probeUnit(d);
  vec3 p = vec3(u, v, float(1) - u - v);
  vec2 exact = lDecodeExact(p, level);
  vec2 plain = lDecodePlain(p, level);
  found.decodes = vec4(exact.x, exact.y, plain.x, plain.y);
  uvec2 origin = uvec2(e % 1000u, d % 1000u);
  vec2 inAtlas = lAtlasAt(exact, origin, level, (e & 1u) == 1u);

  OverPlace over;
  over.shape.apex = b % 3u;
  over.shape.columns0 = c % 5u == 0u ? 0u : 2u + c % 60u;
  over.shape.columns1 = 2u + d % 60u;
  over.shape.rows = 1u + e % 40u;
  over.shape.foot = over.shape.columns0 == 0u ? 0u : 1000u + b % 60000u;
  if (over.shape.rows == 1u) over.shape.columns0 = 0u;
  over.corner0 = uvec2(200u + b % 5000u, 200u + c % 5000u);
  over.corner1 = uvec2(200u + d % 5000u, 200u + e % 5000u);
  over.turned0 = (b & 64u) != 0u;
  over.turned1 = (c & 64u) != 0u;
  over = unpackOver(packOver(over));
  found.record = packOver(over);
  OverCell cell = overCellOf(e % overCount(over.shape), over.shape);
  found.cell = uvec4(cell.at.x, cell.at.y, cell.side, cell.used ? 1u : 0u);
  vec3 even = overEven(cell, over.shape);
  OverPoint point = overDecode(p, over.shape);
  vec2 overAt = point.side == 0u ? overAtlasAt(point.at, over.corner0, over.turned0)
                                 : overAtlasAt(point.at, over.corner1, over.turned1);
  found.atlas = vec4(inAtlas.x, inAtlas.y, overAt.x, overAt.y);

  vec3 v0 = probeCorner(a);
  vec3 v1 = probeCorner(c);
  vec3 v2 = probeCorner(e);
  TessMeasure measure = measureTriangle(v0, v1, v2, float(30));
  found.measure = vec4(measure.edge0, measure.edge1, measure.edge2, measure.height);
  TessLimits limits;
  limits.slanted = float(4);
  limits.level = float(20);
  limits.columns = float(40);
  TessShape held = shapeAt(measure, exp2((probeUnit(d) - float(1) / float(2)) / float(8)), limits);
  TessShape shape = selectShape(measure, float(0), float(4) * probeUnit(b), limits, held, float(1) / float(20));
  found.shape = uvec4(shape.kind, shape.size, shape.form, texelsOfShape(shape));
  vec3 weights = depthWeights(v0, v1, v2);
  vec3 surface = surfaceFromEvenOutside(even, weights);
  found.surface = vec4(surface[0], surface[1], surface[2], weights[0]);
  vec3 screen = evenFromSurface(p, weights);
  found.screen = vec4(screen[0], screen[1], screen[2], weights[1]);
  found.sites = vec4(bary[0], bary[1], bary[2], weights[2]);
  found.even = vec4(even[0], even[1], even[2], float(0));
  return found;
}

TESSERA_SHARED_END
#endif
