// Bytes as a .glb or .gltf file: loading fails in one line, or gives a scene that keeps every promise of
// scene.hpp.
#include <cmath>
#include <cstring>

#include "engine/scene/finite.hpp"
#include "engine/scene/gltf.hpp"
#include "engine/scene/subdivide.hpp"
#include "tests/fuzz/input_file.hpp"
#include "tests/scene/scene_invariants.hpp"

namespace {

bool isBinary(const std::uint8_t* data, std::size_t size) {
  return size >= 4 && std::memcmp(data, "glTF", 4) == 0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  static const test::InputFile gltf(".gltf");
  static const test::InputFile glb(".glb");
  auto scene = loadGltf((isBinary(data, size) ? glb : gltf).write(data, size));
  if (!scene) {
    const std::string& message = scene.error().message;
    test::demand(!message.empty(), "an error without words");
    test::demand(message.find('\n') == std::string::npos, "an error of several lines: " + message);
    return 0;
  }
  for (const std::string& warning : scene->warnings)
    test::demand(warning.find('\n') == std::string::npos, "a warning of several lines: " + warning);
  const std::string broken = test::brokenInvariant(*scene);
  test::demand(broken.empty(), broken);
  makeFinite(*scene);
  SceneState state;
  for (const double time : {0.0, 0.37, 1e6, -1.0}) {
    evaluate(*scene, time, state);
    test::demand(state.world.size() == scene->nodes.size(), "a node without a matrix");
  }
  splitLongEdges(*scene, {.maxEdgeShare = 0.25, .maxAddedTriangles = 2000});
  // Means of normals and tangents are finite, and of any length.
  for (glm::vec3& n : scene->vertices.normal) {
    test::demand(!glm::any(glm::isnan(n)) && !glm::any(glm::isinf(n)),
                 "a normal that is not finite, after splitting");
    n = {0.0f, 0.0f, 1.0f};
  }
  for (glm::vec4& t : scene->vertices.tangent) t = {1.0f, 0.0f, 0.0f, 1.0f};
  const std::string split = test::brokenInvariant(*scene);
  test::demand(split.empty(), "after splitting: " + split);
  return 0;
}

#ifdef TESSERA_FUZZER
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

std::uint32_t read32(const std::uint8_t* at) {
  std::uint32_t value = 0;
  std::memcpy(&value, at, 4);
  return value;
}
void write32(std::uint8_t* at, std::size_t value) {
  const auto bits = static_cast<std::uint32_t>(value);
  std::memcpy(at, &bits, 4);
}

}  // namespace

/// Mostly mutates the JSON of a .glb and repairs the lengths around it: blind changes break these first, and
/// nothing behind them would ever run.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned seed) {
  constexpr std::size_t kHead = 20;  // of the file, and of its first chunk
  if (seed % 4 == 0 || !isBinary(data, size) || size < kHead) return LLVMFuzzerMutate(data, size, most);
  const std::size_t text = read32(data + 12);
  if (text > size - kHead) return LLVMFuzzerMutate(data, size, most);
  const std::string rest(reinterpret_cast<const char*>(data + kHead + text), size - kHead - text);
  if (seed % 4 == 1 && rest.size() > 8) {
    // The numbers behind it instead, their chunk's head left alone.
    const std::size_t start = kHead + text + 8;
    LLVMFuzzerMutate(data + start, size - start, size - start);
    return size;
  }
  const std::size_t room = most - std::min(most, kHead + rest.size() + 3);
  if (room < 8) return size;
  std::size_t now = LLVMFuzzerMutate(data + kHead, std::min(text, room), room);
  while (now % 4 != 0) data[kHead + now++] = ' ';
  std::memcpy(data + kHead + now, rest.data(), rest.size());
  write32(data + 8, kHead + now + rest.size());
  write32(data + 12, now);
  return kHead + now + rest.size();
}
#endif
