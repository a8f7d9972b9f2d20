// Finding equal vertices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/scene/scene.hpp"

namespace tessera {

/// `keys` holds keys of `width` floats each. Gives for each key the number of the first one equal to it: by
/// bits, but 0 equals -0. Linear.
std::vector<std::uint32_t> firstEqual(std::span<const float> keys, std::size_t width);

}  // namespace tessera
