// Where the alpha of a streamed mask lies, and how it goes on beyond its edges.
#ifndef TESSERA_GLSL_SHARED_STREAMED_MASK_H
#define TESSERA_GLSL_SHARED_STREAMED_MASK_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN

// 32 bytes. One without width holds nothing out.
struct StreamedMask {
  uint start;  // first texel of level 0
  uint width;  // of level 0
  uint height;
  uint levels;
  uint wrapAcross;  // kMaskRepeat...
  uint wrapUp;
  float cutoff;  // alpha below it is a hole
  uint spare;
};
// As wire::Wrap.
SHARED_CONST uint kMaskRepeat = 1u;
SHARED_CONST uint kMaskClamp = 2u;
SHARED_CONST uint kMaskMirror = 3u;

// The texel, below `size`, that stands at `at` of an axis that goes on beyond its edges.
SHARED_FN uint maskWrapped(int at, uint size, uint wrap) {
  int n = int(size);
  if (wrap == kMaskClamp) return uint(at < 0 ? 0 : (at < n ? at : n - 1));
  int period = wrap == kMaskMirror ? 2 * n : n;
  // Of negative numbers GLSL's remainder is undefined.
  int rest = at >= 0 ? at % period : period - 1 - (-1 - at) % period;
  return uint(rest < n ? rest : period - 1 - rest);
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::StreamedMask) == 32);
#endif
#endif
