#include "codec/wire/range_coder.hpp"

#include <bit>
#include <cmath>

namespace tessera::wire {

namespace {

constexpr std::uint32_t kLeastRange = 1u << 24;

// Bits that a decision of this probability (of 2^BitModel::kBits) takes.
const std::array<float, std::size_t{1} << BitModel::kBits>& costs() {
  static const auto table = [] {
    std::array<float, std::size_t{1} << BitModel::kBits> bits{};
    for (std::size_t i = 1; i < bits.size(); ++i)
      bits[i] = static_cast<float>(BitModel::kBits - std::log2(static_cast<double>(i)));
    return bits;
  }();
  return table;
}

}  // namespace

void RangeEncoder::shift() {
  const auto top = static_cast<std::uint8_t>(low_ >> 24);
  const bool carry = low_ >= std::uint64_t{1} << 32;
  // The first byte has nothing before it that a carry could reach, and gets none: low_ stays below the first
  // range.
  if (top != 0xff || carry || held_ == 0) {
    const std::uint8_t plus = carry ? 1 : 0;
    if (held_ > 0) bytes_.push_back(static_cast<std::uint8_t>(first_ + plus));
    for (; held_ > 1; --held_) bytes_.push_back(static_cast<std::uint8_t>(0xff + plus));
    first_ = top;
    held_ = 0;
  }
  ++held_;
  low_ = (low_ & 0x00ffffffu) << 8;
}

void RangeEncoder::normalize() {
  while (range_ < kLeastRange) {
    range_ <<= 8;
    shift();
  }
}

void RangeEncoder::bit(bool value, BitModel& model) {
  const std::uint32_t zero = model.zero();
  const std::uint32_t bound = (range_ >> BitModel::kBits) * zero;
  cost_ += static_cast<double>(costs()[value ? (1u << BitModel::kBits) - zero : zero]);
  if (value) {
    low_ += bound;
    range_ -= bound;
  } else {
    range_ = bound;
  }
  model.update(value);
  normalize();
}

void RangeEncoder::plain(std::uint32_t value, int count) {
  cost_ += count;
  for (int i = count - 1; i >= 0; --i) {
    range_ >>= 1;
    if (((value >> i) & 1u) != 0) low_ += range_;
    normalize();
  }
}

std::vector<std::uint8_t> RangeEncoder::finish() {
  // Four bytes of low_, and one more shift to write what is held.
  for (int i = 0; i < 5; ++i) shift();
  std::vector<std::uint8_t> done = std::move(bytes_);
  *this = {};
  return done;
}

RangeDecoder::RangeDecoder(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
  for (int i = 0; i < 4; ++i) code_ = (code_ << 8) | next();
}

std::uint8_t RangeDecoder::next() {
  if (at_ < bytes_.size()) return bytes_[at_++];
  overrun_ = true;
  return 0;
}

void RangeDecoder::normalize() {
  while (range_ < kLeastRange) {
    range_ <<= 8;
    code_ = (code_ << 8) | next();
  }
}

bool RangeDecoder::bit(BitModel& model) {
  const std::uint32_t bound = (range_ >> BitModel::kBits) * model.zero();
  const bool value = code_ >= bound;
  if (value) {
    code_ -= bound;
    range_ -= bound;
  } else {
    range_ = bound;
  }
  model.update(value);
  normalize();
  return value;
}

std::uint32_t RangeDecoder::plain(int count) {
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i) {
    range_ >>= 1;
    const bool bit = code_ >= range_;
    if (bit) code_ -= range_;
    value = (value << 1) | (bit ? 1u : 0u);
    normalize();
  }
  return value;
}

void NumberModel::encode(RangeEncoder& coder, std::uint32_t value) {
  const int bits = std::bit_width(value);
  bits_.encode(coder, static_cast<std::uint32_t>(bits));
  if (bits < 2) return;
  auto& below = below_[static_cast<std::size_t>(bits)];
  const bool second = ((value >> (bits - 2)) & 1u) != 0;
  coder.bit(second, below[0]);
  if (bits < 3) return;
  coder.bit(((value >> (bits - 3)) & 1u) != 0, below[second ? 2 : 1]);
  coder.plain(value & ((1u << (bits - 3)) - 1u), bits - 3);
}

std::uint32_t NumberModel::decode(RangeDecoder& coder) {
  const auto bits = static_cast<int>(bits_.decode(coder));
  if (bits < 2) return static_cast<std::uint32_t>(bits);
  // The symbol has room for more than 32 bits, which no encoder writes.
  if (bits > 32) return 0xffffffffu;
  auto& below = below_[static_cast<std::size_t>(bits)];
  const bool second = coder.bit(below[0]);
  if (bits < 3) return second ? 3 : 2;
  const bool third = coder.bit(below[second ? 2 : 1]);
  const std::uint32_t top = 4u | (second ? 2u : 0u) | (third ? 1u : 0u);
  return (top << (bits - 3)) | coder.plain(bits - 3);
}

void SignedModel::encode(RangeEncoder& coder, std::int64_t value) {
  size_.encode(coder, static_cast<std::uint32_t>(value < 0 ? -value : value));
  if (value != 0) coder.bit(value < 0, sign_);
}

std::int64_t SignedModel::decode(RangeDecoder& coder) {
  const std::int64_t size = size_.decode(coder);
  return size != 0 && coder.bit(sign_) ? -size : size;
}

}  // namespace tessera::wire
