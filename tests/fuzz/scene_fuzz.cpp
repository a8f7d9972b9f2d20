// Any bytes as a glTF or GLB file: a scene whose indices hold, or one clear error.
#include "engine/scene/finite.hpp"
#include "engine/scene/gltf.hpp"
#include "tests/fuzz/input_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tessera::test::InputFile gltf(".gltf");
  static const tessera::test::InputFile glb(".glb");
  const bool binary = size >= 4 && data[0] == 'g' && data[1] == 'l' && data[2] == 'T' && data[3] == 'F';
  auto scene = tessera::loadGltf((binary ? glb : gltf).write(data, size));
  if (!scene) {
    if (scene.error().message.empty()) std::abort();
    return 0;
  }
  for (const std::uint32_t index : scene->indices)
    if (index >= scene->vertices.position.size()) std::abort();
  for (const tessera::Instance& instance : scene->instances)
    if (instance.node >= scene->nodes.size() || instance.primitive >= scene->primitives.size()) std::abort();
  for (const tessera::Primitive& primitive : scene->primitives)
    if (primitive.material >= scene->materials.size()) std::abort();
  tessera::makeFinite(*scene);
  tessera::SceneState state;
  tessera::evaluate(*scene, 0.7, state);
  return 0;
}
