// H.264 for streaming: CAVLC, one reference frame, no B-frames, no delay (Mueller et al. 2018, sec. 5.6), on
// libavcodec.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "codec/region.hpp"
#include "engine/core/result.hpp"
#include "engine/image/yuv.hpp"

namespace tessera {

enum class RateControl : std::uint8_t {
  Bitrate,          // bits a second, whatever the quality
  ConstantQuality,  // a quantizer, whatever the bits
};

struct EncoderOptions {
  int width =
      0;  // texels, [16, 16384]; even for 4:2:0. Need not be multiples of 16: the stream says how to crop
  int height = 0;
  Chroma chroma = Chroma::Yuv420;
  double framesPerSecond = 30.0;  // (0, 1000]; what bits a second are divided by
  RateControl rate = RateControl::Bitrate;
  std::int64_t bitrate = 20'000'000;  // bits a second, [10'000, 2'000'000'000]; for Bitrate
  /// Bits that may come at once, in seconds of the bitrate, (0, 10]: what a receiver must hold back, and what
  /// lets an I-frame be larger than others.
  double bufferSeconds = 0.2;
  double quality =
      23.0;  // [0, 51], less is better; for ConstantQuality: x264's CRF, other encoders' quantizer
  int iFrameInterval = 30;  // frames from one I-frame to the next, [0, 1'000'000]; 0: only when asked
  int threads = 0;          // [0, 64]; 0: the encoder's choice. With libx264 also how many slices a frame has
  /// Names of libavcodec's encoders, of which the first that opens is taken; empty: defaultEncoders().
  std::vector<std::string> encoders;
  /// The encoder's own name of a trade of time for bits ("superfast"); empty: what suits streaming.
  std::string preset;
};

/// What is tried where no encoder is named: hardware, then libx264.
[[nodiscard]] const std::vector<std::string>& defaultEncoders();

struct EncodeOptions {
  bool iFrame = false;  // an I-frame now; the interval counts from it
  /// Of regions that overlap, the first holds. Ignored by encoders that take none, see takesRegions.
  std::span<const Region> regions = {};
};

/// One frame as it is sent. `bytes` begins with a stamp (codec/stamp.hpp), and a decoder that has seen
/// nothing before can begin with any I-frame.
struct EncodedFrame {
  std::uint64_t frame = 0;
  std::uint64_t reference = 0;  // the frame that it builds on; itself for an I-frame
  std::vector<std::uint8_t> bytes;
  double milliseconds = 0.0;  // that encoding took
  [[nodiscard]] bool iFrame() const { return frame == reference; }
};

/// Move only. One thread at a time.
class VideoEncoder {
 public:
  /// Fails where an option is out of range, named with its value, and where no encoder opens: with each that
  /// was tried and why it did not.
  static Result<VideoEncoder> create(const EncoderOptions& options);
  VideoEncoder(VideoEncoder&& other) noexcept;
  VideoEncoder& operator=(VideoEncoder&& other) noexcept;
  ~VideoEncoder();

  /// Encodes one frame at once. `frame` numbers rise from call to call, by any step. Fails, and leaves all as
  /// it was, where the planes are not of the options' size and chroma, where numbers do not rise, and for a
  /// region out of range. Fails where the encoder does, or holds the frame back; the next frame is then an
  /// I-frame.
  Result<EncodedFrame> encode(const YuvView& planes, std::uint64_t frame, const EncodeOptions& options = {});

  /// libavcodec's name of the encoder that was taken.
  [[nodiscard]] const std::string& name() const;
  /// Whether this encoder moves the quantizer where regions say so.
  [[nodiscard]] bool takesRegions() const;

 private:
  struct State;
  explicit VideoEncoder(std::unique_ptr<State> state);
  std::unique_ptr<State> s_;
};

}  // namespace tessera
