// Video of an atlas: planes in, H.264 packets out, and back. What lies here knows neither GL nor a transport.
//   encoder.hpp   VideoEncoder: planes of one frame to one packet
//   decoder.hpp   VideoDecoder: packets, with whatever a network did to them, to planes or to why there are
//   none stamp.hpp     the frame's number and checksum that each packet begins with
#pragma once

#include "codec/decoder.hpp"
#include "codec/encoder.hpp"
#include "codec/stamp.hpp"
