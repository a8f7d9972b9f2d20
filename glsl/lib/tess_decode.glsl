// Where a triangle's slot has a place in even coordinates: atlas texels, centres at .5.
vec2 slotTexel(uint shape, uint place, vec3 even) {
  vec2 origin = vec2(float(placeX(place)), float(placeY(place)));
  if (kindOf(shape) != kTessL) return origin + 0.5;
  uint level = levelOfShape(shape);
  vec2 at = lDecode(level, even) + 0.5;
  if (placeTurned(place) != 0u) at = vec2(float(lCellWidth(level)), float(lCellHeight(level))) - at;
  return origin + at;
}
