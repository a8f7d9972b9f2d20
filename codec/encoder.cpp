#include "codec/encoder.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include "codec/annexb.hpp"
#include "codec/encoder_settings.hpp"
#include "codec/frame_planes.hpp"
#include "codec/libav.hpp"
#include "codec/stamp.hpp"

extern "C" {
#include <libavutil/hwcontext.h>
}

namespace tessera {

namespace {

constexpr int kQuantizers = 51;            // what libavcodec measures a region's offset in, of 8-bit H.264
constexpr double kStepsPerDoubling = 3.0;  // of squared error: its square root doubles with six
constexpr double kMostImportance = 64.0;
constexpr int kLongestInterval = 1'000'000;  // frames
constexpr const char* kRenderNode = "/dev/dri/renderD128";

Result<void> checkOptions(const EncoderOptions& options) {
  for (const auto& [name, value] : {std::pair{"width", options.width}, std::pair{"height", options.height}}) {
    if (value < 16 || value > kMaxImageSide)
      return fail("video: {} {} is outside [16, {}]", name, value, kMaxImageSide);
    if (options.chroma == Chroma::Yuv420 && value % 2 != 0)
      return fail("video: {} {} is odd: 4:2:0 has a chroma value for two texels", name, value);
  }
  if (!(options.framesPerSecond > 0.0 && options.framesPerSecond <= 1000.0))
    return fail("video: {} frames a second are outside (0, 1000]", options.framesPerSecond);
  if (options.rate == RateControl::Bitrate) {
    if (options.bitrate < 10'000 || options.bitrate > 2'000'000'000)
      return fail("video: bitrate {} is outside [10000, 2000000000] bits a second", options.bitrate);
    if (!(options.bufferSeconds > 0.0 && options.bufferSeconds <= 10.0))
      return fail("video: a buffer of {} s is outside (0, 10]", options.bufferSeconds);
  } else if (!(options.quality >= 0.0 && options.quality <= kQuantizers)) {
    return fail("video: quality {} is outside [0, {}]", options.quality, kQuantizers);
  }
  if (options.iFrameInterval < 0 || options.iFrameInterval > kLongestInterval)
    return fail("video: an I-frame every {} frames is outside [0, {}]", options.iFrameInterval,
                kLongestInterval);
  if (options.threads < 0 || options.threads > 64)
    return fail("video: {} threads are outside [0, 64]", options.threads);
  return {};
}

void describe(AVCodecContext& context, const EncoderOptions& options, AVPixelFormat format) {
  context.log_level_offset = libav::kSilent;
  context.width = options.width;
  context.height = options.height;
  context.pix_fmt = format;
  context.framerate = av_d2q(options.framesPerSecond, 1'000'000);
  context.time_base = av_inv_q(context.framerate);
  context.refs = 1;
  context.max_b_frames = 0;
  context.flags |= AV_CODEC_FLAG_LOW_DELAY;
  // I-frames are asked for one by one: every encoder counts its interval in another way.
  context.gop_size = std::numeric_limits<int>::max() / 2;
  context.thread_count = options.threads;
  context.color_range = AVCOL_RANGE_JPEG;
  context.colorspace = AVCOL_SPC_BT709;
  context.color_primaries = AVCOL_PRI_BT709;
  context.color_trc = AVCOL_TRC_IEC61966_2_1;
  if (options.chroma == Chroma::Yuv420) context.chroma_sample_location = AVCHROMA_LOC_CENTER;
  if (options.rate == RateControl::Bitrate) {
    context.bit_rate = options.bitrate;
    context.rc_max_rate = options.bitrate;
    context.rc_buffer_size = static_cast<int>(std::min<double>(
        static_cast<double>(options.bitrate) * options.bufferSeconds, std::numeric_limits<int>::max()));
  }
}

/// Frames on a VA-API device; those in memory are copied there.
Result<void> openDevice(AVCodecContext& context) {
  // Without one, libva says so on stderr by itself.
  if (!std::filesystem::exists(kRenderNode)) return fail("there is no {}", kRenderNode);
  AVBufferRef* made = nullptr;
  if (const int code = av_hwdevice_ctx_create(&made, AV_HWDEVICE_TYPE_VAAPI, kRenderNode, nullptr, 0);
      code < 0)
    return fail("{}: {}", kRenderNode, libav::errorText(code));
  const libav::Owned<AVBufferRef> device(made);
  libav::Owned<AVBufferRef> frames(av_hwframe_ctx_alloc(device.get()));
  if (!frames) return fail("no memory for frames on {}", kRenderNode);
  auto& description = *reinterpret_cast<AVHWFramesContext*>(frames->data);
  description.format = AV_PIX_FMT_VAAPI;
  description.sw_format = AV_PIX_FMT_NV12;
  description.width = context.width;
  description.height = context.height;
  description.initial_pool_size = 4;
  if (const int code = av_hwframe_ctx_init(frames.get()); code < 0)
    return fail("frames of {} x {} on {}: {}", context.width, context.height, kRenderNode,
                libav::errorText(code));
  context.hw_frames_ctx = frames.release();
  return {};
}

Result<libav::Owned<AVCodecContext>> open(const std::string& name, const EncoderOptions& options) {
  const AVCodec* codec = avcodec_find_encoder_by_name(name.c_str());
  if (codec == nullptr) return fail("this libavcodec has no such encoder");
  if (codec->id != AV_CODEC_ID_H264) return fail("it encodes {}, not H.264", avcodec_get_name(codec->id));
  const AVPixelFormat format = formatFor(*codec, options.chroma);
  if (format == AV_PIX_FMT_NONE) return fail("it takes no {}", nameOf(options.chroma));
  libav::Owned<AVCodecContext> context(avcodec_alloc_context3(codec));
  if (!context) return fail("no memory for it");
  describe(*context, options, format);
  if (format == AV_PIX_FMT_VAAPI)
    if (auto device = openDevice(*context); !device) return tl::unexpected(device.error());

  AVDictionary* settings = nullptr;
  for (const auto& [key, value] : settingsOf(name, options))
    av_dict_set(&settings, key.c_str(), value.c_str(), 0);
  const int code = avcodec_open2(context.get(), codec, &settings);
  const AVDictionaryEntry* left = av_dict_get(settings, "", nullptr, AV_DICT_IGNORE_SUFFIX);
  const std::string unknown = left == nullptr ? "" : left->key;
  av_dict_free(&settings);
  if (code < 0) return fail("it does not open: {}", libav::errorText(code));
  if (!unknown.empty()) return fail("it has no option '{}'", unknown);
  return context;
}

Result<void> checkRegion(const Region& region, const EncoderOptions& options, std::size_t index) {
  const auto outside = [](int start, int length, int limit) {
    return start < 0 || length < 1 || start > limit || length > limit - start;
  };
  if (outside(region.x, region.width, options.width) || outside(region.y, region.height, options.height))
    return fail("region {}: {} x {} texels at ({}, {}) are not within {} x {}", index, region.width,
                region.height, region.x, region.y, options.width, options.height);
  if (!(region.importance >= 1.0 / kMostImportance && region.importance <= kMostImportance))
    return fail("region {}: importance {} is outside [1/64, 64]", index, region.importance);
  return {};
}

Result<void> attach(AVFrame& frame, std::span<const Region> regions) {
  AVFrameSideData* side = av_frame_new_side_data(&frame, AV_FRAME_DATA_REGIONS_OF_INTEREST,
                                                 regions.size() * sizeof(AVRegionOfInterest));
  if (side == nullptr) return fail("no memory for {} regions", regions.size());
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const Region& region = regions[i];
    const double steps = -kStepsPerDoubling * std::log2(region.importance);
    const AVRegionOfInterest one{
        .self_size = sizeof(AVRegionOfInterest),
        .top = region.y,
        .bottom = region.y + region.height,
        .left = region.x,
        .right = region.x + region.width,
        .qoffset = av_make_q(static_cast<int>(std::lround(steps * 1000.0)), kQuantizers * 1000)};
    std::memcpy(side->data + i * sizeof(one), &one, sizeof(one));
  }
  return {};
}

bool holdsIdr(std::span<const std::uint8_t> packet) {
  const auto nals = nalsOf(packet);
  return std::any_of(nals.begin(), nals.end(),
                     [](const Nal& nal) { return nal.type() == NalType::IdrSlice; });
}

}  // namespace

