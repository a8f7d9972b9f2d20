// A triangle of the scene by its number in the visible set: vertices, counter-clockwise in the world.
layout(std430, binding = BIND_POSITIONS) readonly buffer Positions { float positions[]; };
layout(std430, binding = BIND_INSTANCES) readonly buffer Instances { InstanceGpu instances[]; };
layout(std430, binding = BIND_PATCHES) readonly buffer Patches { PatchGeometry patches[]; };
layout(std430, binding = BIND_PATCH_INSTANCE) readonly buffer PatchInstances { uint instanceOfPatch[]; };

struct SceneTriangle {
  uint instance;
  uint vertex0;
  uint vertex1;
  uint vertex2;
};

SceneTriangle sceneTriangle(uint number) {
  uint patchId = number >> 2u;
  uint part = number & 3u;
  uint index = instanceOfPatch[patchId];
  PatchGeometry geometry = patches[instances[index].patchOffset + patchId - instances[index].patchBase];
  uint second = part == 0u ? geometry.v1 : (part == 1u ? geometry.v2 : geometry.v3);
  uint third = part == 0u ? geometry.v2 : (part == 1u ? geometry.v3 : geometry.v4);
  bool mirrored = (instances[index].flags & kInstanceMirrored) != 0u;
  return SceneTriangle(index, geometry.v0, mirrored ? third : second, mirrored ? second : third);
}

vec3 worldCorner(SceneTriangle triangle, uint vertex) {
  return transformPoint(instances[triangle.instance],
                        vec3(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]));
}
