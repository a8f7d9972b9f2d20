// Numbers that are infinite or not a number, as a host that makes its own scene may pass them: what one of
// them would spread to (a picture, an atlas, the bounds of a scene) is spared.
#pragma once

#include "engine/scene/scene.hpp"

namespace tessera {

/// Factors and vertex attributes that are not finite become those of a material or vertex that has none (a
/// normal: no length, for which shading takes the direction to the eye). Triangles with such a corner lose
/// their area, and instances whose node's place is not finite, or past what floats hold, are left out. Bounds
/// are mended.
void makeFinite(Scene& scene);

}  // namespace tessera
