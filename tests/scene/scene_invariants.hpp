// What every loaded scene keeps, whatever its file was.
#pragma once

#include <string>

#include "engine/scene/scene.hpp"

namespace tessera::test {

/// The first promise of scene.hpp that `scene` breaks, in words; empty if it keeps all. With `pixels`, every
/// image is decoded.
std::string brokenInvariant(const Scene& scene, bool pixels = true);

}  // namespace tessera::test
