// See tess_raster.vert: a fragment is a texel, and inverts the map of its slot. The rectangle of a block of
// Oversampling has room for its neighbour's half too, whose texels are left alone.
#include "lib/tess_shade.glsl"

layout(location = 0) flat in uint vEntry;
layout(location = 1) flat in uint vSide;
layout(location = 0) out vec4 oColor;

void main() {
  TessEntry entry = entries[vEntry];
  uint place = vSide == 1u && kindOf(entry.shape.kind) == kTessOver ? entry.place1 : entry.place0;
  uvec2 at = uvec2(gl_FragCoord.xy) - uvec2(placeX(place), placeY(place));
  Place sampled;
  if (kindOf(entry.shape.kind) == kTessOver) {
    OverShape over = overOfShape(entry.shape);
    uint columns = overColumns(over, vSide);
    if (placeTurned(place) != 0u) at = overPairSize(columns, over.rows) - uvec2(1u) - at;
    // The block's other texels are the neighbour's.
    if (at.x >= overRow(columns, over.rows, at.y)) discard;
    sampled = overPlace(over, OverCell(true, vSide, at));
  } else {
    uint level = levelOfKind(entry.shape.kind);
    if (kindOf(entry.shape.kind) == kTessL && placeTurned(place) != 0u) at = lPairSize(level) - uvec2(1u) - at;
    sampled = kindOf(entry.shape.kind) == kTessL ? lPlace(level, lPlaceOf(at, level)) : singlePlace();
  }
  oColor = shadePlace(vEntry, sampled);
}
