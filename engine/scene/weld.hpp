// Finding and merging equal vertices. Exporters often write three vertices a triangle; patches need shared
// ones.
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

/// Merges the vertices of each primitive that are equal in every attribute, and drops those that no triangle
/// uses. Triangles keep their order, vertices the order of their first copy; ranges of primitives stay
/// contiguous and no longer overlap. Nothing that can be seen changes. Returns how many vertices are gone.
std::size_t weldVertices(Scene& scene);

}  // namespace tessera
