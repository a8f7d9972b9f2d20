// Pictures of many samples a pixel.
#pragma once

#include "engine/image/image.hpp"

namespace tessera::app {

/// `factor` x `factor` pixels of a picture become one: the mean of their light, and of their alpha. Rows and
/// columns that are left over are dropped; `factor` is 1 at least.
Image averaged(const Image& image, int factor);

}  // namespace tessera::app
