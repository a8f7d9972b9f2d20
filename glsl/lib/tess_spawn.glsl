// What a tessellator spawns for a piece of work: an entry, and its first sample. An L of up to 64 levels is the uniform
// pattern of its level, count 0. What has more samples than a tessellator spawns at once is several pieces, which count
// through the texels; so do Oversampling's blocks. One texel is none of its business.
struct TessWork {
  TessLevels levels;
  uint count;
};

TessWork workOf(TessShape shape, uint first) {
  uint kind = kindOf(shape.kind);
  if (kind == kTessSingle) return TessWork(TessLevels(0u, 0u, 0u, 0u), 0u);
  if (kind == kTessL && levelOfKind(shape.kind) <= kTessLargest)
    return TessWork(tessUniform(levelOfKind(shape.kind)), 0u);
  uint count = min(texelsOfShape(shape) - first, kTessMostSamples);
  return TessWork(tessLevelsFor(count), count);
}

#define SPAWN(work) \
  gl_TessLevelOuter[0] = float((work).levels.outer0); \
  gl_TessLevelOuter[1] = float((work).levels.outer1); \
  gl_TessLevelOuter[2] = float((work).levels.outer2); \
  gl_TessLevelInner[0] = float((work).levels.inner)
