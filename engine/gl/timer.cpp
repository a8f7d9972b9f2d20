#include "engine/gl/timer.hpp"

namespace tessera::gl {

Timer::Timer(TimerMode mode) : mode_(mode) {
  if (mode == TimerMode::Query) query_ = Query(GL_TIME_ELAPSED);
}

void Timer::begin() {
  if (mode_ == TimerMode::Query) {
    query_.begin();
    return;
  }
  api().Finish();
  start_ = std::chrono::steady_clock::now();
}

void Timer::end() {
  if (mode_ == TimerMode::Query) {
    query_.end();
    return;
  }
  api().Finish();
  wall_ = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
}

double Timer::milliseconds() const {
  return mode_ == TimerMode::Query ? static_cast<double>(query_.result()) * 1e-6 : wall_;
}

}  // namespace tessera::gl
