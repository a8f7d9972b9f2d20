// libavcodec's objects as values that are freed once. For codec/*.cpp only: the public headers name none of
// it.
#pragma once

#include <memory>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/buffer.h>
#include <libavutil/dict.h>
#include <libavutil/frame.h>
}

namespace tessera::libav {

struct Free {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(AVBufferRef* buffer) const { av_buffer_unref(&buffer); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

/// libavcodec writes to stderr unless told otherwise, and its level is the whole process' own: what a context
/// says is moved past every level instead (which are below 64; the default callback looks at their lowest 8
/// bits).
constexpr int kSilent = 128;

inline std::string errorText(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof(text));
  return text;
}

}  // namespace tessera::libav
