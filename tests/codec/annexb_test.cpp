// Units of the byte stream, by hand-worked streams.
#include "codec/annexb.hpp"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::vector<Bytes> unitsOf(const Bytes& stream) {
  std::vector<Bytes> units;
  for (const Nal& nal : nalsOf(stream)) units.emplace_back(nal.bytes.begin(), nal.bytes.end());
  return units;
}

TEST(AnnexB, UnitsLieBetweenStartCodes) {
  EXPECT_EQ(unitsOf({0, 0, 0, 1, 0x67, 5, 0, 0, 1, 0x68, 0, 0, 0, 1, 0x65, 1, 2}),
            (std::vector<Bytes>{{0x67, 5}, {0x68}, {0x65, 1, 2}}));
  EXPECT_EQ(unitsOf({9, 9, 0, 0, 1, 0x41, 1}), (std::vector<Bytes>{{0x41, 1}}))
      << "what comes before is no unit";
  EXPECT_EQ(unitsOf({0, 0, 1, 0, 0, 1, 0, 0, 1}), std::vector<Bytes>{}) << "nor is nothing";
  EXPECT_EQ(unitsOf({}), std::vector<Bytes>{});
  EXPECT_EQ(unitsOf({0, 0}), std::vector<Bytes>{});
  EXPECT_EQ(unitsOf({0, 1, 0, 0, 2, 1, 1, 1}), std::vector<Bytes>{});
  EXPECT_EQ(nalsOf(Bytes{0, 0, 1, 0x65})[0].type(), NalType::IdrSlice);
}

TEST(AnnexB, TheFirstUnitAlone) {
  Nal nal;
  std::size_t end = 0;
  const Bytes stream = {0, 0, 0, 1, 6, 7, 0x80, 0, 0, 0, 1, 0x65, 1};
  ASSERT_TRUE(firstNal(stream, nal, end));
  EXPECT_EQ(Bytes(nal.bytes.begin(), nal.bytes.end()), (Bytes{6, 7, 0x80}));
  EXPECT_EQ(end, 7u);
  const Bytes alone = {0, 0, 1, 6};
  ASSERT_TRUE(firstNal(alone, nal, end));
  EXPECT_EQ(end, 4u);
  for (const Bytes& none : {Bytes{}, Bytes{0, 0, 1}, Bytes{0, 0, 0, 1}, Bytes{0, 0, 2, 1},
                            Bytes{1, 0, 0, 1, 6}, Bytes{0, 0, 0, 0, 1, 6}, Bytes{0, 0, 1, 0, 0, 1, 6}})
    EXPECT_FALSE(firstNal(none, nal, end)) << none.size();
}

TEST(AnnexB, StartCodesAreMadeLong) {
  EXPECT_EQ(withLongStartCodes(Bytes{0, 0, 1, 0x67, 5, 0, 0, 0, 1, 0x68, 0, 0, 1, 0x65, 1, 2}),
            (Bytes{0, 0, 0, 1, 0x67, 5, 0, 0, 0, 1, 0x68, 0, 0, 0, 1, 0x65, 1, 2}));
  EXPECT_EQ(withLongStartCodes(Bytes{9, 0, 0, 1, 0x41, 7, 0, 0}), (Bytes{0, 0, 0, 1, 0x41, 7}))
      << "neither what comes before nor trailing zeroes";
  EXPECT_EQ(withLongStartCodes(Bytes{0, 0, 1, 0x41, 0, 0, 3, 1}), (Bytes{0, 0, 0, 1, 0x41, 0, 0, 3, 1}))
      << "what is escaped stays so";
  EXPECT_EQ(withLongStartCodes(Bytes{}), Bytes{});
  EXPECT_EQ(withLongStartCodes(Bytes{1, 2, 3}), Bytes{});
  // Once more changes nothing.
  const Bytes once = withLongStartCodes(Bytes{0, 0, 1, 0x67, 5, 0, 0, 1, 0x68, 4, 0, 0, 0, 0, 1, 0x65, 1});
  EXPECT_EQ(withLongStartCodes(once), once);
  EXPECT_EQ(unitsOf(once), (std::vector<Bytes>{{0x67, 5}, {0x68, 4}, {0x65, 1}}));
}

TEST(AnnexB, EscapingKeepsStartCodesOut) {
  EXPECT_EQ(escape(Bytes{0, 0, 0}), (Bytes{0, 0, 3, 0}));
  EXPECT_EQ(escape(Bytes{0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4}),
            (Bytes{0, 0, 3, 1, 0, 0, 3, 2, 0, 0, 3, 3, 0, 0, 4}));
  EXPECT_EQ(escape(Bytes{0, 0, 0, 0, 0, 0}), (Bytes{0, 0, 3, 0, 0, 3, 0, 0}));
  // All of a length over the values that matter come back, and hold no start code.
  for (int code = 0; code < 3125 * 5; ++code) {
    Bytes payload;
    for (int rest = code, i = 0; i < 6; ++i, rest /= 5)
      payload.push_back(static_cast<std::uint8_t>(rest % 5));
    const Bytes escaped = escape(payload);
    ASSERT_EQ(unescape(escaped), payload);
    for (std::size_t i = 2; i < escaped.size(); ++i)
      ASSERT_FALSE(escaped[i - 2] == 0 && escaped[i - 1] == 0 && escaped[i] < 3);
  }
}

}  // namespace
}  // namespace tessera
