// A viewer's display loop without what it is shown on: poses out, frames in, figures kept.
#pragma once

#include <atomic>
#include <fstream>
#include <optional>

#include "apps/tessera/view/options.hpp"
#include "engine/view/display.hpp"
#include "engine/view/session.hpp"

namespace tessera::app {

/// The camera of a path at its own time, the one that eye and target say, or the one that the server begins
/// with. What the server has must be learned first.
class Flight {
 public:
  /// Fails for eye without target, both at one point, and a file that holds no path.
  static Result<Flight> of(const ViewOptions& options, glm::ivec2 size);
  [[nodiscard]] bool known() const { return near_.has_value(); }
  /// Takes the near plane, and what else the options leave to the server. Fails, naming those that there are,
  /// where the server has no path of the name that was asked for.
  Result<void> learn(const view::Offer& offer);
  [[nodiscard]] bool moves() const { return path_.has_value(); }
  /// `seconds` from the path's start; anywhere before it is known.
  [[nodiscard]] wire::Camera at(double seconds) const;
  /// Frames of the whole path at so many a second; 1 without one.
  [[nodiscard]] int frames(double fps) const;

 private:
  wire::Camera cameraOf(const CameraKey& key) const;
  std::string wanted_;  // name of a path
  std::optional<double> fovY_;
  std::optional<double> near_;
  std::optional<CameraPath> path_;
  std::optional<wire::Camera> camera_;
  glm::ivec2 size_{0};
};

/// From stopOnSignals() on, whether SIGINT or SIGTERM came: what was measured is written then too.
std::atomic<bool>& stopAsked();
void stopOnSignals();

class Viewing {
 public:
  /// Connects. Fails for what the session or the display cannot start with, and files that cannot be written.
  static Result<Viewing> start(const ViewOptions& options, const gl::Context& context, Flight flight);

  /// Known from the step after the server has said its cameras, where the flight is one of those.
  [[nodiscard]] const Flight& flight() const { return flight_; }
  /// Sends the pose once the flight is known, takes the newest frame and draws it for the camera into
  /// display().color(). Fails where the display does, and where Flight::learn() does.
  Result<void> step(const wire::Camera& camera);
  /// After the picture is on its way to the screen: the frame's time is over.
  Result<void> shown();

  [[nodiscard]] bool hasPicture() const { return shownFrame_ != 0; }
  [[nodiscard]] int framesShown() const { return framesShown_; }
  [[nodiscard]] double seconds() const;
  [[nodiscard]] const view::Figures& figures() const { return figures_; }
  [[nodiscard]] const view::StreamedDisplay& display() const { return *display_; }
  [[nodiscard]] double latency(view::Stage stage) const { return session_->latency().median(stage); }
  [[nodiscard]] double frameMs() const { return frameMs_; }
  [[nodiscard]] std::uint64_t uncovered() const { return uncovered_; }
  /// Uncovered pixels of the last picture, where they can be none of the background.
  [[nodiscard]] std::optional<std::uint64_t> missed() const;
  [[nodiscard]] std::uint32_t shownFrame() const { return shownFrame_; }
  /// DIR/0001.png, ...
  Result<void> record(const Image& picture);
  /// Where --stats says.
  [[nodiscard]] Result<void> writeStats() const;

 private:
  Viewing(const ViewOptions& options, Flight flight) : options_(&options), flight_(std::move(flight)) {}
  const ViewOptions* options_;
  Flight flight_;
  std::unique_ptr<view::Session> session_;
  std::optional<view::StreamedDisplay> display_;
  view::Figures figures_;
  view::Clock::time_point started_ = view::Clock::now();
  view::Clock::time_point lastShown_ = started_;
  std::ofstream csv_;
  std::optional<double> firstPicture_;
  std::uint32_t shownFrame_ = 0;
  int framesShown_ = 0;
  int recorded_ = 0;
  double frameMs_ = 0.0;
  std::uint64_t uncovered_ = 0;
  std::uint64_t uncoveredSum_ = 0;
  std::uint64_t missedSum_ = 0;
  int framesClosed_ = 0;  // shown, and all that is uncovered in them is missing
};

}  // namespace tessera::app
