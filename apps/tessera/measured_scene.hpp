// A scene with what lights it and the views that it is measured in.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/tessera/options.hpp"

namespace tessera::app {

struct MeasuredScene {
  Scene scene;
  std::optional<Stage> stage;
  std::vector<TimedView> views;
  std::size_t lights = 0;
  std::string stageNote;  // "stage sponza.json", "no stage"
  std::string path;       // the camera path's name, or "none"
};

/// Loads `file` with the stage chosen or shipped for it. Short runs see as much of its path as long ones;
/// without a path, its first camera sees it, or one from outside. `step` hears of progress.
Result<MeasuredScene> loadMeasured(const std::string& file, const StageChoice& stage,
                                   const CameraChoice& camera, glm::ivec2 size,
                                   const std::function<void(const std::string&)>& step);

}  // namespace tessera::app