const std::vector<std::string>& defaultEncoders() {
  static const std::vector<std::string> names = {"h264_nvenc", "h264_vaapi", "h264_qsv", "libx264"};
  return names;
}

struct VideoEncoder::State {
  EncoderOptions options;
  std::string name;
  libav::Owned<AVCodecContext> context;
  libav::Owned<AVFrame> frame;     // in memory
  libav::Owned<AVFrame> onDevice;  // null where the encoder takes frames in memory
  libav::Owned<AVPacket> packet;
  std::int64_t count = 0;             // frames given to the encoder
  std::optional<std::uint64_t> last;  // number of the last frame that came out
  int sinceIFrame = 0;                // frames, that one included; 0: the next must be one

  Result<void> allocate() {
    frame.reset(av_frame_alloc());
    packet.reset(av_packet_alloc());
    if (!frame || !packet) return fail("{}: no memory for a frame", name);
    const bool device = context->pix_fmt == AV_PIX_FMT_VAAPI;
    frame->format = device ? AV_PIX_FMT_NV12 : context->pix_fmt;
    frame->width = options.width;
    frame->height = options.height;
    if (const int code = av_frame_get_buffer(frame.get(), 0); code < 0)
      return fail("{}: a frame of {} x {}: {}", name, options.width, options.height, libav::errorText(code));
    if (!device) return {};
    onDevice.reset(av_frame_alloc());
    if (!onDevice) return fail("{}: no memory for a frame", name);
    return {};
  }

