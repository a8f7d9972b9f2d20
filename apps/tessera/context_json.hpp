// The context of a run, the way every JSON file of the program names it.
#pragma once

#include <nlohmann/json.hpp>

#include "engine/gl/timer.hpp"

namespace tessera::app {

inline nlohmann::json contextJson(const gl::ContextInfo& info, gl::TimerMode timer) {
  return {{"backend", info.backendName}, {"renderer", info.renderer},  {"gl", info.version},
          {"glsl", info.glslVersion},    {"stand_ins", info.standIns}, {"timer", gl::nameOf(timer)}};
}

}  // namespace tessera::app
