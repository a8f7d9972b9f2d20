// Where a camera will be: the views whose visible sets together are the potentially visible set of a frame
// that is shown later than it is made (Mueller et al. 2018, sec. 4.1). No GL.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/core/result.hpp"
#include "engine/frame/view.hpp"

namespace tessera {

/// A camera, and the scene, at a time in seconds.
struct TimedView {
  double time = 0.0;
  View view;
};

/// How later views are known.
enum class Prediction : std::uint8_t {
  None,      // they are not: the present view alone
  Linear,    // from the last two poses, at the speed between them
  Reference  // from a recorded path, exactly: what no prediction can better
};

/// The views that a potentially visible set is the union of.
struct PvsOptions {
  Prediction prediction = Prediction::Linear;
  double latency = 1.0 / 30.0;  // seconds from the present to the last view, [0, 10]
  int steps = 4;                // views after the present one, evenly apart, [1, 64]
  /// Radians by which each view sees further to each of its four sides, [0, pi/4]. 2 degrees, measured
  /// default: covers what linear prediction errs in 33 ms under a head that turns by 30 degrees to and fro
  /// once a second (1 degree), for 5 % of needless pixels.
  double margin = 2.0 * 0.017453292519943295;
};

/// Fails with the first number that is outside its range.
Result<void> check(const PvsOptions& options);

/// The pose at `fraction` of the way from `a` (0) to `b` (1) and beyond, as a motion of constant speed: the
/// eye on a line, the axes about the axis of the shortest rotation between them. What is not the pose is b's.
/// Exactly b at 1, and for any fraction where the poses are equal. b where the result would not be finite.
View moved(const View& a, const View& b, double fraction);

/// The last two poses of a camera and where they lead.
class PoseTrack {
 public:
  /// Poses closer than this, in seconds, tell nothing of speed: what they differ by is the tracker's noise.
  static constexpr double kShortestStep = 1e-4;
  /// The newest pose. One that is not later than the last by kShortestStep takes its place, and speed is as
  /// before it if any is known; one that is earlier, or whose time is not finite, is dropped (false).
  bool add(const TimedView& pose);
  /// Where the camera will be at a time, by linear extrapolation; after one pose, there. Nothing before one.
  [[nodiscard]] std::optional<View> at(double time) const;
  [[nodiscard]] const std::optional<TimedView>& last() const { return last_; }

 private:
  std::optional<TimedView> previous_, last_;
};

/// The pose of a recording at a time, moved() between the two poses around it; held before the first and
/// after the last. `recorded` is not empty, its times rise.
View sampleRecorded(std::span<const TimedView> recorded, double time);

/// Times of the views of a potentially visible set: the present, and the steps to the end of the latency.
std::vector<double> pvsTimes(double now, const PvsOptions& options);
/// Those views as the client will have them, by the track (Linear) or the recording (Reference; not empty
/// then), without margin: what Engine::place takes, so that levels follow the pixels that are shown. The
/// first is the track's last pose, at its time; empty without one.
std::vector<TimedView> predictedViews(const PoseTrack& track, std::span<const TimedView> recorded,
                                      const PvsOptions& options);

/// The view with `margin` radians more to each side, and with so many pixels more that pixels keep their size
/// and place: pixel (x, y) of `view` is (x + dx, y + dy) of the wider one, dx and dy half of what it is
/// larger by. Rounded up to whole pixels on each side. Fails where that would be more than 85 degrees off the
/// axis or more than 16384 pixels.
Result<View> widened(const View& view, double margin);
/// As above for each: what Engine::findVisible takes.
Result<std::vector<TimedView>> widened(std::span<const TimedView> views, double margin);

}  // namespace tessera
