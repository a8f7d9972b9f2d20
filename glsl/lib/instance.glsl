// The instance of a draw, as vertex attributes that step once an instance: the base instance of the draw command picks
// the record, on every driver, without a storage load in the vertex stage.
layout(location = 8) in vec4 aRow0;
layout(location = 9) in vec4 aRow1;
layout(location = 10) in vec4 aRow2;
layout(location = 11) in uvec4 aPatches;  // patchBase, patchOffset, pairs, triples
layout(location = 12) in uvec4 aRest;     // singles, batch, flags, material

InstanceGpu drawnInstance() {
  return InstanceGpu(aRow0, aRow1, aRow2, aPatches.x, aPatches.y, aPatches.z, aPatches.w, aRest.x, aRest.y, aRest.z,
                     aRest.w);
}
