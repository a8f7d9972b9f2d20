// Any bytes as a stage, a camera path or a gaze recording; the first byte says which.
#include "engine/scene/stage.hpp"
#include "tests/fuzz/input_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tessera::test::InputFile input(".json");
  if (size == 0) return 0;
  const std::filesystem::path& path = input.write(data + 1, size - 1);
  if (data[0] % 3 == 0) {
    if (const auto gaze = tessera::loadGaze(path)) tessera::sampleGaze(*gaze, 0.5);
  } else if (data[0] % 3 == 1) {
    if (const auto found = tessera::loadCameraPath(path)) tessera::sampleCamera(*found, 0.5);
  } else if (const auto stage = tessera::loadStage(path)) {
    tessera::evaluateLights({}, {}, &*stage, 0.5);
    for (const tessera::CameraPath& camera : stage->paths) tessera::sampleCamera(camera, 0.5);
  }
  return 0;
}
