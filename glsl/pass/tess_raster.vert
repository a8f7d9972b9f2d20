// Gathering by rasterization: the rectangles of each visible triangle's slot, two an L, drawn texel by texel.
#define STAGE_VERTEX
#include "shared/bindings.h"
#include "shared/tess_atlas.h"

layout(std430, binding = BIND_GATHER_VERTICES) readonly buffer Entries { TessEntry entries[]; };
layout(location = LOCATION_SIZE) uniform vec2 uTexelToClip;  // 2 / size of the atlas texture
layout(location = 0) flat out uint vEntry;
layout(location = 1) flat out uint vSide;

void main() {
  uint entry = uint(gl_VertexID) / 12u;
  uint rectangle = (uint(gl_VertexID) / 6u) & 1u;
  uint corner = uint(gl_VertexID) % 6u;
  uvec2 side = uvec2(corner == 1u || corner == 2u || corner == 4u ? 1u : 0u, corner == 2u || corner > 3u ? 1u : 0u);
  TessEntry e = entries[entry];
  uvec2 low = uvec2(0u);
  uvec2 high = uvec2(1u, rectangle == 0u ? 1u : 0u);
  uvec2 cell = uvec2(1u);
  uint place = e.place0;
  uint kind = kindOf(e.shape.kind);
  if (kind == kTessL) {
    uint level = levelOfKind(e.shape.kind);
    uvec2 arm = uvec2(lArmY(level), lArmX(level));
    low = rectangle == 0u ? uvec2(0u) : uvec2(0u, arm.y);
    high = rectangle == 0u ? uvec2(level + 1u, arm.y) : uvec2(arm.x, level + 1u);
    cell = lPairSize(level);
  } else if (kind == kTessOver) {
    OverShape over = overOfShape(e.shape);
    uint columns = overColumns(over, rectangle);
    high = uvec2(columns, columns == 0u ? 0u : over.rows);
    cell = overPairSize(columns, over.rows);
    if (rectangle == 1u) place = e.place1;
  }
  uvec2 texel = uvec2(side.x == 0u ? low.x : high.x, side.y == 0u ? low.y : high.y);
  if (placeTurned(place) != 0u) texel = cell - texel;
  texel += uvec2(placeX(place), placeY(place));
  gl_Position = vec4(vec2(texel) * uTexelToClip - 1.0, 0.5, 1.0);
  vEntry = entry;
  vSide = rectangle;
}
