#include "engine/view/frame_pairs.hpp"

#include <algorithm>

namespace tessera::view {

FramePairs::FramePairs(const wire::StreamSetup& setup, const Limits& limits)
    : setup_(setup), limits_(limits), mirror_(setup.method, {setup.width, setup.height}) {}

void FramePairs::header(const wire::FrameHeader& header, Clock::time_point came, Clock::time_point posed) {
  waiting_.push_back({header, came, posed, std::nullopt});
}

Result<void> FramePairs::applyOldest() {
  const Waiting& oldest = waiting_.front();
  if (oldest.geometry) {
    if (auto done = mirror_.apply(oldest.geometry->changes); !done)
      return fail("geometry of frame {}: {}", oldest.header.frame, done.error().message);
    waitingBytes_ -= oldest.geometry->changes.size();
    applied_ = oldest.header.frame;
  }
  waiting_.pop_front();
  return {};
}

Result<void> FramePairs::geometry(wire::Geometry geometry) {
  const auto at = std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiting& w) {
    return w.header.frame == geometry.frame && !w.geometry;
  });
  if (at == waiting_.end()) return fail("geometry of frame {}: no such frame was announced", geometry.frame);
  waitingBytes_ += geometry.changes.size();
  at->geometry = std::move(geometry);
  while (waiting_.size() > 1 && (waiting_.size() > limits_.messages || waitingBytes_ > limits_.bytes))
    if (auto done = applyOldest(); !done) return done;
  return {};
}

Result<void> FramePairs::picture(Picture picture) {
  if (picture.planes.width != static_cast<int>(setup_.width) ||
      picture.planes.height != static_cast<int>(setup_.height))
    return fail("video of frame {} is {}x{}, the atlas {}x{}", picture.frame, picture.planes.width,
                picture.planes.height, setup_.width, setup_.height);
  if (picture.frame <= shown_ || picture.frame <= applied_) return {};
  const std::uint32_t frame = picture.frame;
  pictures_.insert_or_assign(frame, std::move(picture));
  while (pictures_.size() > limits_.pictures) pictures_.erase(pictures_.begin());
  return {};
}

void FramePairs::mask(wire::MaskImage mask) {
  const auto same = std::find_if(masks_.begin(), masks_.end(),
                                 [&](const wire::MaskImage& other) { return other.number == mask.number; });
  if (same != masks_.end())
    *same = std::move(mask);
  else
    masks_.push_back(std::move(mask));
  shownMasks_ = nullptr;
}

Result<bool> FramePairs::next(ShadedFrame& frame) {
  // The newest frame of which both are here.
  std::uint32_t newest = 0;
  for (const Waiting& waiting : waiting_)
    if (waiting.geometry && pictures_.count(waiting.header.frame) > 0) newest = waiting.header.frame;
  if (newest == 0) return false;
  while (waiting_.front().header.frame != newest)
    if (auto done = applyOldest(); !done) return tl::unexpected(done.error());
  const Waiting last = waiting_.front();
  if (auto done = applyOldest(); !done) return tl::unexpected(done.error());
  Picture& picture = pictures_.at(newest);
  frame.header = last.header;
  // Copied once, however many came in between.
  if (!shownMasks_) shownMasks_ = std::make_shared<const std::vector<wire::MaskImage>>(masks_);
  frame.masks = shownMasks_;
  frame.take(mirror_);
  std::swap(frame.atlas, picture.planes);
  frame.times = {last.posed, last.came, picture.video, picture.decoded, Clock::now()};
  pictures_.erase(pictures_.begin(), pictures_.upper_bound(newest));
  shown_ = newest;
  return true;
}

}  // namespace tessera::view
