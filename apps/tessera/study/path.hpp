// What the viewer's camera does while it is measured.
#pragma once

#include <vector>

#include "apps/tessera/study/settings.hpp"
#include "apps/tessera/study/timing.hpp"

namespace tessera::app {

/// A piece of a recorded camera path, in time from the first server frame on.
class StudyPath {
 public:
  /// `recorded` as viewsOf() gives it, at the display's rate. Fails where it is too short for the samples and
  /// the time before them.
  static Result<StudyPath> of(std::vector<TimedView> recorded, const StudySettings& settings);

  /// The pose at a time; its scene time is `sceneTime(time)`.
  [[nodiscard]] TimedView at(double time) const;
  [[nodiscard]] double sceneTime(double time) const { return moving_ ? start_ + time : start_; }
  [[nodiscard]] double start() const { return start_; }  // of the path, seconds
  [[nodiscard]] const Samples& samples() const { return samples_; }
  /// Of the camera over the samples, means.
  [[nodiscard]] double metresPerSecond() const;
  [[nodiscard]] double degreesPerSecond() const;

 private:
  std::vector<TimedView> recorded_;
  Samples samples_;
  double start_ = 0.0;
  bool moving_ = false;
};

}  // namespace tessera::app
