// Patches: 1 to 3 adjacent triangles of one primitive that will share one block of the atlas. CPU, load time.
// Based on Mueller 2021, sec. 3.3.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "glsl/shared/scene.h"

namespace tessera {

struct PatchOptions {
  bool pair = true;    // false: every triangle alone (what pairing buys is measured against this)
  bool triple = true;  // attach leftover triangles to a neighbouring pair
};

/// The patches of one primitive. `order` lists the primitive's triangles in the order the id pass needs:
/// those of all pairs, then of all triples, then singles; within a patch in the order of PatchGeometry.
struct PatchSet {
  std::vector<glsl::PatchGeometry> patches;  // pairs, then triples, then singles
  std::vector<std::uint32_t> order;          // triangle numbers, a permutation of 0 .. indices.size()/3 - 1
  std::uint32_t pairs = 0;
  std::uint32_t triples = 0;
  std::uint32_t singles = 0;
};

/// Groups the triangles of one primitive. `positions` is the whole vertex array, `indices` the primitive's
/// index range (3 a triangle, absolute, each below positions.size()). Two triangles are adjacent when they
/// share an edge by index, with opposite winding: vertices that differ only in number keep their triangles
/// apart, see engine/scene/weld.hpp. Linear in the number of triangles but for sorting. Deterministic.
///
/// Corner order: a pair's v0-v2 is the shared edge, and winding then leaves only a half turn to choose, so
/// which of the two axes is the longer one cannot be chosen here. A single has its largest angle, or what
/// stretches least, at v1, and of equal choices the one with v0-v1 the longer leg.
PatchSet buildPatches(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                      const PatchOptions& options = {});

/// How large a block has to be so that no triangle of the patch gets less than one texel a unit of area,
/// along its worst direction: an area in the units of `positions`, at least the patch's own area. The block's
/// sides are in the proportion of the patch's edges. A flat rectangle needs exactly its area, a lone triangle
/// at least twice its own. This is what the matching saves on; report the ratio to the area as the mean
/// distortion of a scene.
double patchBlockArea(std::span<const glm::vec3> positions, const glsl::PatchGeometry& patch);

}  // namespace tessera
