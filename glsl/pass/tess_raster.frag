// See tess_raster.vert: a fragment is a texel, and inverts the map of its slot. The rectangle of a block of
// Oversampling has room for its neighbour's half too, whose texels are left alone.
#include "lib/tess_shade.glsl"
#include "lib/tess_samples.glsl"
#include "lib/tess_store.glsl"

layout(location = 0) flat in uint vEntry;
layout(location = 1) flat in uint vSide;
layout(location = 0) out vec4 oColor;

void main() {
  TessEntry e = entries[vEntry];
  uint kind = kindOf(e.shape.kind);
  Sample s = singleSample(e);
  if (kind == kTessOver) {
    OverShape over = overOfShape(e.shape);
    uint place = vSide == 0u ? e.place0 : e.place1;
    uint columns = overColumns(over, vSide);
    uvec2 at = uvec2(gl_FragCoord.xy) - placeTexel(place);
    if (placeTurned(place) != 0u) at = overPairSize(columns, over.rows) - uvec2(1u) - at;
    if (at.x >= overRow(columns, over.rows, at.y)) discard;
    s = overSample(e, over, OverCell(true, vSide, at));
  } else if (kind == kTessL) {
    uint level = levelOfKind(e.shape.kind);
    uvec2 at = uvec2(gl_FragCoord.xy) - placeTexel(e.place0);
    if (placeTurned(e.place0) != 0u) at = lPairSize(level) - uvec2(1u) - at;
    s = lSample(e, level, at);
  }
  oColor = atlasValue(shadePlace(vEntry, s.at));
}
