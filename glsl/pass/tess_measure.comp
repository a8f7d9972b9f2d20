// Measures every visible triangle, and sums up what memory they would ideally take.
// FOVEATE, LENS: fewer texels where the gaze is far, or the lens presses the picture together.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/levels.h"
#include "shared/tess_atlas.h"
#include "shared/tess_measure.h"
#if defined(FOVEATE) || defined(LENS)
#define DENSITY
#include "shared/acuity.h"
#endif
#include "lib/triangle.glsl"

layout(local_size_x = TESS_GROUP) in;
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_PATCH_MEASURE) writeonly buffer Measures { TessMeasure measures[]; };
layout(std430, binding = BIND_PATCH_STATE) readonly buffer States { TessState states[]; };
layout(std430, binding = BIND_ATLAS_STATE) buffer AtlasStates { TessAtlasState atlas; };
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu views[TESS_VIEWS]; };
#ifdef DENSITY
layout(std140, binding = BIND_DENSITY) uniform Densities { DensityGpu densities[TESS_VIEWS]; };
#endif

TessMeasure seenFrom(uint view, vec3 v0, vec3 v1, vec3 v2) {
  vec3 at = views[view].eye.xyz;
  TessMeasure seen = measureTriangle(v0 - at, v1 - at, v2 - at, views[view].eye.w);
#ifdef DENSITY
  Cone cone = coneOfPatch(v0 - at, v1 - at, v2 - at, v0 - at, v0 - at, 1u);
  float density = 0.0;
#ifdef FOVEATE
  density += logAcuity(densities[view], cone);
#endif
#ifdef LENS
  density += logLens(densities[view], cone);
#endif
  float scale = exp2(0.5 * density);
  seen.edge0 *= scale;
  seen.edge1 *= scale;
  seen.edge2 *= scale;
  seen.height *= scale;
#endif
  return seen;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= visibleCount) return;
  uint number = visibleIds[i];
  mat3 corners = triangleElement(number, atlas.config.triangles).corners;
  vec3 v0 = corners[0];
  vec3 v1 = corners[1];
  vec3 v2 = corners[2];
  TessMeasure best = seenFrom(0u, v0, v1, v2);
  // A number in a buffer, see rect_measure.comp.
  uint viewCount = atlas.config.views;
  for (uint view = 1u; view < viewCount; ++view) {
    TessMeasure seen = seenFrom(view, v0, v1, v2);
    if (longestOf(seen) > longestOf(best)) best = seen;
  }
  measures[i] = best;
  uint texels = texelsOfShape(shapeAt(best, exp2(-0.5 * atlas.config.constantBias),
                                     limitsOfSplit(atlas.config.limits, states[number].split)));
  uint part = gl_WorkGroupID.x % kTessIdeals;
  if (texels <= 1u) {
    atomicAdd(atlas.ideal[part].singles, 1u);
  } else {
    uint before = atomicAdd(atlas.ideal[part].low, texels);
    if (before + texels < before) atomicAdd(atlas.ideal[part].high, 1u);
  }
}
