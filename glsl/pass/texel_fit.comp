// Between two rounds of making tiles fit: whether they still are too many, and what the next passes run over.
#include "lib/texel_state.glsl"

layout(local_size_x = 1) in;

void main() {
  TexelConfig config = texels.config;
  if (texels.fitting != 0u) texels.source = 1u - texels.source;
  uint count = texels.source == 0u ? texels.wanted0 : texels.wanted1;
  // The marking pass counts what it found no room for, too.
  if (texels.fitting == 0u && texels.coarser == 0u) texels.marked = count;
  bool fits = count <= config.slots;
  texels.fitting = fits ? 0u : 1u;
  count = min(count, config.wanted);
  if (texels.source == 0u) {
    texels.wanted0 = count;
    if (!fits) texels.wanted1 = 0u;
  } else {
    texels.wanted1 = count;
    if (!fits) texels.wanted0 = 0u;
  }
  if (fits) {
    // All are: what is displayed from here on.
    texels.shown = texels.current;
    texels.shownBias = config.constantBias + texels.pressure.bias;
    texels.shownCoarser = texels.coarser;
    if (texels.current == 0u) texels.tiles0 = count;
    else texels.tiles1 = count;
  } else {
    ++texels.coarser;
  }
  texels.clearGroupsX = fits ? 0u : texelGroups(config.table);
  texels.clearGroupsY = 1u;
  texels.clearGroupsZ = 1u;
  texels.wantedGroupsX = fits ? 0u : texelGroups(count);
  texels.wantedGroupsY = 1u;
  texels.wantedGroupsZ = 1u;
  texels.tileGroupsX = texelGroups(count);
  texels.tileGroupsY = 1u;
  texels.tileGroupsZ = 1u;
  texels.oldGroupsX = texelGroups(texels.current == 0u ? texels.tiles1 : texels.tiles0);
  texels.oldGroupsY = 1u;
  texels.oldGroupsZ = 1u;
}
