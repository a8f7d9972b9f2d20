// The buffers of the passes that split triangles.
#include "shared/bindings.h"
#include "shared/tess_split.h"
layout(std430, binding = BIND_SPLIT_STATE) buffer SplitStates { TessSplitState split; uint piecesOfBatch[]; };
