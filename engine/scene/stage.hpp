// A stage: the lights, ambient and camera paths that a scene file does not bring. JSON, see
// assets/stages/README.md.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.hpp"
#include "engine/scene/scene.hpp"

namespace tessera {

struct CameraKey {
  double time = 0.0;  // seconds, strictly increasing along a path
  glm::dvec3 eye{0.0};
  glm::dvec3 target{0.0, 0.0, -1.0};
  double fovY = 60.0;  // degrees
};

/// A camera path: Catmull-Rom through the keys (passes through each key at its time), clamped at the ends.
struct CameraPath {
  std::string name;
  std::vector<CameraKey> keys;  // at least one
};

/// Where someone looked at a time.
struct GazeKey {
  double time = 0.0;      // seconds, strictly increasing along a recording
  glm::dvec2 place{0.5};  // share of the picture from its top left, within kGazeFarthest
};

struct Ambient {
  // Radiance from above and below; equal for a constant ambient. Linear.
  glm::vec3 sky{0.03f};
  glm::vec3 ground{0.03f};
  [[nodiscard]] bool hemisphere() const { return sky != ground; }
};

struct StageLightKey {
  double time = 0.0;  // seconds
  glm::dvec3 position{0.0};
  glm::dvec3 target{0.0, -1.0, 0.0};
  glm::vec3 color{1.0f};
  float intensity = 1.0f;
};

struct StageLight {
  Light light;  // type, range, cones, castsShadow; colour and intensity come from the keys
  std::vector<StageLightKey> keys;  // at least one; linear between keys
  bool loop = true;                 // repeats after the last key, else holds it
};

struct Stage {
  std::string file;
  bool sceneLights = true;  // keep the lights of the scene file
  bool sceneLightsCastShadows = false;
  std::optional<Ambient> ambient;  // absent: the default ambient
  float exposure = 1.0f;           // multiplies radiance before tone mapping
  std::vector<StageLight> lights;
  std::vector<CameraPath> paths;
};

/// A punctual light in world space at one time: what the GPU is given.
struct LightSample {
  LightType type = LightType::Point;
  glm::vec3 radiance{1.0f};  // color * intensity
  glm::dvec3 position{0.0};
  glm::dvec3 direction{0.0, -1.0, 0.0};  // unit, the way light travels
  float range = 0.0f;                    // 0 = unlimited
  float innerCone = 0.0f;                // radians
  float outerCone = 0.785398163f;
  bool castsShadow = false;
  bool moves = false;  // its place or direction changes over time
};

Result<Stage> loadStage(const std::filesystem::path& path);
/// Reads a bare path file: {"keyframes": [{"t", "eye", "target", "fov_y"}]}.
Result<CameraPath> loadCameraPath(const std::filesystem::path& path);

/// Reads an eye tracker's recording: [{"time", "x", "y"}, ...], at least one key.
Result<std::vector<GazeKey>> loadGaze(const std::filesystem::path& path);

CameraKey sampleCamera(const CameraPath& path, double time);
/// Linear between keys, held before the first and after the last. `keys` is not empty.
glm::dvec2 sampleGaze(std::span<const GazeKey> keys, double time);
/// All lights of scene and stage at the state's time, scene lights first. `stage` may be null.
std::vector<LightSample> evaluateLights(const Scene& scene, const SceneState& state, const Stage* stage,
                                        double time);

}  // namespace tessera
