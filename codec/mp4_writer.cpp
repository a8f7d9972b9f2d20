#include "codec/mp4_writer.hpp"

#include <cmath>
#include <cstring>

#include "codec/annexb.hpp"
#include "codec/libav.hpp"
#include "codec/stamp.hpp"

extern "C" {
#include <libavformat/avformat.h>
}

namespace tessera {

namespace {

constexpr int kClock = 90'000;  // ticks a second

struct FreeContext {
  void operator()(AVFormatContext* context) const { avformat_free_context(context); }
};

/// The sequence and picture parameter sets of a packet, in the byte stream format.
std::vector<std::uint8_t> parameterSets(std::span<const std::uint8_t> packet) {
  std::vector<std::uint8_t> sets;
  for (const Nal& nal : nalsOf(packet)) {
    if (nal.type() != NalType::SequenceSet && nal.type() != NalType::PictureSet) continue;
    sets.insert(sets.end(), {0, 0, 0, 1});
    sets.insert(sets.end(), nal.bytes.begin(), nal.bytes.end());
  }
  return sets;
}

}  // namespace

struct Mp4Writer::State {
  std::unique_ptr<AVFormatContext, FreeContext> context;
  AVStream* video = nullptr;
  double ticks = 0.0;  // of one picture
  std::int64_t count = 0;
  bool finished = false;

  ~State() {
    if (context == nullptr || context->pb == nullptr) return;
    std::uint8_t* bytes = nullptr;
    avio_close_dyn_buf(context->pb, &bytes);
    av_free(bytes);
    context->pb = nullptr;
  }

  Result<void> begin(std::span<const std::uint8_t> packet) {
    const std::vector<std::uint8_t> sets = parameterSets(packet);
    if (sets.empty()) return fail("MP4: the first picture brings no parameter sets");
    auto* extra = static_cast<std::uint8_t*>(av_mallocz(sets.size() + AV_INPUT_BUFFER_PADDING_SIZE));
    if (extra == nullptr) return fail("MP4: no memory");
    std::memcpy(extra, sets.data(), sets.size());
    video->codecpar->extradata = extra;
    video->codecpar->extradata_size = static_cast<int>(sets.size());
    if (const int error = avformat_write_header(context.get(), nullptr); error < 0)
      return fail("MP4: {}", libav::errorText(error));
    return {};
  }
};

Result<Mp4Writer> Mp4Writer::create(int width, int height, double framesPerSecond) {
  auto state = std::make_unique<State>();
  AVFormatContext* context = nullptr;
  if (const int error = avformat_alloc_output_context2(&context, nullptr, "mp4", nullptr); error < 0)
    return fail("MP4: {}", libav::errorText(error));
  state->context.reset(context);
  state->video = avformat_new_stream(context, nullptr);
  if (state->video == nullptr || avio_open_dyn_buf(&context->pb) < 0) return fail("MP4: no memory");
  state->ticks = kClock / framesPerSecond;
  state->video->time_base = {1, kClock};
  AVCodecParameters& coding = *state->video->codecpar;
  coding.codec_type = AVMEDIA_TYPE_VIDEO;
  coding.codec_id = AV_CODEC_ID_H264;
  coding.width = width;
  coding.height = height;
  coding.format = AV_PIX_FMT_YUV420P;
  return Mp4Writer(std::move(state));
}

Mp4Writer::Mp4Writer(std::unique_ptr<State> state) : s_(std::move(state)) {}
Mp4Writer::Mp4Writer(Mp4Writer&&) noexcept = default;
Mp4Writer& Mp4Writer::operator=(Mp4Writer&&) noexcept = default;
Mp4Writer::~Mp4Writer() = default;

Result<void> Mp4Writer::add(const EncodedFrame& frame) {
  auto stamped = readStamp(frame.bytes);
  if (!stamped) return fail("MP4: {}", stamped.error().message);
  if (s_->count == 0) {
    if (!frame.iFrame()) return fail("MP4: the first picture is no I-frame");
    if (auto begun = s_->begin(stamped->packet); !begun) return begun;
  }
  const libav::Owned<AVPacket> packet(av_packet_alloc());
  if (packet == nullptr || av_new_packet(packet.get(), static_cast<int>(stamped->packet.size())) < 0)
    return fail("MP4: no memory");
  std::memcpy(packet->data, stamped->packet.data(), stamped->packet.size());
  packet->pts = packet->dts = std::llround(static_cast<double>(s_->count) * s_->ticks);
  packet->duration = std::llround(s_->ticks);
  packet->stream_index = s_->video->index;
  if (frame.iFrame()) packet->flags |= AV_PKT_FLAG_KEY;
  av_packet_rescale_ts(packet.get(), {1, kClock}, s_->video->time_base);
  if (const int error = av_write_frame(s_->context.get(), packet.get()); error < 0)
    return fail("MP4: picture {}: {}", s_->count, libav::errorText(error));
  ++s_->count;
  return {};
}

Result<std::vector<std::uint8_t>> Mp4Writer::finish() {
  if (s_->count == 0 || s_->finished) return fail("MP4: there is no picture to write");
  s_->finished = true;
  if (const int error = av_write_trailer(s_->context.get()); error < 0)
    return fail("MP4: {}", libav::errorText(error));
  std::uint8_t* bytes = nullptr;
  const int size = avio_close_dyn_buf(s_->context->pb, &bytes);
  s_->context->pb = nullptr;
  std::vector<std::uint8_t> file(bytes, bytes + size);
  av_free(bytes);
  return file;
}

}  // namespace tessera
