// Sorting instances into batches, and the draw lists of a view. CPU only.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/rect/patches.hpp"
#include "engine/frame/view.hpp"
#include "engine/scene/scene.hpp"
#include "glsl/shared/blocks.h"
#include "glsl/shared/scene.h"

namespace tessera {

/// Instances that share a material and a draw state. Order of batches: opaque single-sided, opaque
/// double-sided, masked, blended; so that passes which need no material draw long runs of them at once.
struct Batch {
  std::uint32_t material = 0;
  bool vertexColor = false;
  bool mask = false;
  bool blend = false;
  bool doubleSided = false;
  std::uint32_t firstInstance = 0;  // into DrawScene::instances
  std::uint32_t instanceCount = 0;
  std::uint32_t firstEntry = 0;  // draw entries of the visible set: a patch has one, a triple two
  std::uint32_t entryCapacity = 0;
  std::uint32_t firstTriangle = 0;  // of all triangle instances, in the order of batches
  std::uint32_t triangles = 0;
};

/// A scene made ready for drawing: patches built, instances sorted by batch. BLEND instances are apart, and
/// neither visible-set nor atlas geometry, but where the atlas is asked to hold them: then they are both.
struct DrawScene {
  std::vector<std::uint32_t> indices;  // as Scene::indices, triangles sorted by patch within each primitive
  std::vector<glsl::PatchGeometry> patches;
  std::vector<std::uint32_t> patchOffset;  // first patch of each primitive
  std::vector<PatchSet> patchCounts;       // counts only (patches and order moved out), one a primitive
  std::vector<Batch> batches;
  std::vector<Instance> instances;     // opaque, masked and blended ones of the atlas, sorted by batch
  std::vector<std::uint32_t> batchOf;  // one an instance
  std::vector<Instance> blended;       // all, as they are drawn over a picture
  std::vector<std::uint32_t> instanceOfPatch;  // one a patch instance
  std::vector<std::uint32_t> patchBase;        // one an instance
  std::uint32_t patchInstances = 0;
  std::uint32_t entries = 0;    // capacity over all batches
  std::uint32_t triangles = 0;  // of `instances`

  // What the patch stage made of the scene, for `info` and reports.
  std::uint64_t trianglesPaired = 0;
  std::uint64_t trianglesTripled = 0;
  std::uint64_t trianglesAlone = 0;
  double patchSeconds = 0.0;
};

/// `blended`: the atlas holds BLEND instances too.
DrawScene prepare(const Scene& scene, const PatchOptions& options, bool blended = false);

/// Draw commands of consecutive instances with one state.
struct DrawRange {
  std::uint32_t batch = 0;
  bool mirrored = false;
  std::uint32_t first = 0;  // into DrawList::commands
  std::uint32_t count = 0;
};

struct DrawList {
  std::vector<glsl::DrawCommand> commands;
  std::vector<DrawRange> ranges;
  std::uint64_t triangles = 0;
};

/// World boxes of the draw scene's instances at a state.
std::vector<Box> instanceBounds(const Scene& scene, std::span<const Instance> instances,
                                const SceneState& state);
/// Bounds of a box under an affine transform.
Box transformBox(const Box& box, const glm::dmat4& world);

/// The draws of all instances whose box touches one of the frusta; boxes and frusta in the same space. Of the
/// batches that blend, or of those that do not.
DrawList cull(const Scene& scene, const DrawScene& draw, std::span<const Box> bounds,
              const std::vector<bool>& mirrored, std::span<const Frustum> frusta, bool blended = false);

}  // namespace tessera
