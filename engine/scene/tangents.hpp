// Tangents from texture coordinates, for normal maps whose mesh brings none. CPU, load time.
// Behaves as Mikkelsen 2008, "Simulation of wrinkled surfaces revisited", sec. 4, so that maps baked for that
// basis look as meant: the glTF specification asks for it.
#pragma once

#include <cstdint>

#include "engine/scene/scene.hpp"

namespace tessera {

/// Fills Vertices::tangent of a primitive from its positions, normals and UV set 0 or 1 (not transformed by
/// KHR_texture_transform). xyz is unit and perpendicular to the normal; w is +1 where the picture is not
/// mirrored on the surface, else -1, so that w * cross(normal, tangent) points up the picture, against v.
///
/// Corners of equal position, normal and UV share one tangent where their triangles meet along edges and have
/// the same handedness, weighted by the corners' angles. A vertex that needs several tangents is split:
/// copies are added at the end of all arrays, so the primitive's vertices must be the last of the scene.
/// Triangles without area or without UV area follow their neighbours, else get any perpendicular.
void generateTangents(Scene& scene, std::uint32_t primitive, int uvSet);

}  // namespace tessera
