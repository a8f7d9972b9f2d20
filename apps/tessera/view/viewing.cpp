#include "apps/tessera/view/viewing.hpp"

#include <cmath>
#include <csignal>

#include <nlohmann/json.hpp>

#include "apps/tessera/report_output.hpp"
#include "engine/core/file.hpp"
#include "engine/view/camera.hpp"

namespace tessera::app {

Result<Flight> Flight::of(const ViewOptions& options, glm::ivec2 size) {
  Flight flight;
  flight.size_ = size;
  flight.fovY_ = options.fovY;
  if (options.eye.empty() != options.target.empty()) return fail("--eye and --target go together");
  if (!options.path.empty()) {
    if (!options.eye.empty()) return fail("--eye with --target, and --path exclude each other");
    if (!std::filesystem::exists(options.path)) {
      flight.wanted_ = options.path;
      return flight;
    }
    auto path = loadCameraPath(options.path);
    if (!path) return tl::unexpected(path.error());
    flight.path_ = std::move(*path);
  } else if (!options.eye.empty()) {
    CameraKey key;
    key.eye = {options.eye[0], options.eye[1], options.eye[2]};
    key.target = {options.target[0], options.target[1], options.target[2]};
    if (key.eye == key.target) return fail("--eye and --target are the same point");
    flight.camera_ = flight.cameraOf(key);
  }
  return flight;
}

wire::Camera Flight::cameraOf(const CameraKey& key) const {
  return view::lookAt(key.eye, key.target, fovY_.value_or(key.fovY), static_cast<std::uint32_t>(size_.x),
                      static_cast<std::uint32_t>(size_.y), near_.value_or(wire::Camera().zNear));
}

Result<void> Flight::learn(const view::Offer& offer) {
  near_ = offer.start.zNear;
  if (camera_) camera_->zNear = *near_;
  if (path_ || camera_) return {};
  if (wanted_.empty()) {
    camera_ = offer.start;
    if (fovY_) {
      const double up = std::tan(0.5 * glm::radians(*fovY_));
      const double across = up * camera_->width / camera_->height;
      camera_->slopes = {-across, across, -up, up};
    }
    camera_ =
        view::resized(*camera_, static_cast<std::uint32_t>(size_.x), static_cast<std::uint32_t>(size_.y));
    return {};
  }
  std::vector<std::string> names;
  for (const wire::Path& path : offer.paths) {
    names.push_back(oneLine(path.name));
    if (path.name != wanted_) continue;
    path_.emplace().name = path.name;
    for (const wire::PathKey& key : path.keys)
      path_->keys.push_back({key.time, key.eye, key.target, key.fovY});
    return {};
  }
  return fail("--path {}: no such file, and the server's stage has {}", wanted_,
              names.empty() ? std::string("no paths") : fmt::format("only {}", fmt::join(names, ", ")));
}

wire::Camera Flight::at(double seconds) const {
  if (path_) return cameraOf(sampleCamera(*path_, path_->keys.front().time + seconds));
  return camera_ ? *camera_ : cameraOf({});
}

int Flight::frames(double fps) const {
  if (!path_) return 1;
  return static_cast<int>(std::floor((path_->keys.back().time - path_->keys.front().time) * fps)) + 1;
}

Result<Viewing> Viewing::start(const ViewOptions& options, const gl::Context& context, Flight flight) {
  Viewing viewing(options, std::move(flight));
  auto display = view::StreamedDisplay::create(context, {.lens = options.lens});
  if (!display) return tl::unexpected(display.error());
  viewing.display_.emplace(std::move(*display));
  view::SessionOptions session;
  session.client.server = options.server;
  session.client.token = options.token;
  session.client.folder = options.keys;
  session.client.log = [](const std::string& line) { fmt::print(stderr, "{}\n", line); };
  if (!options.record.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options.record, error);
    if (error) return fail("--record {}: {}", options.record, error.message());
  }
  if (!options.stats.empty())
    if (auto writable = checkWritable(options.stats); !writable)
      return fail("--stats {}", writable.error().message);
  if (!options.csv.empty()) {
    viewing.csv_.open(options.csv);
    if (!viewing.csv_) return fail("--csv {}: cannot be written", options.csv);
    viewing.csv_ << "time_s,frame_ms,atlas_frame,live,video_mbit_s,meta_mbit_s,loss_percent,round_trip_ms,"
                    "pvs_miss_pixels";
    for (std::size_t i = 0; i < view::kStages; ++i)
      viewing.csv_ << ',' << view::nameOf(static_cast<view::Stage>(i)) << "_ms";
    viewing.csv_ << '\n';
  }
  viewing.started_ = viewing.lastShown_ = view::Clock::now();
  auto started = view::Session::start(std::move(session));
  if (!started) return tl::unexpected(started.error());
  viewing.session_ = std::move(*started);
  return viewing;
}

std::atomic<bool>& stopAsked() {
  static std::atomic<bool> asked = false;
  static_assert(std::atomic<bool>::is_always_lock_free, "set by a signal");
  return asked;
}