  /// The frame that the encoder is given, with the planes in it.
  Result<AVFrame*> fill(const YuvView& planes) {
    // The encoder may still hold what it was given last.
    if (const int code = av_frame_make_writable(frame.get()); code < 0)
      return fail("{}: no memory for a frame: {}", name, libav::errorText(code));
    av_frame_remove_side_data(frame.get(), AV_FRAME_DATA_REGIONS_OF_INTEREST);
    copyPlanes(planes, *frame);
    if (!onDevice) return frame.get();
    av_frame_unref(onDevice.get());
    int code = av_hwframe_get_buffer(context->hw_frames_ctx, onDevice.get(), 0);
    if (code >= 0) code = av_hwframe_transfer_data(onDevice.get(), frame.get(), 0);
    if (code < 0) return fail("{}: a frame does not go to the device: {}", name, libav::errorText(code));
    return onDevice.get();
  }

  Result<EncodedFrame> encode(const YuvView& planes, std::uint64_t number, const EncodeOptions& asked);
};

Result<EncodedFrame> VideoEncoder::State::encode(const YuvView& planes, std::uint64_t number,
                                                 const EncodeOptions& asked) {
  const auto start = std::chrono::steady_clock::now();
  const bool due = sinceIFrame == 0 || (options.iFrameInterval > 0 && sinceIFrame >= options.iFrameInterval);
  const bool iFrame = asked.iFrame || due;
  const int since = std::exchange(sinceIFrame, 0);  // an I-frame is next, unless a packet comes out
  auto filled = fill(planes);
  if (!filled) return tl::unexpected(filled.error());
  AVFrame& in = **filled;
  in.pts = count++;
  in.pict_type = iFrame ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
  in.color_range = context->color_range;
  in.colorspace = context->colorspace;
  if (!asked.regions.empty() && encoderTakesRegions(name))
    if (auto done = attach(in, asked.regions); !done) return tl::unexpected(done.error());

  int code = avcodec_send_frame(context.get(), &in);
  if (code < 0) return fail("{}: frame {}: {}", name, number, libav::errorText(code));
  code = avcodec_receive_packet(context.get(), packet.get());
  if (code < 0)
    return fail("{}: frame {} does not come out at once: {}", name, number, libav::errorText(code));
  if (packet->pts != in.pts)
    return fail("{}: frame {} does not come out at once: what came is {} frames older", name, number,
                in.pts - packet->pts);
  const std::span<const std::uint8_t> bytes(packet->data, static_cast<std::size_t>(packet->size));
  EncodedFrame out{.frame = number, .reference = number, .bytes = {}, .milliseconds = 0.0};
  const bool idr = holdsIdr(bytes);
  if (iFrame && !idr) return fail("{}: frame {} was to be an I-frame, and is none", name, number);
  if (!idr) out.reference = *last;
  out.bytes = stamped({.frame = number, .reference = out.reference}, withLongStartCodes(bytes));
  av_packet_unref(packet.get());
  last = number;
  sinceIFrame = idr ? 1 : std::min(since + 1, kLongestInterval);
  out.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return out;
}

VideoEncoder::VideoEncoder(std::unique_ptr<State> state) : s_(std::move(state)) {}
VideoEncoder::VideoEncoder(VideoEncoder&& other) noexcept = default;
VideoEncoder& VideoEncoder::operator=(VideoEncoder&& other) noexcept = default;
VideoEncoder::~VideoEncoder() = default;

Result<VideoEncoder> VideoEncoder::create(const EncoderOptions& options) {
  if (auto good = checkOptions(options); !good) return tl::unexpected(good.error());
  const std::vector<std::string>& names = options.encoders.empty() ? defaultEncoders() : options.encoders;
  std::string tried;
  for (const std::string& name : names) {
    auto context = open(name, options);
    if (!context) {
      tried += fmt::format("{}{}: {}", tried.empty() ? "" : "; ", name, context.error().message);
      continue;
    }
    auto state = std::make_unique<State>();
    state->options = options;
    state->name = name;
    state->context = std::move(*context);
    if (auto done = state->allocate(); !done) return tl::unexpected(done.error());
    return VideoEncoder(std::move(state));
  }
  return fail("video of {} x {}, {}: no encoder opens: {}", options.width, options.height,
              nameOf(options.chroma), tried);
}

Result<EncodedFrame> VideoEncoder::encode(const YuvView& planes, std::uint64_t frame,
                                          const EncodeOptions& options) {
  const EncoderOptions& made = s_->options;
  if (planes.width != made.width || planes.height != made.height || planes.chroma != made.chroma)
    return fail("frame {}: planes of {} x {}, {}, for video of {} x {}, {}", frame, planes.width,
                planes.height, nameOf(planes.chroma), made.width, made.height, nameOf(made.chroma));
  if (auto good = checkPlanes(planes); !good) return fail("frame {}: {}", frame, good.error().message);
  if (s_->last && frame <= *s_->last)
    return fail("frame {}: comes after frame {}: numbers must rise", frame, *s_->last);
  for (std::size_t i = 0; i < options.regions.size(); ++i)
    if (auto good = checkRegion(options.regions[i], made, i); !good)
      return fail("frame {}: {}", frame, good.error().message);
  return s_->encode(planes, frame, options);
}

const std::string& VideoEncoder::name() const { return s_->name; }
bool VideoEncoder::takesRegions() const { return encoderTakesRegions(s_->name); }

}  // namespace tessera
