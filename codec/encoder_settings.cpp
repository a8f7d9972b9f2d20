#include "codec/encoder_settings.hpp"

#include <cmath>
#include <initializer_list>

#include <fmt/format.h>

namespace tessera {

std::vector<std::pair<std::string, std::string>> settingsOf(const std::string& encoder,
                                                            const EncoderOptions& options) {
  const bool constant = options.rate == RateControl::ConstantQuality;
  const std::string quantizer = fmt::format("{}", std::lround(options.quality));
  std::vector<std::pair<std::string, std::string>> settings;
  const auto preset = [&](const char* usual) {
    settings.emplace_back("preset", options.preset.empty() ? usual : options.preset);
  };
  if (encoder == "libx264") {
    preset("superfast");
    // Of "zerolatency": no lookahead, no B-frames, slices in parallel instead of frames.
    settings.insert(settings.end(), {{"tune", "zerolatency"}, {"coder", "cavlc"}, {"forced-idr", "1"}});
    // An atlas is not a film: next to a block lies another surface, so that filtering over macroblocks' edges
    // mixes what is unrelated (without it 0.3 dB better at 10 Mbit/s, the same at 40, and decoding takes half
    // as long), and what varies little may be large in the picture (without adaptive quantization 0.9 dB
    // better in atlas and picture; regions need it on, so its strength is next to nothing).
    settings.insert(settings.end(),
                    {{"aq-mode", "1"}, {"aq-strength", "0.01"}, {"x264-params", "no-deblock=1"}});
    // I-frames come where they are asked for, not where pictures change.
    settings.emplace_back("sc_threshold", "0");
    if (constant) settings.emplace_back("crf", fmt::format("{}", options.quality));
  } else if (encoder == "h264_nvenc") {
    preset("p4");
    settings.insert(settings.end(), {{"tune", "ull"},
                                     {"coder", "cavlc"},
                                     {"forced-idr", "1"},
                                     {"zerolatency", "1"},
                                     {"delay", "0"},
                                     {"rc-lookahead", "0"},
                                     {"no-scenecut", "1"}});
    settings.emplace_back("rc", constant ? "constqp" : "cbr");
    if (constant) settings.emplace_back("qp", quantizer);
  } else if (encoder == "h264_vaapi") {
    settings.insert(settings.end(), {{"coder", "cavlc"}, {"idr_interval", "0"}, {"async_depth", "1"}});
    settings.emplace_back("rc_mode", constant ? "CQP" : "CBR");
    if (constant) settings.emplace_back("qp", quantizer);
  } else if (encoder == "h264_qsv") {
    preset("veryfast");
    settings.insert(settings.end(),
                    {{"cavlc", "1"}, {"forced_idr", "1"}, {"async_depth", "1"}, {"look_ahead", "0"}});
    if (constant)
      settings.emplace_back("global_quality", fmt::format("{}", std::lround(options.quality) * FF_QP2LAMBDA));
  }
  return settings;
}

bool encoderTakesRegions(const std::string& encoder) {
  return encoder == "libx264" || encoder == "h264_vaapi";
}

AVPixelFormat formatFor(const AVCodec& codec, Chroma chroma) {
  const auto takes = [&](AVPixelFormat format) {
    for (const AVPixelFormat* one = codec.pix_fmts; one != nullptr && *one != AV_PIX_FMT_NONE; ++one)
      if (*one == format) return true;
    return false;
  };
  if (chroma == Chroma::Yuv444) return takes(AV_PIX_FMT_YUV444P) ? AV_PIX_FMT_YUV444P : AV_PIX_FMT_NONE;
  for (const AVPixelFormat format : {AV_PIX_FMT_YUV420P, AV_PIX_FMT_NV12, AV_PIX_FMT_VAAPI})
    if (takes(format)) return format;
  return AV_PIX_FMT_NONE;
}

}  // namespace tessera
