#include "codec/transport/rtp_send.hpp"

#include <algorithm>

extern "C" {
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

namespace tessera::transport {

namespace {

struct FreeFormat {
  void operator()(AVFormatContext* context) const { avformat_free_context(context); }
};
struct FreeIo {
  void operator()(AVIOContext* io) const {
    av_freep(&io->buffer);
    avio_context_free(&io);
  }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};

std::string text(int error) {
  char buffer[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, buffer, sizeof(buffer));
  return buffer;
}

bool beginsWithStartCode(std::span<const std::uint8_t> unit) {
  const auto zeroThen = [&](std::size_t zeroes) {
    if (unit.size() <= zeroes + 1) return false;
    for (std::size_t i = 0; i < zeroes; ++i)
      if (unit[i] != 0) return false;
    return unit[zeroes] == 1;
  };
  return zeroThen(2) || zeroThen(3);
}

}  // namespace

struct RtpPacketiser::State {
  std::unique_ptr<AVIOContext, FreeIo> io;
  std::unique_ptr<AVFormatContext, FreeFormat> format;
  std::unique_ptr<AVPacket, FreePacket> packet;
  std::vector<Datagram> made;
  std::int64_t sent = 0;  // access units
  bool begun = false;     // the header is written, and the muxer holds what only its trailer frees

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    if (begun) av_write_trailer(format.get());
  }

  /// The muxer flushes its buffer after each packet, so one call is one packet.
  static int take(void* opaque, std::uint8_t* bytes, int size) {
    static_cast<State*>(opaque)->made.emplace_back(bytes, bytes + size);
    return size;
  }
};

RtpPacketiser::RtpPacketiser(std::unique_ptr<State> state) : state_(std::move(state)) {}
RtpPacketiser::RtpPacketiser(RtpPacketiser&&) noexcept = default;
RtpPacketiser& RtpPacketiser::operator=(RtpPacketiser&&) noexcept = default;
RtpPacketiser::~RtpPacketiser() = default;

Result<RtpPacketiser> RtpPacketiser::make(const RtpStream& stream) {
  if (stream.packetBytes < 128 || stream.packetBytes > 65000)
    return fail("RTP packets of {} bytes: expected 128 to 65000", stream.packetBytes);
  if (stream.source == 0 || stream.firstSequence >= 0x8000)
    return fail(
        "RTP stream with source {} and first sequence number {}: expected one above 0, one below 32768",
        stream.source, stream.firstSequence);
  const AVOutputFormat* rtp = av_guess_format("rtp", nullptr, nullptr);
  if (rtp == nullptr) return fail("libavformat has no RTP muxer");

  auto state = std::make_unique<State>();
  const int packetBytes = static_cast<int>(stream.packetBytes - kRtpExtensionBytes);
  constexpr int kBufferBytes = 1 << 16;
  auto* buffer = static_cast<unsigned char*>(av_malloc(kBufferBytes));
  if (buffer == nullptr) return fail("RTP muxer: out of memory");
  state->io.reset(avio_alloc_context(buffer, kBufferBytes, 1, state.get(), nullptr,
                                     &RtpPacketiser::State::take, nullptr));
  state->io->max_packet_size = packetBytes;
  AVFormatContext* context = nullptr;
  if (const int error = avformat_alloc_output_context2(&context, rtp, nullptr, nullptr); error < 0)
    return fail("RTP muxer: {}", text(error));
  state->format.reset(context);
  context->pb = state->io.get();
  context->flags |= AVFMT_FLAG_CUSTOM_IO;
  context->packet_size = static_cast<unsigned>(packetBytes);
  // Each access unit leaves the muxer as it comes.
  context->max_delay = 0;

  AVStream* video = avformat_new_stream(context, nullptr);
  if (video == nullptr) return fail("RTP muxer: out of memory");
  video->codecpar->codec_type = AVMEDIA_TYPE_VIDEO;
  video->codecpar->codec_id = AV_CODEC_ID_H264;
  // Asked for, and of no use to RTP.
  video->codecpar->width = video->codecpar->height = 16;
  video->time_base = {1, static_cast<int>(kRtpClock)};

  AVDictionary* options = nullptr;
  av_dict_set(&options, "rtpflags", "skip_rtcp", 0);
  av_dict_set_int(&options, "payload_type", kRtpPayloadType, 0);
  // The option is a signed int; its bits are the number.
  av_dict_set_int(&options, "ssrc", static_cast<std::int32_t>(stream.source), 0);
  av_dict_set_int(&options, "seq", stream.firstSequence, 0);
  const int error = avformat_write_header(context, &options);
  av_dict_free(&options);
  if (error < 0) return fail("RTP muxer: {}", text(error));
  state->begun = true;
  state->made.clear();
  state->packet.reset(av_packet_alloc());
  if (state->packet == nullptr) return fail("RTP muxer: out of memory");
  return RtpPacketiser(std::move(state));
}

Result<std::vector<Datagram>> RtpPacketiser::packetise(std::span<const std::uint8_t> accessUnit,
                                                       std::uint32_t frame, std::uint32_t timestamp) {
  if (!beginsWithStartCode(accessUnit))
    return fail("frame {}: its {} bytes do not begin with a start code", frame, accessUnit.size());
  state_->made.clear();
  // The muxer searches for start codes a few bytes past the end: av_new_packet pads with zeroes.
  if (const int error = av_new_packet(state_->packet.get(), static_cast<int>(accessUnit.size())); error < 0)
    return fail("frame {}: RTP muxer: {}", frame, text(error));
  std::copy(accessUnit.begin(), accessUnit.end(), state_->packet->data);
  // Time stamps have to rise for the muxer and may wrap for RTP: it gets a count, and ours are written over
  // its.
  state_->packet->pts = state_->packet->dts = state_->sent++;
  const int error = av_write_frame(state_->format.get(), state_->packet.get());
  av_packet_unref(state_->packet.get());
  if (error < 0) return fail("frame {}: RTP muxer: {}", frame, text(error));
  avio_flush(state_->io.get());

  const std::size_t count = state_->made.size();
  if (count == 0 || count > 0xffff)
    return fail("frame {}: {} RTP packets, expected 1 to 65535", frame, count);
  std::vector<Datagram> packets;
  packets.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    auto packet = withPlace(state_->made[i],
                            {frame, static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(count), 0});
    if (!packet) return fail("frame {}: {}", frame, packet.error().message);
    for (int byte = 0; byte < 4; ++byte)
      (*packet)[4 + static_cast<std::size_t>(byte)] = static_cast<std::uint8_t>(timestamp >> (24 - 8 * byte));
    packets.push_back(std::move(*packet));
  }
  state_->made.clear();
  return packets;
}

}  // namespace tessera::transport
