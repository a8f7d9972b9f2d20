// Puts geometry and atlas of one frame together: they come by different ways, and either may be late or, of
// the atlas, lost.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "engine/core/result.hpp"
#include "engine/view/shaded_frame.hpp"

namespace tessera::view {

/// What of a decoded atlas goes to the display.
struct Picture {
  std::uint32_t frame = 0;
  YuvImage planes;
  Clock::time_point video;
  Clock::time_point decoded;
};

/// One a connection; one thread. Geometry waits for its atlas, since it says where things lie in that one. An
/// atlas without geometry waits for that. What is older than what was shown is dropped.
class FramePairs {
 public:
  /// What may wait. Past it, geometry is applied without being shown, and the oldest atlas dropped.
  struct Limits {
    std::size_t messages = 600;
    std::size_t bytes = std::size_t{64} << 20;
    std::size_t pictures = 4;
  };
  explicit FramePairs(const wire::StreamSetup& setup) : FramePairs(setup, Limits()) {}
  FramePairs(const wire::StreamSetup& setup, const Limits& limits);

  void header(const wire::FrameHeader& header, Clock::time_point came, Clock::time_point posed);
  /// Fails where VisibleMirror::apply does, on a message that waited: the stream is lost then.
  Result<void> geometry(wire::Geometry geometry);
  /// Fails for a size that is not the set-up's.
  Result<void> picture(Picture picture);
  void mask(wire::MaskImage mask);

  /// Fills `frame` with the newest frame that is whole and was not given yet. False where there is none; then
  /// `frame` is as it was. Fails as geometry() does.
  Result<bool> next(ShadedFrame& frame);

  /// Frame of the last geometry message that was applied; 0 before the first.
  [[nodiscard]] std::uint32_t applied() const { return applied_; }

 private:
  struct Waiting {
    wire::FrameHeader header;
    Clock::time_point came;
    Clock::time_point posed;
    std::optional<wire::Geometry> geometry;
  };
  Result<void> applyOldest();

  wire::StreamSetup setup_;
  Limits limits_;
  wire::VisibleMirror mirror_;
  std::deque<Waiting> waiting_;  // frames rise
  std::map<std::uint32_t, Picture> pictures_;
  std::vector<wire::MaskImage> masks_;
  std::shared_ptr<const std::vector<wire::MaskImage>> shownMasks_;  // a copy; null where it is old
  std::size_t waitingBytes_ = 0;
  std::uint32_t applied_ = 0;
  std::uint32_t shown_ = 0;
};

}  // namespace tessera::view
