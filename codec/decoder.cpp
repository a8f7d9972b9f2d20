#include "codec/decoder.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "codec/frame_planes.hpp"
#include "codec/libav.hpp"
#include "codec/stamp.hpp"

extern "C" {
#include <libavutil/pixdesc.h>
}

namespace tessera {

const char* nameOf(NoPicture reason) {
  switch (reason) {
    case NoPicture::None:
      return "a picture";
    case NoPicture::NoVideoYet:
      return "no video yet";
    case NoPicture::WaitingForIFrame:
      return "waiting for an I-frame";
    case NoPicture::FrameLost:
      return "a frame was lost";
    case NoPicture::Damaged:
      return "a frame was damaged";
    case NoPicture::Late:
      return "a frame came late";
    case NoPicture::DecodeFailed:
      return "decoding failed";
    case NoPicture::WrongColors:
      return "the video's colours are not BT.709, full range";
  }
  return "unknown";
}

namespace {

Result<libav::Owned<AVCodecContext>> open(const DecoderOptions& options) {
  const AVCodec* codec = avcodec_find_decoder(AV_CODEC_ID_H264);
  if (codec == nullptr) return fail("video: this libavcodec has no H.264 decoder");
  libav::Owned<AVCodecContext> context(avcodec_alloc_context3(codec));
  if (!context) return fail("video: no memory for a decoder");
  context->log_level_offset = libav::kSilent;
  context->thread_count = options.threads;
  context->thread_type = FF_THREAD_SLICE;  // threads over frames would each hold one back
  context->flags |= AV_CODEC_FLAG_LOW_DELAY;
  context->max_pixels = static_cast<std::int64_t>(options.maxPixels);
  // What is wrong is refused, not guessed at.
  context->err_recognition = AV_EF_EXPLODE | AV_EF_BITSTREAM | AV_EF_BUFFER;
  // Concealment stays on, though a picture that has any is refused below: without it libavcodec (59.37) does
  // not clear the table that tells which slices came, and takes pictures of several slices for broken ones.
  if (const int code = avcodec_open2(context.get(), codec, nullptr); code < 0)
    return fail("video: the H.264 decoder does not open: {}", libav::errorText(code));
  return context;
}

}  // namespace

struct VideoDecoder::State {
  DecoderOptions options;
  libav::Owned<AVCodecContext> context;
  libav::Owned<AVFrame> frame;  // what was shown last
  libav::Owned<AVPacket> packet;
  std::optional<std::uint64_t> last;  // the newest frame that was decoded
  bool waiting = true;                // for an I-frame
  bool touched = false;               // the context has seen a packet
  NoPicture status = NoPicture::NoVideoYet;

