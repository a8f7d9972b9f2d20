// The steps from a checked glTF file to a Scene, in the order in which loadGltf takes them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/result.hpp"
#include "engine/scene/gltf_accessor.hpp"
#include "engine/scene/gltf_document.hpp"
#include "engine/scene/gltf_tinygltf.hpp"
#include "engine/scene/scene.hpp"

namespace tessera {

/// Collects what is not applied: one line a kind, with the first element and how many more there are.
class GltfWarnings {
 public:
  void add(const std::string& what, const std::string& element);
  /// "morph targets are not applied (mesh 0 and 2 more)", in the order of their first appearance.
  [[nodiscard]] std::vector<std::string> lines() const;

 private:
  struct Entry {
    std::string what;
    std::string element;
    std::size_t more = 0;
  };
  std::vector<Entry> entries_;
};

/// What all steps read. `file` begins every error.
struct GltfInput {
  const std::string& file;
  const GltfDocument& document;
  const tinygltf::Model& model;
  const GltfAccessors& accessors;
  GltfWarnings& warnings;
};

/// Fills scene.materials, one a glTF material; the slots' `image` is the glTF index for buildImages to
/// replace.
Result<void> buildMaterials(const GltfInput& input, Scene& scene);

/// Fills scene.images with the images that materials use and makes the slots point at them. `decode` false
/// leaves them without pixels, but still finds their bytes. An unused image that is missing or of another
/// format is a warning. Decodes on two threads, 4 GiB of pixels at most.
Result<void> buildImages(const GltfInput& input, const std::filesystem::path& folder, bool decode,
                         Scene& scene);

/// Fills scene.cameras and scene.lights, one a glTF camera and light.
Result<void> buildCamerasAndLights(const GltfInput& input, Scene& scene);

/// Fills scene.nodes with what the default scene reaches (else scene 0, else all), parents first. Returns the
/// node that each glTF node became, kNone for those left out.
Result<std::vector<std::uint32_t>> buildNodes(const GltfInput& input, Scene& scene);

/// Fills scene.meshes (one a glTF mesh), primitives, vertices and indices; needs materials and nodes. Meshes
/// that no node shows are checked, but keep no primitives. Appends the default material if a primitive has
/// none. 2^26 vertices and 2^28 indices at most.
Result<void> buildMeshes(const GltfInput& input, Scene& scene);

/// Fills scene.instances, 2^24 at most.
Result<void> buildInstances(const GltfInput& input, Scene& scene);

/// Fills scene.animations; channels of nodes that are left out are dropped.
Result<void> buildAnimations(const GltfInput& input, const std::vector<std::uint32_t>& nodes, Scene& scene);

}  // namespace tessera
