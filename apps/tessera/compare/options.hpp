// What `tessera compare` was asked for.
#pragma once

#include <string>
#include <vector>

#include "apps/tessera/options.hpp"

namespace tessera::app {

struct CompareOptions {
  std::vector<std::string> scenes;
  std::string output;
  std::vector<std::string> methods = {"forward", "rect", "rect:bias=-2", "rect-deferred", "forward-prepass"};
  int warmup = 2;
  int repeats = 1;
  ContextChoice context;
  SizeChoice size;
  CameraChoice camera;
  StageChoice stage;
  AtlasChoice atlas;
  std::string command;
};

}  // namespace tessera::app
