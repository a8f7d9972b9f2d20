// The thread that talks with the server: messages in and out, and what the transport reports.
#include <algorithm>
#include <cmath>

#include "codec/wire/handshake.hpp"
#include "engine/view/session_state.hpp"

namespace tessera::view {

namespace {

constexpr std::size_t kRememberedPoses = 512;

// What comes back has been through other forms of the same view.
bool sameView(const wire::Camera& a, const wire::Camera& b) {
  constexpr double kSame = 1e-9;
  return glm::distance(a.eye, b.eye) < kSame &&
         1.0 - std::abs(glm::dot(a.orientation, b.orientation)) < kSame;
}

}  // namespace

void Session::State::network() {
  while (!stopping) {
    if (client) {
      for (transport::ClientEvent& event : client->poll()) {
        handle(event);
        if (!client) break;
      }
    } else if (retryAt && Clock::now() >= *retryAt) {
      retryAt.reset();
      if (auto again = connect(); !again) giveUp(again.error().message, true);
    }
    std::optional<std::pair<Generation, std::string>> lost;
    {
      const std::lock_guard lock(mutex);
      lost.swap(broken);
    }
    if (lost && client) giveUp(lost->second, false);
    if (client) {
      sendWhatWaits();
      countVideo();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  client.reset();
}

void Session::State::giveUp(std::string reason, bool final_) {
  if (options.client.log) options.client.log("view: " + reason);
  if (client) countVideo();
  client.reset();
  const std::lock_guard lock(mutex);
  if (connected)
    figures.connectedSeconds += std::chrono::duration<double>(Clock::now() - connectedAt).count();
  connected = false;
  trouble = std::move(reason);
  final = final_;
  streamBroken = !final_;
  if (final_) return;
  retryAt = Clock::now() + backoff;
  backoff = std::min(2 * backoff, options.longestBackoff);
}

void Session::State::handle(transport::ClientEvent& event) {
  if (std::holds_alternative<transport::Connected>(event)) {
    earlierVideo = {};
    parser = wire::MessageParser(wire::Role::Server);
    order = wire::MessageOrder(wire::Role::Server);
    sentPoses.clear();
    poseNumber = 0;
    const std::lock_guard lock(mutex);
    if (++generation > 1) ++figures.reconnects;
    connected = true;
    streamBroken = false;
    trouble.clear();
    noPicture = NoPicture::NoVideoYet;
    noPictureDetail.clear();
    connectedAt = Clock::now();
    lastAsk = {};
    outbox.clear();
    // The transport has shown its knowledge of the token.
    outbox.emplace_back(wire::Hello{wire::kSpoken, wire::Role::Viewer, ""});
  } else if (auto* gone = std::get_if<transport::Disconnected>(&event)) {
    const std::lock_guard lock(mutex);
    if (connected)
      figures.connectedSeconds += std::chrono::duration<double>(Clock::now() - connectedAt).count();
    connected = false;
    trouble = gone->reason;
    final = !gone->retrying;
  } else if (auto* message = std::get_if<transport::ServerMessage>(&event)) {
    receive(message->bytes);
  } else if (auto* video = std::get_if<transport::VideoFrame>(&event)) {
    // A full queue loses the frame, and the decoder asks for an I-frame.
    const std::size_t bytes = video->frame.bytes.size();
    videoWork.push({generation, std::move(video->frame.bytes), Clock::now()}, bytes);
  }
}

void Session::State::receive(const transport::Bytes& bytes) {
  {
    const std::lock_guard lock(mutex);
    figures.metaBytes += bytes.size();
    metaRate.add(figures.metaBytes, secondsOf(Clock::now()));
    figures.metaMbit = metaRate.mbitPerSecond();
  }
  parser.feed(bytes);
  while (client) {
    auto message = parser.next();
    if (!message) return giveUp(message.error().message, false);
    if (!*message) return;
    if (auto good = order.accept(**message); !good) return giveUp(good.error().message, false);
    receive(**message);
  }
}

void Session::State::receive(wire::Message& message) {
  const auto pass = [&](ApplyWork work, std::size_t bytes) {
    if (!applyWork.push(std::move(work), bytes)) giveUp("the server sends more than can be applied", false);
  };
  if (const auto* refusal = std::get_if<wire::Refusal>(&message)) {
    const bool passes =
        refusal->reason == wire::RefusalReason::Busy || refusal->reason == wire::RefusalReason::Closing;
    return giveUp("refused: " + oneLine(refusal->why), !passes);
  }
  if (const auto* setup = std::get_if<wire::StreamSetup>(&message)) return pass({generation, *setup}, 0);
  if (auto* header = std::get_if<wire::FrameHeader>(&message)) {
    const auto now = Clock::now();
    const auto posed = sentPose(header->camera);
    if (posed != Clock::time_point{}) latency.add(Stage::Server, millisecondsBetween(posed, now));
    {
      const std::lock_guard lock(mutex);
      ++figures.frames;
    }
    return pass({generation, HeaderWork{std::move(*header), now, posed}}, 0);
  }
  if (auto* geometry = std::get_if<wire::Geometry>(&message)) {
    const std::size_t bytes = geometry->changes.size();
    return pass({generation, std::move(*geometry)}, bytes);
  }
  if (auto* mask = std::get_if<wire::MaskImage>(&message)) {
    const std::size_t bytes = mask->alpha.size();
    return pass({generation, std::move(*mask)}, bytes);
  }
}

// A camera that stands still is that of many poses: which of them it was is not known.
Clock::time_point Session::State::sentPose(const wire::Camera& camera) const {
  Clock::time_point found{};
  for (const SentPose& sent : sentPoses) {
    if (!sameView(sent.camera, camera)) continue;
    if (found != Clock::time_point{}) return {};
    found = sent.at;
  }
  return found;
}

void Session::State::countVideo() {
  const transport::ClientStatus status = client->status();
  const transport::VideoStatistics& now = status.video;
  const std::lock_guard lock(mutex);
  // A new connection counts from 0.
  const auto grown = [](std::uint64_t value, std::uint64_t& before) {
    const std::uint64_t more = value >= before ? value - before : value;
    before = value;
    return more;
  };
  figures.videoBytes += grown(now.bytes, earlierVideo.bytes);
  figures.packets += grown(now.packets, earlierVideo.packets);
  figures.lostPackets += grown(now.lost, earlierVideo.lost);
  figures.roundTripMs = status.roundTripMs;
  videoRate.add(figures.videoBytes, secondsOf(Clock::now()));
  figures.videoMbit = videoRate.mbitPerSecond();
}

void Session::State::sendWhatWaits() {
  std::vector<wire::Message> messages;
  const auto now = Clock::now();
  {
    const std::lock_guard lock(mutex);
    if (!connected) return;
    messages.swap(outbox);
    const bool due = secondsOf(now) - secondsOf(lastPose) >= 1.0 / options.posesPerSecond;
    if (nextPose && due) {
      messages.emplace_back(wire::Pose{++poseNumber, secondsOf(now), *nextPose});
      sentPoses.push_back({*nextPose, now});
      if (sentPoses.size() > kRememberedPoses) sentPoses.pop_front();
      lastPose = now;
      nextPose.reset();
    }
  }
  for (const wire::Message& message : messages) {
    const auto bytes = wire::encode(message);
    // A connection that takes nothing ends, and that is an event.
    if (bytes) (void)client->send(*bytes);
  }
}

}  // namespace tessera::view
