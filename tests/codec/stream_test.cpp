// What the stream itself says, as libavcodec's reader of headers prints it (the trace_headers filter shares
// no code with what encodes), and streams that say something else.
#include <cstdarg>
#include <cstdio>
#include <regex>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "codec/annexb.hpp"
#include "codec/libav.hpp"
#include "tests/codec/moving_picture.hpp"

extern "C" {
#include <libavcodec/bsf.h>
#include <libavutil/log.h>
}

namespace tessera {
namespace {

std::string traced;
void keep(void* /*context*/, int level, const char* format, va_list arguments) {
  if (level > AV_LOG_INFO) return;
  char line[1024];
  std::vsnprintf(line, sizeof(line), format, arguments);
  traced += line;
}

/// Prints the headers of a stream's packets, in order.
class Headers {
 public:
  Headers() {
    EXPECT_GE(av_bsf_alloc(av_bsf_get_by_name("trace_headers"), &filter_), 0);
    filter_->par_in->codec_id = AV_CODEC_ID_H264;
    filter_->par_in->codec_type = AVMEDIA_TYPE_VIDEO;
    EXPECT_GE(av_bsf_init(filter_), 0);
  }
  ~Headers() { av_bsf_free(&filter_); }
  Headers(const Headers&) = delete;
  Headers& operator=(const Headers&) = delete;

  /// All of a packet, a field a line.
  std::string of(std::span<const std::uint8_t> bytes) {
    traced.clear();
    av_log_set_callback(keep);
    libav::Owned<AVPacket> packet(av_packet_alloc());
    EXPECT_GE(av_new_packet(packet.get(), static_cast<int>(bytes.size())), 0);
    std::copy(bytes.begin(), bytes.end(), packet->data);
    EXPECT_GE(av_bsf_send_packet(filter_, packet.get()), 0);
    EXPECT_GE(av_bsf_receive_packet(filter_, packet.get()), 0);
    av_log_set_callback(av_log_default_callback);
    return traced;
  }

