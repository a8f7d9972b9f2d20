// PLAIN_DECODE: of Ls as Hladky 2019, eq. 4, which bends straight lines in the cells on the lines from the corners.
#ifdef PLAIN_DECODE
#define L_DECODE lDecodePlain
#else
#define L_DECODE lDecodeExact
#endif

// Of coordinates that are proportional to even ones. A fragment's centre lies in the triangle but for rounding.
vec3 evenOf(vec3 weighted) {
  vec3 even = max(weighted, vec3(0.0));
  return even / max(even.x + even.y + even.z, 1e-30);
}

// Where a triangle's samples have a place in even coordinates: atlas texels, centres at .5.
vec2 atlasOfEven(TessShape shape, uint place0, uint place1, vec3 even) {
  uint kind = kindOf(shape.kind);
  if (kind == kTessL) {
    uint level = levelOfKind(shape.kind);
    return lAtlasAt(L_DECODE(even, level), uvec2(placeX(place0), placeY(place0)), level, placeTurned(place0) != 0u);
  }
  if (kind == kTessOver) {
    OverShape over = overOfShape(shape);
    OverPoint point = overDecode(even, over);
    uint place = point.side == 0u ? place0 : place1;
    bool turned = placeTurned(place) != 0u;
    uvec2 corner = overCorner(uvec2(placeX(place), placeY(place)), overColumns(over, point.side), over.rows, turned);
    return overAtlasAt(point.at, corner, turned);
  }
  return vec2(float(placeX(place0)), float(placeY(place0))) + 0.5;
}
