// What `tessera compare` was asked for.
#pragma once

#include <string>
#include <vector>

#include "apps/tessera/options.hpp"

namespace tessera::app {

/// MSSIM is always taken.
struct MetricChoice {
  bool psnr = true;
  bool flip = true;  // and with it the error pictures
};

struct CompareOptions {
  std::vector<std::string> scenes;
  std::string output;
  std::vector<std::string> methods = {"forward", "rect", "rect:bias=-2", "rect-deferred", "forward-prepass"};
  std::vector<std::string> figures;  // "4.1" and so on, or "all"
  std::vector<std::string> pvs;      // "0.1,40" and so on, or "all"
  bool equalSamples = false;         // biases for as many samples as rect's
  bool curve = false;                // samples against quality over biases
  std::vector<std::string> metrics = {"mssim", "psnr", "flip"};
  double eyeDistance = 0.063;  // metres
  int warmup = 2;
  int repeats = 1;
  ContextChoice context;
  SizeChoice size;
  CameraChoice camera;
  StageChoice stage;
  AtlasChoice atlas;
  SpatialChoice spatial;
  std::string command;
};

}  // namespace tessera::app