 private:
  AVBSFContext* filter_ = nullptr;
};

/// All values that a field has in these headers.
std::set<int> valuesOf(const std::string& headers, const std::string& field) {
  std::set<int> values;
  const std::regex line("\\b" + field + "\\s+[01]+ = (-?[0-9]+)");
  for (std::sregex_iterator i(headers.begin(), headers.end(), line), end; i != end; ++i)
    values.insert(std::stoi((*i)[1]));
  return values;
}

using Values = std::set<int>;

TEST(VideoStream, SaysWhatTheHouseAsksFor) {
  for (const Chroma chroma : {Chroma::Yuv420, Chroma::Yuv444})
    for (const RateControl rate : {RateControl::Bitrate, RateControl::ConstantQuality}) {
      EncoderOptions options;
      options.width = 100;
      options.height = 60;
      options.chroma = chroma;
      options.rate = rate;
      options.iFrameInterval = 3;
      options.threads = 2;
      options.encoders = {"libx264"};
      auto encoder = VideoEncoder::create(options);
      ASSERT_TRUE(encoder) << encoder.error().message;
      const auto stream = test::encodeMoving(*encoder, options, 7);
      ASSERT_EQ(stream.size(), 7u);
      Headers reader;
      for (std::size_t i = 0; i < stream.size(); ++i) {
        const std::string headers = reader.of(stream[i].bytes);
        const bool iFrame = i % 3 == 0;
        // Each I-frame stands alone: parameter sets, and slices that take nothing from before.
        EXPECT_EQ(valuesOf(headers, "nal_unit_type"), iFrame ? (Values{5, 6, 7, 8}) : (Values{1, 6})) << i;
        for (const int type : valuesOf(headers, "slice_type"))
          EXPECT_EQ(type % 5, iFrame ? 2 : 0) << "I is 2, P is 0";
        if (!iFrame) {
          // P-frames look one frame back.
          for (const int active : valuesOf(headers, "num_ref_idx_l0_active_minus1")) EXPECT_EQ(active, 0);
          continue;
        }
        EXPECT_EQ(valuesOf(headers, "entropy_coding_mode_flag"), Values{0}) << "CAVLC";
        EXPECT_EQ(valuesOf(headers, "max_num_ref_frames"), Values{1});
        EXPECT_EQ(valuesOf(headers, "max_num_reorder_frames"), Values{0}) << "nothing is held back";
        EXPECT_EQ(valuesOf(headers, "video_full_range_flag"), Values{1});
        EXPECT_EQ(valuesOf(headers, "matrix_coefficients"), Values{1}) << "BT.709";
        EXPECT_EQ(valuesOf(headers, "colour_primaries"), Values{1});
        EXPECT_EQ(valuesOf(headers, "transfer_characteristics"), Values{13}) << "sRGB";
        EXPECT_EQ(valuesOf(headers, "chroma_format_idc"), chroma == Chroma::Yuv444 ? Values{3} : Values{1});
        if (chroma == Chroma::Yuv420) {
          EXPECT_EQ(valuesOf(headers, "chroma_sample_loc_type_top_field"), Values{1})
              << "at squares' centres";
        }
        EXPECT_EQ(valuesOf(headers, "pic_width_in_mbs_minus1"), Values{6});
        EXPECT_EQ(valuesOf(headers, "frame_cropping_flag"), Values{1});
        EXPECT_EQ(valuesOf(headers, "frame_crop_right_offset"),
                  chroma == Chroma::Yuv444 ? Values{12} : Values{6});
      }
    }
}

/// A stream that some other encoder made, with colours that it says are so.
std::vector<std::uint8_t> foreign(AVColorRange range, AVColorSpace matrix,
                                  AVPixelFormat format = AV_PIX_FMT_YUV420P) {
  const AVCodec* codec = avcodec_find_encoder_by_name("libx264");
  libav::Owned<AVCodecContext> context(avcodec_alloc_context3(codec));
  context->log_level_offset = libav::kSilent;
  context->width = 64;
  context->height = 48;
  context->pix_fmt = format;
  context->time_base = {1, 30};
  context->color_range = range;
  context->colorspace = matrix;
  AVDictionary* settings = nullptr;
  av_dict_set(&settings, "tune", "zerolatency", 0);
  EXPECT_GE(avcodec_open2(context.get(), codec, &settings), 0);
  av_dict_free(&settings);
  libav::Owned<AVFrame> frame(av_frame_alloc());
  frame->format = format;
  frame->width = 64;
  frame->height = 48;
  EXPECT_GE(av_frame_get_buffer(frame.get(), 0), 0);
  for (int i = 0; i < 3; ++i)
    if (frame->buf[i] != nullptr) std::fill_n(frame->buf[i]->data, frame->buf[i]->size, std::uint8_t{100});
  libav::Owned<AVPacket> packet(av_packet_alloc());
  EXPECT_GE(avcodec_send_frame(context.get(), frame.get()), 0);
  EXPECT_GE(avcodec_receive_packet(context.get(), packet.get()), 0);
  return stamped({5, 5}, {packet->data, static_cast<std::size_t>(packet->size)});
}

TEST(VideoStream, OtherColoursAreRefusedByName) {
  const auto decode = [](const std::vector<std::uint8_t>& packet, std::string& detail) {
    auto decoder = VideoDecoder::create();
    if (!decoder) return NoPicture::NoVideoYet;
    const Decoded decoded = decoder->decode(packet);
    detail = decoded.detail;
    EXPECT_EQ(decoded.picture.has_value(), decoded.reason == NoPicture::None);
    EXPECT_EQ(decoded.wantsIFrame, decoded.reason != NoPicture::None);
    return decoded.reason;
  };
  std::string detail;
  EXPECT_EQ(decode(foreign(AVCOL_RANGE_JPEG, AVCOL_SPC_BT709), detail), NoPicture::None) << detail;
  EXPECT_EQ(decode(foreign(AVCOL_RANGE_MPEG, AVCOL_SPC_BT709), detail), NoPicture::WrongColors);
  EXPECT_NE(detail.find("range tv"), std::string::npos) << detail;
  EXPECT_EQ(decode(foreign(AVCOL_RANGE_JPEG, AVCOL_SPC_SMPTE170M), detail), NoPicture::WrongColors);
  EXPECT_NE(detail.find("matrix smpte170m"), std::string::npos) << detail;
  EXPECT_EQ(decode(foreign(AVCOL_RANGE_UNSPECIFIED, AVCOL_SPC_UNSPECIFIED), detail), NoPicture::WrongColors);
  EXPECT_EQ(decode(foreign(AVCOL_RANGE_JPEG, AVCOL_SPC_BT709, AV_PIX_FMT_YUV422P), detail),
            NoPicture::WrongColors);
  EXPECT_NE(detail.find("yuvj422p"), std::string::npos) << detail;
}

}  // namespace
}  // namespace tessera
