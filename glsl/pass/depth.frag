// Depth alone; the alpha test where the material asks for it.
#include "shared/bindings.h"
#include "shared/scene.h"
#include "shared/material.h"
#include "lib/mask.glsl"

void main() {
#ifdef MASK
  if (maskedOut()) discard;
#endif
}
