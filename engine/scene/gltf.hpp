// glTF 2.0 (.gltf with files or data URIs, .glb) to Scene. No GL.
#pragma once

#include <filesystem>
#include <functional>

#include "engine/core/result.hpp"
#include "engine/scene/scene.hpp"

namespace tessera {

struct GltfOptions {
  bool loadImages =
      true;  // false leaves Scene::images with names and no pixels (for `info` and CPU-only tests)
  std::function<void(const std::string& step)> progress;  // called at the start of each step, may be empty
};

/// Loads and checks a scene. Every index, count, offset and float that the engine later trusts is checked
/// here. Errors name file, element and value; a file outside the scene's folder is never read.
Result<Scene> loadGltf(const std::filesystem::path& path, const GltfOptions& options = {});

}  // namespace tessera
