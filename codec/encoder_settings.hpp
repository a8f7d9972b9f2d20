// What each encoder of libavcodec is told, and in which form it takes pictures. For codec/*.cpp only.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "codec/encoder.hpp"
#include "codec/libav.hpp"

namespace tessera {

/// Names and values of an encoder's own options. Of one that is not known here: none.
std::vector<std::pair<std::string, std::string>> settingsOf(const std::string& encoder,
                                                            const EncoderOptions& options);

/// Whether an encoder is known to read AV_FRAME_DATA_REGIONS_OF_INTEREST.
bool encoderTakesRegions(const std::string& encoder);

/// What pictures go in as: planes, planes with interleaved chroma, or such on the device. AV_PIX_FMT_NONE
/// where the encoder takes none of these.
AVPixelFormat formatFor(const AVCodec& codec, Chroma chroma);

}  // namespace tessera
