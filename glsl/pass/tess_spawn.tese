// See tess_spawn.tesc: shades the sample of a tessellation vertex, and stores it.
#include "lib/tess_shade.glsl"
#include "lib/tess_samples.glsl"
#include "lib/tess_store.glsl"
#include "lib/tess_image.glsl"

layout(triangles, equal_spacing, ccw, point_mode) in;
layout(location = 0) patch in uvec4 pSpawn;

void main() {
  gl_Position = vec4(0.0);
  TessEntry e = entries[pSpawn.x];
  uint count = pSpawn.z;
  if (count == 0u) {
    uint level = levelOfKind(e.shape.kind);
    TessPlace place = tessPlaceAt(gl_TessCoord, tessUniform(level));
    LTexels texels = lTexelsOf(place, level);
    Sample s = lSample(e, level, texels.first);
    vec4 color = atlasValue(shadePlace(pSpawn.x, s.at));
    imageStore(uAtlasImage, ivec2(s.texel), color);
    // The cut has its samples on both sides.
    if (texels.second != texels.first)
      imageStore(uAtlasImage, ivec2(lAtlasTexel(texels.second, placeTexel(e.place0), level, placeTurned(e.place0) != 0u)), color);
    return;
  }
  TessLevels levels = tessLevelsFor(count);
  uint number = tessThread(tessPlaceAt(gl_TessCoord, levels), levels);
  if (number < count) storeSample(pSpawn.x, sampleOf(e, pSpawn.y + number));
}
