// Any datagrams at any times to the video's receiver: u16 size, u8 milliseconds since the last, the bytes.
#include <algorithm>
#include <cstdlib>

#include "codec/transport/rtp_receive.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera::transport;
  ReceiveLimits limits;
  limits.frames = 4;
  limits.bytes = 1 << 20;
  RtpReceiver receiver(0x01020304, limits);
  auto now = Clock::time_point{} + std::chrono::hours(1);
  std::uint64_t frames = 0;
  const auto drain = [&] {
    while (auto frame = receiver.next(now)) {
      ++frames;
      if (frame->complete && frame->bytes.empty()) std::abort();
    }
  };
  for (std::size_t at = 0; at + 3 <= size;) {
    const std::size_t length = std::min<std::size_t>(data[at] | data[at + 1] << 8, size - at - 3);
    now += std::chrono::milliseconds(data[at + 2]);
    (void)receiver.push({data + at + 3, length}, now);
    drain();
    if (const auto due = receiver.nextDeadline(); due && *due <= now) std::abort();
    at += 3 + length;
  }
  now += std::chrono::seconds(1);
  drain();
  // Within a second everything is given up, and each frame that was handed out is counted once.
  now += std::chrono::seconds(1);
  drain();
  if (receiver.nextDeadline()) std::abort();
  if (receiver.statistics().frames + receiver.statistics().damaged != frames) std::abort();
  return 0;
}
