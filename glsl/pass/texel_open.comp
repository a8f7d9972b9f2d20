// Opens a frame of Texel Shading: the bias that the last frame's tiles call for, and empty lists.
#include "lib/texel_state.glsl"

layout(local_size_x = 1) in;
layout(location = LOCATION_COUNT) uniform uint uCurrent;  // the half that this frame writes
layout(location = LOCATION_FRAME) uniform uint uPlaced;   // 1: the last frame that was opened was placed

void main() {
  TexelConfig config = texels.config;
  if (config.biased != 0u && uPlaced != 0u)
    texels.pressure = nextTexelPressure(texels.pressure, texels.marked, config.slots, config.lowestBias);
  texels.current = uCurrent;
  texels.coarser = 0u;
  texels.marked = 0u;
  texels.lost = 0u;
  texels.source = 0u;
  texels.fitting = 0u;
  texels.wanted0 = 0u;
  texels.wanted1 = 0u;
  texels.samples = 0u;
  texels.kept = 0u;
  ++texels.frames;
}
