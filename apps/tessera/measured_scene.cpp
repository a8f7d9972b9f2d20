#include "apps/tessera/measured_scene.hpp"

#include <filesystem>
#include <utility>

namespace tessera::app {

Result<MeasuredScene> loadMeasured(const std::string& file, const StageChoice& stageChoice,
                                   const CameraChoice& cameraChoice, glm::ivec2 size,
                                   const std::function<void(const std::string&)>& step) {
  auto stage = loadStageFor(stageChoice, file);
  if (!stage) return tl::unexpected(stage.error());
  auto scene = loadGltf(file, {.loadImages = true, .progress = step});
  if (!scene) return tl::unexpected(scene.error());
  const Stage* lit = *stage ? &**stage : nullptr;
  CameraChoice camera = cameraChoice;
  if (auto covered = coverPath(camera, lit); !covered) return tl::unexpected(covered.error());
  auto views = viewsOf(camera, *scene, lit, size);
  if (!views) return tl::unexpected(views.error());
  MeasuredScene measured;
  SceneState state;
  evaluate(*scene, 0.0, state);
  measured.lights = evaluateLights(*scene, state, lit, 0.0).size();
  measured.stageNote =
      lit != nullptr ? "stage " + std::filesystem::path(lit->file).filename().string() : "no stage";
  measured.path = camera.path.empty() ? "none" : camera.path;
  measured.views = std::move(*views);
  measured.scene = std::move(*scene);
  measured.stage = std::move(*stage);
  return measured;
}

}  // namespace tessera::app
