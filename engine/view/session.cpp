#include "engine/view/session.hpp"

#include "engine/view/camera.hpp"
#include "engine/view/session_state.hpp"

namespace tessera::view {

Session::State::State(SessionOptions sessionOptions) : options(std::move(sessionOptions)) {}

Session::State::~State() {
  stopping = true;
  videoWork.stop();
  applyWork.stop();
  for (std::thread* thread : {&networkThread, &decodeThread, &applyThread})
    if (thread->joinable()) thread->join();
}

Result<void> Session::State::connect() {
  auto started_ = transport::Client::start(options.client);
  if (!started_) return tl::unexpected(started_.error());
  client = std::move(*started_);
  earlierVideo = {};
  return {};
}

void Session::State::run() {
  networkThread = std::thread([this] { network(); });
  decodeThread = std::thread([this] { decode(); });
  applyThread = std::thread([this] { apply(); });
}

void Session::State::breakStream(Generation of, std::string reason) {
  const std::lock_guard lock(mutex);
  if (of == generation && !broken) broken = {of, std::move(reason)};
}

Session::Session(std::unique_ptr<State> state) : state_(std::move(state)) {}
Session::~Session() = default;

Result<std::unique_ptr<Session>> Session::start(SessionOptions options) {
  if (!(options.posesPerSecond > 0.0 && options.posesPerSecond <= 1000.0))
    return fail("{} poses a second are outside (0, 1000]", options.posesPerSecond);
  auto state = std::make_unique<State>(std::move(options));
  if (auto connected = state->connect(); !connected) return tl::unexpected(connected.error());
  state->run();
  return std::unique_ptr<Session>(new Session(std::move(state)));
}

void Session::pose(const wire::Camera& camera) {
  const std::lock_guard lock(state_->mutex);
  state_->nextPose = askable(camera);
}

bool Session::take() { return state_->frames.take(); }
const ShadedFrame& Session::frame() const { return state_->frames.reading(); }
Latency& Session::latency() { return state_->latency; }

std::optional<Offer> Session::offer() const {
  const std::lock_guard lock(state_->mutex);
  return state_->offer;
}

Figures Session::figures() const {
  State& s = *state_;
  const std::lock_guard lock(s.mutex);
  Figures figures = s.figures;
  const auto now = Clock::now();
  const std::string server = transport::describe(s.options.client.server);
  if (s.connected) figures.connectedSeconds += std::chrono::duration<double>(now - s.connectedAt).count();
  const auto because = [&](const std::string& text, const std::string& detail) {
    return detail.empty() ? text : text + ": " + detail;
  };
  if (s.final) {
    figures.condition = Condition::Refused;
    figures.why = because("no connection to " + server, s.trouble);
  } else if (!s.connected && s.streamBroken) {
    figures.condition = Condition::StreamBroken;
    figures.why = because("the stream of " + server + " is broken, connecting again", s.trouble);
  } else if (!s.connected && s.generation == 0) {
    figures.condition = Condition::Connecting;
    figures.why = because("connecting to " + server, s.trouble);
  } else if (!s.connected) {
    figures.condition = Condition::ServerGone;
    figures.why = because("server gone, connecting again", s.trouble);
  } else if (s.noPicture == NoPicture::NoVideoYet) {
    figures.condition = Condition::NoVideoYet;
    figures.why = nameOf(s.noPicture);
  } else if (s.noPicture == NoPicture::WaitingForIFrame || s.noPicture == NoPicture::FrameLost) {
    figures.condition = Condition::WaitingForIFrame;
    figures.why = because(nameOf(NoPicture::WaitingForIFrame), s.noPictureDetail);
  } else if (s.noPicture != NoPicture::None) {
    figures.condition = Condition::DecodeFailed;
    figures.why = because(nameOf(s.noPicture), s.noPictureDetail);
  } else if (now - s.lastPicture > s.options.stalled) {
    figures.condition = Condition::Stalled;
    figures.why = fmt::format("no frame from the server for {:.1f} s",
                              std::chrono::duration<double>(now - s.lastPicture).count());
  } else if (s.lastShown < s.connectedAt || now - s.lastShown > s.options.stalled) {
    figures.condition = Condition::Stalled;
    figures.why = "no geometry from the server for the atlas that came";
  } else {
    figures.condition = Condition::Live;
    figures.why.clear();
  }
  return figures;
}

}  // namespace tessera::view