  Decoded none(Decoded result, NoPicture reason, std::string detail) {
    result.reason = status = reason;
    result.detail = std::move(detail);
    result.wantsIFrame = waiting;
    return result;
  }
  /// As none(), and what comes next builds on what is not here.
  Decoded broken(Decoded result, NoPicture reason, std::string detail) {
    waiting = true;
    return none(std::move(result), reason, std::move(detail));
  }
  /// Another context in place of this one. A flush would not do: what a hostile stream claimed, such as how
  /// many pictures to hold back, outlives it.
  Result<void> renew() {
    auto fresh = open(options);
    if (!fresh) return tl::unexpected(fresh.error());
    context = std::move(*fresh);
    touched = false;
    return {};
  }
  Result<void> run(const StampedPacket& stamped);
  Decoded decode(std::span<const std::uint8_t> bytes);
};

/// One packet to one picture, in `frame`.
Result<void> VideoDecoder::State::run(const StampedPacket& stamped) {
  const auto bytes = stamped.packet;
  av_packet_unref(packet.get());
  av_frame_unref(frame.get());
  // With the padding that the decoder reads beyond the end.
  if (const int code = av_new_packet(packet.get(), static_cast<int>(bytes.size())); code < 0)
    return fail("no memory for {} bytes", bytes.size());
  std::copy(bytes.begin(), bytes.end(), packet->data);
  const auto number = static_cast<std::int64_t>(stamped.stamp.frame);
  packet->pts = packet->dts = number;
  int code = avcodec_send_packet(context.get(), packet.get());
  if (code < 0) return fail("{}", libav::errorText(code));
  code = avcodec_receive_frame(context.get(), frame.get());
  if (code == AVERROR(EAGAIN)) return fail("its packet holds no whole picture");
  if (code < 0) return fail("{}", libav::errorText(code));
  if (frame->pts != number) return fail("the picture that comes is of frame {}", frame->pts);
  if (frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0)
    return fail("it was decoded with errors (flags {:#x})", frame->decode_error_flags);
  return {};
}

Decoded VideoDecoder::State::decode(std::span<const std::uint8_t> bytes) {
  const auto start = std::chrono::steady_clock::now();
  Decoded result;
  const auto stamped = readStamp(bytes);
  if (!stamped) return broken(std::move(result), NoPicture::Damaged, stamped.error().message);
  const FrameStamp& stamp = stamped->stamp;
  result.frame = stamp.frame;
  result.iFrame = stamp.iFrame();
  if (last && stamp.frame <= *last)
    return none(std::move(result), NoPicture::Late,
                fmt::format("frame {}: comes after frame {}", stamp.frame, *last));
  if (!stamp.iFrame()) {
    if (waiting)
      return none(
          std::move(result), NoPicture::WaitingForIFrame,
          fmt::format("frame {}: builds on frame {}, which is not here", stamp.frame, stamp.reference));
    if (stamp.reference != *last)
      return broken(std::move(result), NoPicture::FrameLost,
                    fmt::format("frame {}: builds on frame {}; the last that came is {}", stamp.frame,
                                stamp.reference, *last));
  } else if (waiting && touched) {
    if (auto done = renew(); !done)
      return broken(std::move(result), NoPicture::DecodeFailed, done.error().message);
  }
  touched = true;
  if (auto done = run(*stamped); !done) {
    return broken(std::move(result), NoPicture::DecodeFailed,
                  fmt::format("frame {}: {}", stamp.frame, done.error().message));
  }
  auto planes = planesOf(*frame);
  if (!planes || frame->color_range != AVCOL_RANGE_JPEG || frame->colorspace != AVCOL_SPC_BT709) {
    const auto said = [](const char* name) { return name == nullptr ? "unknown" : name; };
    return broken(
        std::move(result), NoPicture::WrongColors,
        fmt::format("frame {}: pixels are {}, range {}, matrix {}; wanted are yuv420p or yuv444p, pc, bt709",
                    stamp.frame, said(av_get_pix_fmt_name(static_cast<AVPixelFormat>(frame->format))),
                    said(av_color_range_name(frame->color_range)),
                    said(av_color_space_name(frame->colorspace))));
  }
  waiting = false;
  last = stamp.frame;
  status = NoPicture::None;
  result.picture = *planes;
  result.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return result;
}

VideoDecoder::VideoDecoder(std::unique_ptr<State> state) : s_(std::move(state)) {}
VideoDecoder::VideoDecoder(VideoDecoder&& other) noexcept = default;
VideoDecoder& VideoDecoder::operator=(VideoDecoder&& other) noexcept = default;
VideoDecoder::~VideoDecoder() = default;

Result<VideoDecoder> VideoDecoder::create(const DecoderOptions& options) {
  if (options.threads < 1 || options.threads > 64)
    return fail("video: {} threads are outside [1, 64]", options.threads);
  if (options.maxPixels < 256 || options.maxPixels > kMaxImagePixels)
    return fail("video: {} pixels at most are outside [256, {}]", options.maxPixels, kMaxImagePixels);
  auto context = open(options);
  if (!context) return tl::unexpected(context.error());
  auto state = std::make_unique<State>();
  state->options = options;
  state->context = std::move(*context);
  state->frame.reset(av_frame_alloc());
  state->packet.reset(av_packet_alloc());
  if (!state->frame || !state->packet) return fail("video: no memory for a frame");
  return VideoDecoder(std::move(state));
}

Decoded VideoDecoder::decode(std::span<const std::uint8_t> packet) { return s_->decode(packet); }

void VideoDecoder::reset() {
  s_->last.reset();
  s_->waiting = true;
  s_->status = NoPicture::NoVideoYet;
}

NoPicture VideoDecoder::status() const { return s_->status; }

}  // namespace tessera
