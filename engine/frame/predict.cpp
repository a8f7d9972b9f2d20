#include "engine/frame/predict.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera {

namespace {

/// Columns are right, up and back, orthonormal.
glm::dmat3 axesOf(const View& view) {
  const glm::dvec3 right = glm::normalize(glm::cross(view.forward, view.up));
  return {right, glm::cross(right, view.forward), -view.forward};
}

/// The unit quaternion of a rotation to the power `t`.
glm::dquat power(glm::dquat rotation, double t) {
  // Of the two quaternions of a rotation, that of the shorter way.
  if (rotation.w < 0.0) rotation = -rotation;
  const glm::dvec3 v(rotation.x, rotation.y, rotation.z);
  const double sine = glm::length(v);
  const double half = std::atan2(sine, rotation.w);
  // Below this sin(t half) / sin(half) is t to the last digit, and at 0 nothing else is.
  constexpr double kSmall = 1e-9;
  const double scale = sine > kSmall ? std::sin(t * half) / sine : t;
  return {std::cos(t * half), v.x * scale, v.y * scale, v.z * scale};
}

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

Result<void> check(const PvsOptions& options) {
  if (!(options.latency >= 0.0 && options.latency <= 10.0))
    return fail("prediction: latency of {} s is outside [0, 10]", options.latency);
  if (options.steps < 1 || options.steps > 64)
    return fail("prediction: {} steps are outside [1, 64]", options.steps);
  if (!(options.margin >= 0.0 && options.margin <= std::numbers::pi / 4.0))
    return fail("prediction: margin of {} degrees is outside [0, 45]", glm::degrees(options.margin));
  return {};
}

View moved(const View& a, const View& b, double fraction) {
  // Who stands still is not turned by rounding.
  if (a == b) return b;
  const double ahead = fraction - 1.0;
  View result = b;
  result.eye += ahead * (b.eye - a.eye);
  const glm::dquat turn = power(glm::quat_cast(axesOf(b) * glm::transpose(axesOf(a))), ahead);
  const glm::dvec3 forward = turn * b.forward;
  const glm::dvec3 up = turn * b.up;
  if (!finite(result.eye) || !finite(forward) || !finite(up)) return b;
  // Rounding must not add up over the poses of a long run; the axes of b are taken as they are.
  if (ahead != 0.0) {
    result.forward = glm::normalize(forward);
    result.up = glm::normalize(up - glm::dot(up, result.forward) * result.forward);
  }
  return result;
}

bool PoseTrack::add(const TimedView& pose) {
  if (!std::isfinite(pose.time)) return false;
  if (last_ && pose.time < last_->time) return false;
  if (last_ && pose.time - last_->time >= kShortestStep) previous_ = last_;
  last_ = pose;
  return true;
}

std::optional<View> PoseTrack::at(double time) const {
  if (!last_) return std::nullopt;
  if (!previous_) return last_->view;
  return moved(previous_->view, last_->view, (time - previous_->time) / (last_->time - previous_->time));
}

View sampleRecorded(std::span<const TimedView> recorded, double time) {
  const auto after = std::upper_bound(recorded.begin(), recorded.end(), time,
                                      [](double t, const TimedView& pose) { return t < pose.time; });
  if (after == recorded.begin()) return recorded.front().view;
  if (after == recorded.end()) return recorded.back().view;
  const TimedView& before = *(after - 1);
  const double fraction = (time - before.time) / (after->time - before.time);
  // At its own time a pose is itself, whatever rounding there is in the sum that is the time.
  constexpr double kSame = 1e-6;
  if (fraction < kSame) return before.view;
  if (fraction > 1.0 - kSame) return after->view;
  return moved(before.view, after->view, fraction);
}

std::vector<double> pvsTimes(double now, const PvsOptions& options) {
  std::vector<double> times = {now};
  if (options.prediction == Prediction::None || options.latency == 0.0) return times;
  for (int i = 1; i <= options.steps; ++i) times.push_back(now + options.latency * i / options.steps);
  return times;
}

std::vector<TimedView> predictedViews(const PoseTrack& track, std::span<const TimedView> recorded,
                                      const PvsOptions& options) {
  std::vector<TimedView> views;
  if (!track.last()) return views;
  for (const double time : pvsTimes(track.last()->time, options)) {
    if (views.empty())
      views.push_back(*track.last());
    else if (options.prediction == Prediction::Reference)
      views.push_back({time, sampleRecorded(recorded, time)});
    else
      views.push_back({time, *track.at(time)});
  }
  return views;
}

Result<View> widened(const View& view, double margin) {
  constexpr double kWidest = 85.0 * std::numbers::pi / 180.0;
  constexpr int kMostPixels = 16384;
  const double pixel = 2.0 * std::tan(0.5 * view.fovY) / view.height;  // at distance 1
  const auto wider = [&](int pixels) -> Result<int> {
    const double tangent = 0.5 * pixel * pixels;
    const double half = std::atan(tangent) + margin;
    if (!(half <= kWidest))
      return fail("prediction: a margin of {:g} degrees makes a view of {:g} degrees to each side, past {:g}",
                  glm::degrees(margin), glm::degrees(half), glm::degrees(kWidest));
    // A hair less, so that a margin of 0 stays one.
    const double more = std::ceil((std::tan(half) - tangent) / pixel - 1e-9);
    if (pixels + 2.0 * more > kMostPixels)
      return fail("prediction: a margin of {:g} degrees makes {} pixels {}, past {}", glm::degrees(margin),
                  pixels, pixels + 2.0 * more, kMostPixels);
    return pixels + 2 * static_cast<int>(more);
  };
  const auto width = wider(view.width);
  if (!width) return tl::unexpected(width.error());
  const auto height = wider(view.height);
  if (!height) return tl::unexpected(height.error());
  View result = view;
  if (*width == view.width && *height == view.height) return result;
  result.width = *width;
  result.height = *height;
  result.fovY = 2.0 * std::atan(0.5 * pixel * *height);
  return result;
}

Result<std::vector<TimedView>> widened(std::span<const TimedView> views, double margin) {
  std::vector<TimedView> wider;
  for (const TimedView& timed : views) {
    auto view = widened(timed.view, margin);
    if (!view) return tl::unexpected(view.error());
    wider.push_back({timed.time, *view});
  }
  return wider;
}

}  // namespace tessera