void stopOnSignals() {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stopAsked() = true; });
}

double Viewing::seconds() const { return view::millisecondsBetween(started_, view::Clock::now()) * 1e-3; }

Result<void> Viewing::step(const wire::Camera& camera) {
  // The server shades for nobody before a pose.
  if (flight_.known())
    session_->pose(camera);
  else if (const auto offer = session_->offer())
    if (auto learned = flight_.learn(*offer); !learned) return learned;
  figures_ = session_->figures();
  if (session_->take()) {
    const auto taken = view::Clock::now();
    const view::ShadedFrame& frame = session_->frame();
    if (auto uploaded = display_->upload(frame); !uploaded) return uploaded;
    const auto uploadedAt = view::Clock::now();
    view::Latency& latency = session_->latency();
    latency.add(view::Stage::Wait, view::millisecondsBetween(frame.times.applied, taken));
    latency.add(view::Stage::Upload, view::millisecondsBetween(taken, uploadedAt));
    shownFrame_ = frame.header.frame;
    if (!firstPicture_) firstPicture_ = seconds();
  }
  const auto before = view::Clock::now();
  if (options_->stereo)
    display_->drawStereo(camera, kEyeDistance);
  else
    display_->draw(camera);
  // Waits for the GPU, so that the times below are of finished pictures.
  uncovered_ = display_->uncovered().value_or(0);
  const auto now = view::Clock::now();
  if (!hasPicture()) return {};
  session_->latency().add(view::Stage::Display, view::millisecondsBetween(before, now));
  const auto posed = session_->frame().times.posed;
  if (posed != view::Clock::time_point{})
    session_->latency().add(view::Stage::Total, view::millisecondsBetween(posed, now));
  ++framesShown_;
  uncoveredSum_ += uncovered_;
  if (missed()) {
    ++framesClosed_;
    missedSum_ += *missed();
  }
  return {};
}

std::optional<std::uint64_t> Viewing::missed() const {
  // Cracks between triangles show through here and there, in a closed room too.
  constexpr float kClosed = 1e-4f;
  if (!hasPicture() || session_->frame().header.background > kClosed) return std::nullopt;
  return uncovered_;
}

Result<void> Viewing::shown() {
  const auto now = view::Clock::now();
  frameMs_ = view::millisecondsBetween(lastShown_, now);
  lastShown_ = now;
  if (!csv_.is_open()) return {};
  const view::Figures& f = figures_;
  csv_ << fmt::format("{:.4f},{:.2f},{},{},{:.3f},{:.3f},{:.3f},{:.2f},{}", seconds(), frameMs_, shownFrame_,
                      f.condition == view::Condition::Live ? 1 : 0, f.videoMbit, f.metaMbit, f.lossPercent(),
                      f.roundTripMs, missed() ? std::to_string(*missed()) : "");
  for (std::size_t i = 0; i < view::kStages; ++i) {
    const double median = latency(static_cast<view::Stage>(i));
    csv_ << (median < 0.0 ? std::string(",") : fmt::format(",{:.2f}", median));
  }
  csv_ << std::endl;  // whoever follows the file sees whole rows
  if (!csv_) return fail("--csv {}: cannot be written", options_->csv);
  return {};
}

Result<void> Viewing::record(const Image& picture) {
  if (options_->record.empty()) return {};
  return writePng(std::filesystem::path(options_->record) / fmt::format("{:04}.png", ++recorded_), picture);
}

Result<void> Viewing::writeStats() const {
  if (options_->stats.empty()) return {};
  const view::Figures f = session_->figures();
  const double connected = std::max(f.connectedSeconds, 1e-3);
  nlohmann::json stages = nlohmann::json::object();
  for (std::size_t i = 0; i < view::kStages; ++i) {
    const auto stage = static_cast<view::Stage>(i);
    const double median = latency(stage);
    stages[view::nameOf(stage)] = median < 0.0 ? nlohmann::json(nullptr) : nlohmann::json(median);
  }
  const auto mean = [](std::uint64_t sum, int count) {
    return count == 0 ? nlohmann::json(nullptr) : nlohmann::json(static_cast<double>(sum) / count);
  };
  const nlohmann::json stats = {
      {"first_picture_s", firstPicture_ ? nlohmann::json(*firstPicture_) : nlohmann::json(nullptr)},
      {"frames_shown", framesShown_},
      {"atlas_frames_received", f.atlasFrames},
      {"video_mbit_s", 8e-6 * static_cast<double>(f.videoBytes) / connected},
      {"meta_mbit_s", 8e-6 * static_cast<double>(f.metaBytes) / connected},
      {"loss_percent", f.lossPercent()},
      {"i_frames_asked", f.askedIFrames},
      {"reconnects", f.reconnects},
      {"latency_ms", stages},
      {"uncovered_pixels", mean(uncoveredSum_, framesShown_)},
      {"pvs_miss_pixels", mean(missedSum_, framesClosed_)}};
  return writeFile(options_->stats, stats.dump(2) + "\n");
}

}  // namespace tessera::app
