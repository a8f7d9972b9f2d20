#include "codec/wire/range_coder.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace tessera::wire {
namespace {

TEST(RangeCoder, NumbersOfAllSizesComeBack) {
  std::mt19937 random(4);
  for (int round = 0; round < 200; ++round) {
    std::vector<std::int64_t> values;
    for (int i = 0; i < round * 7; ++i) {
      const auto bits = std::uniform_int_distribution<int>(0, 32)(random);
      const auto mask = (std::uint64_t{1} << bits) - 1;
      auto value = static_cast<std::int64_t>(((std::uint64_t{random()} << 32) | random()) & mask);
      values.push_back(random() % 2 == 0 ? value : -value);
    }
    values.insert(values.end(), {0, 1, -1, 0xffffffff, -0xffffffffll, 0x80000000});
    RangeEncoder encoder;
    SignedModel model;
    NumberModel number;
    SymbolModel<5> symbol;
    for (const std::int64_t value : values) {
      model.encode(encoder, value);
      number.encode(encoder, static_cast<std::uint32_t>(value));
      symbol.encode(encoder, static_cast<std::uint32_t>(value) & 31u);
      encoder.plain(static_cast<std::uint32_t>(value) >> 3, 29);
    }
    const double cost = encoder.cost();
    const auto bytes = encoder.finish();
    EXPECT_NEAR(static_cast<double>(bytes.size()), cost / 8.0 + 4.0, 2.0 + cost * 1e-3);
    RangeDecoder decoder(bytes);
    SignedModel model2;
    NumberModel number2;
    SymbolModel<5> symbol2;
    for (const std::int64_t value : values) {
      ASSERT_EQ(model2.decode(decoder), value);
      ASSERT_EQ(number2.decode(decoder), static_cast<std::uint32_t>(value));
      ASSERT_EQ(symbol2.decode(decoder), static_cast<std::uint32_t>(value) & 31u);
      ASSERT_EQ(decoder.plain(29), static_cast<std::uint32_t>(value) >> 3);
    }
    EXPECT_TRUE(decoder.complete());
  }
}

// Carries through runs of 0xff, which random numbers seldom make.
TEST(RangeCoder, CarriesPass) {
  for (int ones = 0; ones < 300; ++ones) {
    RangeEncoder encoder;
    BitModel rare;
    for (int i = 0; i < ones; ++i) encoder.plain(1, 1);
    for (int i = 0; i < 64; ++i) encoder.bit(i % 9 == 8, rare);
    for (int i = 0; i < ones; ++i) encoder.plain(0xff, 8);
    const auto bytes = encoder.finish();
    RangeDecoder decoder(bytes);
    BitModel again;
    for (int i = 0; i < ones; ++i) ASSERT_EQ(decoder.plain(1), 1u);
    for (int i = 0; i < 64; ++i) ASSERT_EQ(decoder.bit(again), i % 9 == 8);
    for (int i = 0; i < ones; ++i) ASSERT_EQ(decoder.plain(8), 0xffu);
    ASSERT_TRUE(decoder.complete());
  }
}

// 90 % zeros have an entropy of 0.469 bits each.
TEST(RangeCoder, ModelsComeNearTheEntropy) {
  std::mt19937 random(5);
  RangeEncoder encoder;
  BitModel model;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) encoder.bit(random() % 10 == 0, model);
  EXPECT_NEAR(encoder.cost() / kCount, 0.469, 0.03);
}

TEST(RangeCoder, MessagesEndWhereTheyEnd) {
  RangeEncoder encoder;
  NumberModel model;
  for (std::uint32_t i = 0; i < 50; ++i) model.encode(encoder, i * 977);
  auto bytes = encoder.finish();
  const auto complete = [](std::span<const std::uint8_t> from) {
    RangeDecoder decoder(from);
    NumberModel numbers;
    for (int i = 0; i < 50; ++i) numbers.decode(decoder);
    return decoder.complete();
  };
  EXPECT_TRUE(complete(bytes));
  EXPECT_FALSE(complete(std::span(bytes).first(bytes.size() - 1)));
  bytes.push_back(0);
  EXPECT_FALSE(complete(bytes));
}

}  // namespace
}  // namespace tessera::wire
