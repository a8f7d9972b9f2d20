// The atlas's blocks as a picture: each visible patch's block, coloured by level.
#define STAGE_VERTEX
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/blocks.h"

layout(std430, binding = BIND_GATHER_VERTICES) readonly buffer GatherVertices { GatherVertex gatherVertices[]; };
layout(location = LOCATION_SIZE) uniform vec2 uTexelToClip;
layout(location = 1) in uint aTexel;
layout(location = 0) out vec2 vSide;           // 0 to 1 along the block's axes
layout(location = 1) flat out uint vEntry;

void main() {
  uint bits = gatherVertices[gl_VertexID].instance;
  uvec2 side = uvec2((bits >> kCornerSideX) & 3u, (bits >> kCornerSideY) & 3u);
  // Edge to edge: a debug picture shows the whole block, not its texel centres.
  vec2 texel = 0.5 * vec2(float(aTexel & 0xffffu), float(aTexel >> 16u)) + 0.5 * (vec2(side) - 1.0);
  gl_Position = vec4(texel * uTexelToClip - 1.0, 0.5, 1.0);
  vSide = vec2(side) * 0.5;
  vEntry = uint(gl_VertexID) >> 2u;
}
