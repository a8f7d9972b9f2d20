// The samples of a triangle by number: the same texels, in the same surface points, for every way to spawn them. Numbers
// run to texelsOfShape; a few of Oversampling's have no texel.
struct Sample {
  Place at;
  uvec2 texel;  // of the atlas
  bool used;
};

uvec2 placeTexel(uint place) { return uvec2(placeX(place), placeY(place)); }

Sample lSample(TessEntry e, uint level, uvec2 at) {
  return Sample(lPlace(level, lPlaceOf(at, level)),
                lAtlasTexel(at, placeTexel(e.place0), level, placeTurned(e.place0) != 0u), true);
}

Sample overSample(TessEntry e, OverShape over, OverCell cell) {
  uint place = cell.side == 0u ? e.place0 : e.place1;
  bool turned = placeTurned(place) != 0u;
  uvec2 corner = overCorner(placeTexel(place), overColumns(over, cell.side), over.rows, turned);
  return Sample(overPlace(over, cell), overAtlasTexel(cell.at, corner, turned), cell.used);
}

Sample singleSample(TessEntry e) { return Sample(singlePlace(), placeTexel(e.place0), true); }

Sample sampleOf(TessEntry e, uint number) {
  uint kind = kindOf(e.shape.kind);
  if (kind == kTessL) {
    uint level = levelOfKind(e.shape.kind);
    return lSample(e, level, lTexelOfNumber(level, number));
  }
  if (kind == kTessOver) {
    OverShape over = overOfShape(e.shape);
    return overSample(e, over, overCellOf(number, over));
  }
  return singleSample(e);
}
