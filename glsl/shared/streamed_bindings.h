// Buffer bindings and uniform locations of streamed geometry, which a viewer draws from: where it is drawn, nothing of a
// scene is bound. The rest is in bindings.h. Numbers only; the preprocessor of both languages reads it.
#ifndef TESSERA_GLSL_SHARED_STREAMED_BINDINGS_H
#define TESSERA_GLSL_SHARED_STREAMED_BINDINGS_H
#include "shared/bindings.h"

// Shader storage
#define BIND_STREAMED_VERTICES 0   // StreamedVertex[]
#define BIND_STREAMED_TRIANGLES 1  // StreamedTriangle[]
#define BIND_STREAMED_ELEMENTS 2   // StreamedPatch[] or StreamedTess[]
#define BIND_STREAMED_PIECES 3     // uint[]
#define BIND_STREAMED_OBJECTS 4    // vec4[3 * objects]: rows of matrices to the world, relative to the eye
#define BIND_STREAMED_MASK_AT 5    // vec2[vertices]
#define BIND_STREAMED_MASKS 6      // StreamedMask[]
#define BIND_STREAMED_ALPHA 7      // uint[]: four texels each

#define LOCATION_STREAMED_SHADED 9

#endif
