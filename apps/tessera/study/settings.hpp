// What stream-study is asked for.
#pragma once

#include <string>
#include <vector>

#include "apps/tessera/options.hpp"

namespace tessera::app {

/// Of which pose the picture is that is warped.
enum class WarpPose : std::uint8_t {
  Present,   // the newest one that the server knows
  Predicted  // where linear extrapolation says that the viewer will be when it arrives
};

struct StudySettings {
  glm::ivec2 size{640, 360};  // of a shown picture, pixels; even
  double displayHz = 120.0;
  double seconds = 1.0;  // over which samples spread
  int samples = 16;
  double start = -1.0;  // of the path, seconds; negative: so that the middle is sampled
  std::vector<double> latenciesMs{0.0, 25.0, 50.0, 100.0, 150.0, 200.0};
  std::vector<double> serverRates{7.5, 15.0, 30.0, 60.0, 120.0};
  std::vector<double> bitratesMbit{5.0, 10.0, 20.0, 40.0, 80.0};
  double serverHz = 30.0;  // of what is measured by latency and by bitrate
  double mbit = 20.0;      // of what is measured by latency and by rate
  double widening = 0.2;   // share by which the server sees more than a viewer, of the horizontal angle
  int iFrames = 60;        // frames from one I-frame, and reset of the atlas, to the next
  std::vector<double> megapixels{4.0, 8.0};
  double biasFloor = 0.0;  // lowest bias that room in an atlas may lead to: -2 is up to four texels a pixel
  std::vector<std::string> methods{"rect", "tess", "time-warp", "mesh-warp", "iterative-warp"};
  WarpPose warpPose = WarpPose::Present;
  bool moving = false;  // lights and nodes move; else the scene is as at the path's start
  bool videos = true;
  double videoLatencyMs = 100.0;
  double videoHz = 60.0;  // at which the videos show the viewer's pictures
  bool loopback = true;
};

}  // namespace tessera::app
