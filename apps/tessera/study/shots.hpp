// The pictures that a run of a method is asked for.
#pragma once

#include <functional>
#include <vector>

#include "apps/tessera/report/report.hpp"
#include "apps/tessera/study/path.hpp"
#include "engine/image/image.hpp"

namespace tessera::app {

/// A time at which a viewer's picture is taken.
struct Shot {
  double time = 0.0;  // from the first server frame on
  int sample = -1;    // number of the sample; negative: none
  bool filmed = false;
};

/// One stream of a method: frames from time 0 to the last shot, each encoded and decoded at every bitrate.
struct StreamRun {
  double serverHz = 30.0;
  double latency = 0.0;              // seconds
  std::vector<double> bitratesMbit;  // at least one
  std::vector<Shot> shots;           // times rise

  [[nodiscard]] StreamTiming timing() const { return {serverHz, latency}; }
  [[nodiscard]] std::int64_t lastFrame() const { return shownFrame(shots.back().time, timing()); }
};

/// A viewer's picture, and what is known of it.
struct Taken {
  std::size_t bitrate = 0;  // index of the run's
  Shot shot;
  Image picture;
  double uncovered = kNotMeasured;  // pixels
  double ageMs = 0.0;               // of the pose that its frame was made of
};
using Take = std::function<Result<void>(Taken)>;

/// What a run comes to apart from its pictures.
struct StreamFacts {
  int width = 0;  // of the coded picture
  int height = 0;
  std::vector<double> videoMbit;  // by bitrate
  double metaMbit = kNotMeasured;
  double firstMetaBytes = kNotMeasured;
  double atlasUsed = kNotMeasured;
  double bias = kNotMeasured;
};

}  // namespace tessera::app
