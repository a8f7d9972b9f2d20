// Binary arithmetic coding with adaptive models. Based on Martin, "Range encoding" (1979), with the carry
// kept back as in Schindler, "A fast renormalisation for arithmetic coding" (1998). Models live with the
// caller: kept from message to message, on both sides alike, they make small messages as cheap as the same
// numbers in a large one.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tessera::wire {

/// How probable a 0 is, as the mean of a quick and a slow estimate.
class BitModel {
 public:
  static constexpr int kBits = 12;
  /// Of 2^kBits; never 0 nor all of them.
  [[nodiscard]] std::uint32_t zero() const { return ((std::uint32_t{quick_} + slow_) >> (17 - kBits)) | 1u; }
  void update(bool bit) {
    adapt(quick_, kQuick, bit);
    adapt(slow_, kSlow, bit);
  }

 private:
  // Shifts of the estimates' steps; of 4 to 7 these gave the fewest bytes on sponza and the atrium.
  static constexpr int kQuick = 4;
  static constexpr int kSlow = 7;
  static void adapt(std::uint16_t& estimate, int shift, bool bit) {
    if (bit)
      estimate = static_cast<std::uint16_t>(estimate - (estimate >> shift));
    else
      estimate = static_cast<std::uint16_t>(estimate + ((0xffff - estimate) >> shift));
  }
  std::uint16_t quick_ = 0x8000;
  std::uint16_t slow_ = 0x8000;
};

class RangeEncoder {
 public:
  void bit(bool value, BitModel& model);
  /// `count` bits of `value`, each as likely 0 as 1; count in [0, 32].
  void plain(std::uint32_t value, int count);
  /// Ends the message; the encoder starts a new one.
  std::vector<std::uint8_t> finish();
  /// Bits that the message takes so far, fractions and all.
  [[nodiscard]] double cost() const { return cost_; }

 private:
  void normalize();
  void shift();
  std::vector<std::uint8_t> bytes_;
  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffffffffu;
  std::uint64_t held_ = 0;  // bytes kept back, for a carry may still pass through: one, then 0xff each
  std::uint8_t first_ = 0;  // of them
  double cost_ = 0.0;
};

/// The other way. Any bytes decode to something; complete() tells whether they were a whole message.
class RangeDecoder {
 public:
  explicit RangeDecoder(std::span<const std::uint8_t> bytes);
  bool bit(BitModel& model);
  std::uint32_t plain(int count);
  /// All bytes were read, and none beyond them.
  [[nodiscard]] bool complete() const { return at_ == bytes_.size() && !overrun_; }
  /// Bytes beyond the end were asked for.
  [[nodiscard]] bool overrun() const { return overrun_; }

 private:
  void normalize();
  std::uint8_t next();
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool overrun_ = false;
  std::uint32_t range_ = 0xffffffffu;
  std::uint32_t code_ = 0;
};

/// A symbol of `Bits` bits, most significant first, each bit's model chosen by those before it.
template <int Bits>
class SymbolModel {
 public:
  void encode(RangeEncoder& coder, std::uint32_t symbol) {
    std::uint32_t node = 1;
    for (int i = Bits - 1; i >= 0; --i) {
      const bool bit = ((symbol >> i) & 1u) != 0;
      coder.bit(bit, models_[node]);
      node = 2 * node + (bit ? 1 : 0);
    }
  }
  std::uint32_t decode(RangeDecoder& coder) {
    std::uint32_t node = 1;
    for (int i = 0; i < Bits; ++i) node = 2 * node + (coder.bit(models_[node]) ? 1 : 0);
    return node - (1u << Bits);
  }

 private:
  std::array<BitModel, std::size_t{1} << Bits> models_;
};

/// A number of any size: how many bits it has, the two below the first of them modelled, the rest as they
/// are. An exponential Golomb code (Teuhola 1978) whose prefix adapts.
class NumberModel {
 public:
  void encode(RangeEncoder& coder, std::uint32_t value);
  std::uint32_t decode(RangeDecoder& coder);

 private:
  SymbolModel<6> bits_;
  std::array<std::array<BitModel, 3>, 33> below_;
};

class SignedModel {
 public:
  void encode(RangeEncoder& coder, std::int64_t value);  // |value| < 2^32
  std::int64_t decode(RangeDecoder& coder);

 private:
  NumberModel size_;
  BitModel sign_;
};

}  // namespace tessera::wire
