// H.264 as it comes from a network: packets that are missing, damaged, late or of another size. A picture is
// shown whole or not at all, and where there is none the decoder says why.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "engine/core/result.hpp"
#include "engine/image/yuv.hpp"

namespace tessera {

/// Why a packet gave no picture.
enum class NoPicture : std::uint8_t {
  None,              // it gave one
  NoVideoYet,        // no packet has come
  WaitingForIFrame,  // it builds on a frame that is not here: none was seen yet, or one was lost before
  FrameLost,         // it builds on a frame that never came
  Damaged,           // bytes are missing or differ from what was sent
  Late,              // one as new or newer was decoded before
  DecodeFailed,      // the decoder refused it, or decoded it with errors
  WrongColors,       // the stream says another colour matrix or range, or another pixel format
};
/// In a few words, fit for an overlay: "waiting for an I-frame".
[[nodiscard]] const char* nameOf(NoPicture reason);

struct DecoderOptions {
  int threads = 1;  // [1, 64]; within a frame, over its slices: never a frame of delay
  /// Of one picture, [256, kMaxImagePixels]: a stream that claims more is refused before memory is taken.
  std::size_t maxPixels = kMaxImagePixels;
};

/// What came of one packet.
struct Decoded {
  std::optional<YuvView> picture;  // valid until the next call
  std::uint64_t frame = 0;         // the packet's number; 0 where it is too damaged to tell
  bool iFrame = false;
  NoPicture reason = NoPicture::None;
  std::string detail;         // of the reason, with numbers; empty with a picture
  bool wantsIFrame = false;   // nothing will be shown until one comes
  double milliseconds = 0.0;  // that decoding took
};

/// Move only. One thread at a time. Any bytes may be given.
class VideoDecoder {
 public:
  /// Fails where an option is out of range, and where libavcodec has no H.264 decoder.
  static Result<VideoDecoder> create(const DecoderOptions& options = {});
  VideoDecoder(VideoDecoder&& other) noexcept;
  VideoDecoder& operator=(VideoDecoder&& other) noexcept;
  ~VideoDecoder();

  /// One packet as VideoEncoder gave it, to its picture at once. After a loss or damage no frame gives one
  /// until the next I-frame, whose size may be another.
  Decoded decode(std::span<const std::uint8_t> packet);
  /// Forgets all: for a stream that begins anew, whose numbers may be lower.
  void reset();
  /// Why the last packet gave no picture; NoVideoYet before the first.
  [[nodiscard]] NoPicture status() const;

 private:
  struct State;
  explicit VideoDecoder(std::unique_ptr<State> state);
  std::unique_ptr<State> s_;
};

}  // namespace tessera
