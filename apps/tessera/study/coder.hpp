// Pictures as a viewer gets them: encoded and decoded, with the same options for every method.
#pragma once

#include <span>
#include <vector>

#include "apps/tessera/study/settings.hpp"
#include "codec/video.hpp"

namespace tessera::app {

/// Move only.
class Coder {
 public:
  static Result<Coder> create(int width, int height, double framesPerSecond, double mbit);

  /// The next frame, there and back, regions as VideoEncoder::encode takes them. The picture is valid until
  /// the next call.
  Result<YuvView> pass(const YuvView& planes, bool iFrame, std::span<const Region> regions = {});
  [[nodiscard]] double mbit() const { return mbit_; }  // asked for
  /// Million bits a second that came of it.
  [[nodiscard]] double madeMbit() const;

 private:
  Coder(VideoEncoder encoder, VideoDecoder decoder)
      : encoder_(std::move(encoder)), decoder_(std::move(decoder)) {}
  VideoEncoder encoder_;
  VideoDecoder decoder_;
  double framesPerSecond_ = 0.0;
  double mbit_ = 0.0;
  std::uint64_t frames_ = 0;
  std::uint64_t bytes_ = 0;
};

/// One for each bitrate.
Result<std::vector<Coder>> codersFor(int width, int height, double framesPerSecond,
                                     const std::vector<double>& bitratesMbit);

}  // namespace tessera::app
