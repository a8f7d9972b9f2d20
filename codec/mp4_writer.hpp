// H.264 packets in an MP4 file that browsers play.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "codec/encoder.hpp"

namespace tessera {

/// Move only. One thread at a time.
class Mp4Writer {
 public:
  /// For pictures of this size, so many a second, (0, 1000], that are to be shown evenly. Fails where
  /// libavformat has no MP4 muxer.
  static Result<Mp4Writer> create(int width, int height, double framesPerSecond);
  Mp4Writer(Mp4Writer&& other) noexcept;
  Mp4Writer& operator=(Mp4Writer&& other) noexcept;
  ~Mp4Writer();

  /// The next picture, as VideoEncoder gave it. Fails for a first one that is no I-frame with its parameter
  /// sets, and for bytes that do not begin with a whole stamp.
  Result<void> add(const EncodedFrame& frame);
  /// The file. Fails without a picture. Nothing can be added afterwards.
  Result<std::vector<std::uint8_t>> finish();

 private:
  struct State;
  explicit Mp4Writer(std::unique_ptr<State> state);
  std::unique_ptr<State> s_;
};

}  // namespace tessera
