#include "codec/transport/h264_payload.hpp"

#include <utility>

namespace tessera::transport {

namespace {

constexpr std::uint8_t kStapA = 24;
constexpr std::uint8_t kFuA = 28;
constexpr std::uint8_t kForbidden = 0x80;
constexpr std::uint8_t kTypeMask = 0x1f;
constexpr std::uint8_t kStart[] = {0, 0, 0, 1};

bool plainType(int type) { return type >= 1 && type <= 23; }

}  // namespace

Result<void> H264Assembler::push(std::span<const std::uint8_t> payload, bool gap) {
  if (gap) {
    damaged_ = true;
    dropFragment();
  }
  Result<void> done;
  if (payload.empty()) {
    done = fail("H.264 payload: empty");
  } else if ((payload[0] & kForbidden) != 0) {
    done = fail("H.264 payload: first byte {:#04x} has the forbidden bit", payload[0]);
  } else if (const int type = payload[0] & kTypeMask; type == kFuA) {
    done = fragment(payload);
  } else if (inFragment_) {
    done = fail("H.264 payload: type {} before a fragmented unit's end", type);
  } else if (type == kStapA) {
    done = aggregate(payload);
  } else if (plainType(type)) {
    done = single(payload);
  } else {
    done = fail("H.264 payload: type {}, none of packetization mode 1", type);
  }
  if (!done) {
    damaged_ = true;
    dropFragment();
  }
  return done;
}

std::vector<std::uint8_t> H264Assembler::take() {
  dropFragment();
  damaged_ = false;
  return std::exchange(bytes_, {});
}

void H264Assembler::dropFragment() {
  if (inFragment_) bytes_.resize(unitAt_);
  inFragment_ = false;
}

Result<void> H264Assembler::single(std::span<const std::uint8_t> unit) {
  bytes_.insert(bytes_.end(), std::begin(kStart), std::end(kStart));
  bytes_.insert(bytes_.end(), unit.begin(), unit.end());
  return {};
}

Result<void> H264Assembler::aggregate(std::span<const std::uint8_t> payload) {
  // Checked as a whole before a byte is taken: a bad aggregate adds nothing.
  for (std::size_t at = 1; at < payload.size();) {
    if (payload.size() - at < 2) return fail("H.264 aggregate: half a length at byte {}", at);
    const std::size_t length = std::size_t{payload[at]} << 8 | payload[at + 1];
    at += 2;
    if (length == 0 || length > payload.size() - at)
      return fail("H.264 aggregate: a unit of {} bytes at byte {} of {}", length, at, payload.size());
    if ((payload[at] & kForbidden) != 0 || !plainType(payload[at] & kTypeMask))
      return fail("H.264 aggregate: a unit with first byte {:#04x}", payload[at]);
    at += length;
  }
  if (payload.size() == 1) return fail("H.264 aggregate: no unit");
  for (std::size_t at = 1; at < payload.size();) {
    const std::size_t length = std::size_t{payload[at]} << 8 | payload[at + 1];
    (void)single(payload.subspan(at + 2, length));
    at += 2 + length;
  }
  return {};
}

Result<void> H264Assembler::fragment(std::span<const std::uint8_t> payload) {
  if (payload.size() < 3) return fail("H.264 fragment: {} bytes, at least 3 are needed", payload.size());
  const bool first = (payload[1] & 0x80) != 0;
  const bool last = (payload[1] & 0x40) != 0;
  const auto header = static_cast<std::uint8_t>((payload[0] & ~kTypeMask) | (payload[1] & kTypeMask));
  if (first && last) return fail("H.264 fragment: both first and last");
  if (!plainType(payload[1] & kTypeMask)) return fail("H.264 fragment: of type {}", payload[1] & kTypeMask);
  if (first) {
    if (inFragment_) return fail("H.264 fragment: a first one before the last of another unit");
    unitAt_ = bytes_.size();
    inFragment_ = true;
    fragmentHeader_ = header;
    bytes_.insert(bytes_.end(), std::begin(kStart), std::end(kStart));
    bytes_.push_back(header);
  } else if (!inFragment_) {
    // Its first fragment is lost; the rest of the unit is skipped, and that is no fault of this payload.
    damaged_ = true;
    return {};
  } else if (header != fragmentHeader_) {
    return fail("H.264 fragment: header {:#04x} inside a unit of header {:#04x}", header, fragmentHeader_);
  }
  bytes_.insert(bytes_.end(), payload.begin() + 2, payload.end());
  if (last) inFragment_ = false;
  return {};
}

}  // namespace tessera::transport
