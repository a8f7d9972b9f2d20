// Measures every visible patch, and sums up what memory it would ideally take (I and d of pressureBias).
// FOVEATE, LENS: fewer texels where the gaze is far, or the lens presses the picture together.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/levels.h"
#include "shared/rect_memory.h"
#if defined(FOVEATE) || defined(LENS)
#define DENSITY
#include "shared/acuity.h"
#endif

layout(local_size_x = RECT_GROUP) in;
layout(std430, binding = BIND_POSITIONS) readonly buffer Positions { float positions[]; };
layout(std430, binding = BIND_INSTANCES) readonly buffer Instances { InstanceGpu instances[]; };
layout(std430, binding = BIND_PATCHES) readonly buffer Patches { PatchGeometry patches[]; };
layout(std430, binding = BIND_PATCH_INSTANCE) readonly buffer PatchInstances { uint instanceOfPatch[]; };
layout(std430, binding = BIND_VISIBLE) readonly buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_PATCH_MEASURE) writeonly buffer Measures { PatchMeasure measures[]; };
layout(std430, binding = BIND_ATLAS_STATE) buffer AtlasStates { AtlasState atlas; };
layout(std430, binding = BIND_PATCH_STATE) readonly buffer PatchStates { PatchState patchStates[]; };
layout(std140, binding = BIND_VIEWS) uniform Views { ViewGpu views[RECT_VIEWS]; };
#ifdef DENSITY
layout(std140, binding = BIND_DENSITY) uniform Densities { DensityGpu densities[RECT_VIEWS]; };
#endif

vec3 corner(InstanceGpu instance, uint vertex) {
  return transformPoint(instance, vec3(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]));
}

PatchMeasure seenFrom(uint view, vec3 v0, vec3 v1, vec3 v2, vec3 v3, vec3 v4, uint triangles) {
  vec3 at = views[view].eye.xyz;
  PatchMeasure seen =
      measurePatch(v0 - at, v1 - at, v2 - at, v3 - at, v4 - at, triangles, views[view].eye.w);
#ifdef DENSITY
  Cone cone = coneOfPatch(v0 - at, v1 - at, v2 - at, v3 - at, v4 - at, triangles);
#ifdef FOVEATE
  seen.logArea += logAcuity(densities[view], cone);
#endif
#ifdef LENS
  seen.logArea += logLens(densities[view], cone);
#endif
#endif
  return seen;
}

// A patch that several views see gets the largest area that any of them asks for, in that view's shape.
PatchMeasure measureVisible(uint patchId) {
  InstanceGpu instance = instances[instanceOfPatch[patchId]];
  PatchGeometry geometry = patches[instance.patchOffset + patchId - instance.patchBase];
  vec3 v0 = corner(instance, geometry.v0);
  vec3 v1 = corner(instance, geometry.v1);
  vec3 v2 = corner(instance, geometry.v2);
  vec3 v3 = geometry.triangles > 1u ? corner(instance, geometry.v3) : v1;
  vec3 v4 = geometry.triangles > 2u ? corner(instance, geometry.v4) : v0;
  PatchMeasure best = seenFrom(0u, v0, v1, v2, v3, v4, geometry.triangles);
  // A number in a buffer: zink over lavapipe (Mesa 22.3.6) inlines uniforms that bound loops, and forgets to do so again
  // when a program comes back into use.
  uint viewCount = atlas.config.views;
  for (uint view = 1u; view < viewCount; ++view) {
    PatchMeasure seen = seenFrom(view, v0, v1, v2, v3, v4, geometry.triangles);
    if (seen.logArea > best.logArea) best = seen;
  }
  return best;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= visibleCount) return;
  PatchMeasure measure = measureVisible(visibleIds[i]);
  measures[i] = measure;
  uint texels = idealTexels(measure, atlas.config.constantBias, atlas.config.range);
  uint part = gl_WorkGroupID.x % kIdealSums;
  if (texels == smallestTexels(atlas.config.range)) {
    atomicAdd(atlas.ideal[part].ones, 1u);
  } else {
    uint before = atomicAdd(atlas.ideal[part].low, texels);
    if (before + texels < before) atomicAdd(atlas.ideal[part].high, 1u);
    if (patchStates[visibleIds[i]].epoch != atlas.epoch) {
      before = atomicAdd(atlas.ideal[part].newLow, texels);
      if (before + texels < before) atomicAdd(atlas.ideal[part].newHigh, 1u);
    }
  }
}
