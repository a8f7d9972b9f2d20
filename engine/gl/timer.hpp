// Time of one stretch of GL work. Two modes: GPU timestamps, or finish and wall clock.
#pragma once

#include <chrono>

#include "engine/gl/objects.hpp"

namespace tessera::gl {

enum class TimerMode {
  Query,  // GL_TIME_ELAPSED: GPU time, no stall before the result is asked for
  Wall    // glFinish around the work and the wall clock: for software renderers, where queries read 0 for
          // compute and for draws without rasterization (llvmpipe, Mesa 22.3)
};

inline TimerMode timerModeFor(const ContextInfo& info) {
  return info.software ? TimerMode::Wall : TimerMode::Query;
}
inline const char* nameOf(TimerMode mode) {
  return mode == TimerMode::Query ? "gl-time-elapsed" : "finish+wall-clock";
}

class Timer {
 public:
  explicit Timer(TimerMode mode);
  void begin();
  void end();
  /// Milliseconds between begin and end; waits for the GPU in Query mode.
  [[nodiscard]] double milliseconds() const;

 private:
  TimerMode mode_;
  Query query_;
  std::chrono::steady_clock::time_point start_{};
  double wall_ = 0.0;
};

}  // namespace tessera::gl
