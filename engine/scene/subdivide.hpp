// Splitting of large triangles, so that a floor of two triangles becomes many patches: a block of the atlas
// has a largest size, and only what is visible should be shaded. CPU, load time.
#pragma once

#include <cstdint>

#include "engine/scene/scene.hpp"

namespace tessera {

struct SubdivideOptions {
  double maxEdgeShare = 1.0 / 24.0;  // longest edge, as a share of the diagonal of the scene's bounds; > 0
  std::uint64_t maxAddedTriangles = 500'000;  // of the file, not as instanced; past it the limit is relaxed
};

struct SubdivideReport {
  double maxEdge = 0.0;  // metres: the limit that was kept, 0 if there was none
  bool relaxed = false;  // the limit had to be raised to stay within maxAddedTriangles
  std::uint64_t trianglesBefore = 0;
  std::uint64_t trianglesAfter = 0;
};

/// Splits every edge longer than the limit at its middle, again and again. Lengths are in world space at time
/// 0, over all instances of the mesh.
///
/// Whether an edge is split, and where, follows from the positions of its ends alone: triangles that met
/// along an edge still do, also across seams of normals or UVs and across the primitives of a mesh. Two
/// triangles that make a flat convex quad with affine attributes are cut across, into rows of quads; a
/// rectangle becomes a grid with diagonals all one way. Diagonals of such quads may be longer than the limit
/// (up to sqrt 2 times in a rectangle, never more than twice), sides may not. Attributes are means of the
/// ends', normals and tangents not brought to unit length, so that a split triangle interpolates as the whole
/// one did.
///
/// Ranges of primitives stay contiguous and in order; vertices and indices of primitives that are split grow,
/// those of others move. Primitives without an instance are left alone.
SubdivideReport splitLongEdges(Scene& scene, const SubdivideOptions& options = {});

}  // namespace tessera
