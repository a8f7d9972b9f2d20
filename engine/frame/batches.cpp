#include "engine/frame/batches.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <tuple>

namespace tessera {

namespace {

struct BatchKey {
  bool blend;
  bool mask;
  bool doubleSided;
  std::uint32_t material;
  bool vertexColor;
  auto operator<=>(const BatchKey&) const = default;
};

BatchKey keyOf(const Scene& scene, const Instance& instance) {
  const Primitive& primitive = scene.primitives[instance.primitive];
  const Material& material = scene.materials[primitive.material];
  return {material.alphaMode == AlphaMode::Blend, material.alphaMode == AlphaMode::Mask, material.doubleSided,
          primitive.material, primitive.hasColor};
}

void buildAllPatches(const Scene& scene, const PatchOptions& options, bool blended, DrawScene& draw) {
  const auto start = std::chrono::steady_clock::now();
  draw.indices = scene.indices;
  draw.patchOffset.resize(scene.primitives.size());
  draw.patchCounts.resize(scene.primitives.size());
  std::vector<std::uint32_t> sorted;
  for (std::size_t i = 0; i < scene.primitives.size(); ++i) {
    const Primitive& primitive = scene.primitives[i];
    draw.patchOffset[i] = static_cast<std::uint32_t>(draw.patches.size());
    if (!blended && scene.materials[primitive.material].alphaMode == AlphaMode::Blend) continue;
    const std::span<const std::uint32_t> indices(scene.indices.data() + primitive.firstIndex,
                                                 primitive.indexCount);
    PatchSet set = buildPatches(scene.vertices.position, indices, options);
    sorted.clear();
    for (const std::uint32_t triangle : set.order)
      sorted.insert(sorted.end(), indices.begin() + 3 * triangle, indices.begin() + 3 * triangle + 3);
    std::copy(sorted.begin(), sorted.end(), draw.indices.begin() + primitive.firstIndex);
    draw.patches.insert(draw.patches.end(), set.patches.begin(), set.patches.end());
    set.patches.clear();
    set.order.clear();
    draw.patchCounts[i] = std::move(set);
  }
  draw.patchSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

DrawScene prepare(const Scene& scene, const PatchOptions& options, bool blended) {
  DrawScene draw;
  buildAllPatches(scene, options, blended, draw);
  for (const Instance& instance : scene.instances) {
    const Material& material = scene.materials[scene.primitives[instance.primitive].material];
    const bool blends = material.alphaMode == AlphaMode::Blend;
    if (blends) draw.blended.push_back(instance);
    if (!blends || blended) draw.instances.push_back(instance);
  }
  std::stable_sort(draw.instances.begin(), draw.instances.end(), [&](const Instance& a, const Instance& b) {
    return std::make_tuple(keyOf(scene, a), a.primitive) < std::make_tuple(keyOf(scene, b), b.primitive);
  });
  draw.batchOf.resize(draw.instances.size());
  draw.patchBase.resize(draw.instances.size());
  for (std::size_t i = 0; i < draw.instances.size(); ++i) {
    const Instance& instance = draw.instances[i];
    const BatchKey key = keyOf(scene, instance);
    if (i == 0 || key != keyOf(scene, draw.instances[i - 1])) {
      Batch batch;
      batch.material = key.material;
      batch.vertexColor = key.vertexColor;
      batch.mask = key.mask;
      batch.blend = key.blend;
      batch.doubleSided = key.doubleSided;
      batch.firstInstance = static_cast<std::uint32_t>(i);
      batch.firstEntry = draw.entries;
      batch.firstTriangle = draw.triangles;
      draw.batches.push_back(batch);
    }
    Batch& batch = draw.batches.back();
    const PatchSet& set = draw.patchCounts[instance.primitive];
    const std::uint32_t patches = set.pairs + set.triples + set.singles;
    draw.batchOf[i] = static_cast<std::uint32_t>(draw.batches.size() - 1);
    draw.patchBase[i] = draw.patchInstances;
    draw.patchInstances += patches;
    draw.instanceOfPatch.insert(draw.instanceOfPatch.end(), patches, static_cast<std::uint32_t>(i));
    ++batch.instanceCount;
    batch.entryCapacity += patches + set.triples;
    draw.entries += patches + set.triples;
    const std::uint32_t triangles = 2 * set.pairs + 3 * set.triples + set.singles;
    batch.triangles += triangles;
    draw.triangles += triangles;
    draw.trianglesPaired += std::uint64_t{2} * set.pairs;
    draw.trianglesTripled += std::uint64_t{3} * set.triples;
    draw.trianglesAlone += set.singles;
  }
  return draw;
}

Box transformBox(const Box& box, const glm::dmat4& world) {
  // Arvo 1990: the extremes of each axis come from the extremes of each term.
  Box out;
  if (box.empty()) return out;
  out.min = out.max = glm::dvec3(world[3]);
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) {
      const double a = world[column][row] * box.min[column];
      const double b = world[column][row] * box.max[column];
      out.min[row] += std::min(a, b);
      out.max[row] += std::max(a, b);
    }
  return out;
}

std::vector<Box> instanceBounds(const Scene& scene, std::span<const Instance> instances,
                                const SceneState& state) {
  std::vector<Box> bounds;
  bounds.reserve(instances.size());
  for (const Instance& instance : instances)
    bounds.push_back(transformBox(scene.primitives[instance.primitive].bounds, state.world[instance.node]));
  return bounds;
}

DrawList cull(const Scene& scene, const DrawScene& draw, std::span<const Box> bounds,
              const std::vector<bool>& mirrored, std::span<const Frustum> frusta, bool blended) {
  const auto seen = [&](const Box& box) {
    return std::any_of(frusta.begin(), frusta.end(),
                       [&](const Frustum& frustum) { return frustum.touches(box); });
  };
  DrawList list;
  for (std::uint32_t b = 0; b < draw.batches.size(); ++b) {
    const Batch& batch = draw.batches[b];
    if (batch.blend != blended) continue;
    for (const bool side : {false, true}) {
      const auto first = static_cast<std::uint32_t>(list.commands.size());
      std::uint32_t last = kNone;  // the instance that the newest command ends with
      for (std::uint32_t i = batch.firstInstance; i < batch.firstInstance + batch.instanceCount; ++i) {
        if (mirrored[i] != side || !seen(bounds[i])) continue;
        const Primitive& primitive = scene.primitives[draw.instances[i].primitive];
        list.triangles += primitive.indexCount / 3;
        if (last != kNone && last + 1 == i && draw.instances[last].primitive == draw.instances[i].primitive)
          ++list.commands.back().instanceCount;
        else
          list.commands.push_back({primitive.indexCount, 1, primitive.firstIndex, 0, i});
        last = i;
      }
      const auto count = static_cast<std::uint32_t>(list.commands.size()) - first;
      if (count > 0) list.ranges.push_back({b, side, first, count});
    }
  }
  return list;
}

}  // namespace tessera
