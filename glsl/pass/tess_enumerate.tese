// See tess_enumerate.tesc: notes the sample of a tessellation vertex.
#include "lib/tess_list.glsl"

layout(triangles, equal_spacing, ccw, point_mode) in;
layout(location = 0) patch in uvec4 pSpawn;

void main() {
  gl_Position = vec4(0.0);
  uint count = pSpawn.z;
  if (count == 0u) {
    uint level = levelOfKind(entries[pSpawn.x].shape.kind);
    // The cut has its samples on both sides.
    LTexels texels = lTexelsOf(tessPlaceAt(gl_TessCoord, tessUniform(level)), level);
    listSample(pSpawn.x, lNumberOfTexel(level, texels.first));
    listSample(pSpawn.x, lNumberOfTexel(level, texels.second));
    return;
  }
  TessLevels levels = tessLevelsFor(count);
  uint number = tessThread(tessPlaceAt(gl_TessCoord, levels), levels);
  if (number < count) listSample(pSpawn.x, pSpawn.y + number);
}
