// The thread that decodes video, and the one that applies geometry and pairs both.
#include <algorithm>

#include <fmt/core.h>

#include "engine/view/session_state.hpp"

namespace tessera::view {

void Session::State::decode() {
  // Slices side by side: no frame waits for the next.
  auto decoder =
      VideoDecoder::create({.threads = std::clamp(int(std::thread::hardware_concurrency()) / 2, 1, 8)});
  Generation of = 0;
  while (!stopping) {
    for (const VideoWork& work : videoWork.take()) {
      if (!decoder) {
        breakStream(work.generation, decoder.error().message);
        break;
      }
      if (work.generation < of) continue;
      if (work.generation != of) decoder->reset();
      of = work.generation;
      // Decoding all that waits would show an ever older atlas; an I-frame begins anew.
      if (const auto behind = Clock::now() - work.came; behind > options.longestBacklog)
        skip(work, behind);
      else
        decodeOne(*decoder, work);
    }
  }
}

void Session::State::decodeOne(VideoDecoder& decoder, const VideoWork& work) {
  const Decoded decoded = decoder.decode(work.bytes);
  const auto now = Clock::now();
  if (decoded.picture) {
    latency.add(Stage::Decode, millisecondsBetween(work.came, now));
    Picture picture{static_cast<std::uint32_t>(decoded.frame), copyOf(*decoded.picture), work.came, now};
    const std::size_t bytes = picture.planes.bytes.size();
    // A picture that finds no room is one that is not shown.
    applyWork.push({work.generation, std::move(picture)}, bytes);
  }
  const std::lock_guard lock(mutex);
  if (work.generation != generation) return;
  if (decoded.picture) {
    ++figures.atlasFrames;
    lastPicture = now;
    noPicture = NoPicture::None;
    noPictureDetail.clear();
  } else if (decoded.reason != NoPicture::Late) {
    noPicture = decoded.reason;
    noPictureDetail = decoded.detail;
  }
  if (decoded.wantsIFrame) askIFrame(static_cast<std::uint32_t>(decoded.frame), now);
}

void Session::State::askIFrame(std::uint32_t frame, Clock::time_point now) {
  if (now - lastAsk < options.askAgain) return;
  lastAsk = now;
  ++figures.askedIFrames;
  outbox.emplace_back(wire::AskIFrame{frame});
}

void Session::State::skip(const VideoWork& work, Clock::duration behind) {
  const std::lock_guard lock(mutex);
  if (work.generation != generation) return;
  noPicture = NoPicture::FrameLost;
  noPictureDetail =
      fmt::format("decoding was {:.1f} s behind", std::chrono::duration<double>(behind).count());
  askIFrame(0, Clock::now());
}

void Session::State::apply() {
  std::optional<FramePairs> pairs;
  Generation of = 0;
  while (!stopping) {
    for (ApplyWork& work : applyWork.take()) {
      // The decoder may still have had one of an earlier connection.
      if (work.generation < of) continue;
      if (work.generation != of) pairs.reset();
      of = work.generation;
      if (auto done = applyOne(pairs, work); !done) {
        breakStream(of, done.error().message);
        pairs.reset();
      }
    }
    if (!pairs) continue;
    auto whole = pairs->next(frames.writing());
    if (!whole) {
      breakStream(of, whole.error().message);
      pairs.reset();
      continue;
    }
    if (!*whole) continue;
    const ShadedFrame& frame = frames.writing();
    const FrameTimes& t = frame.times;
    latency.add(Stage::Receive, std::max(0.0, millisecondsBetween(t.header, t.video)));
    latency.add(Stage::Apply, millisecondsBetween(t.decoded, t.applied));
    const wire::Acknowledge acknowledge{frame.header.frame, frame.header.frame, secondsOf(t.applied)};
    frames.publish();
    const std::lock_guard lock(mutex);
    if (of != generation) continue;
    lastShown = Clock::now();
    outbox.emplace_back(acknowledge);
  }
}

Result<void> Session::State::applyOne(std::optional<FramePairs>& pairs, ApplyWork& work) {
  if (const auto* setup = std::get_if<wire::StreamSetup>(&work.what)) {
    pairs.emplace(*setup);
    return {};
  }
  if (!pairs) return {};  // of a stream that broke, or video that outran its set-up
  if (const auto* header = std::get_if<HeaderWork>(&work.what)) {
    pairs->header(header->header, header->came, header->posed);
    return {};
  }
  if (auto* geometry = std::get_if<wire::Geometry>(&work.what)) return pairs->geometry(std::move(*geometry));
  if (auto* mask = std::get_if<wire::MaskImage>(&work.what)) {
    pairs->mask(std::move(*mask));
    return {};
  }
  return pairs->picture(std::move(std::get<Picture>(work.what)));
}

}  // namespace tessera::view
