// The stamp of a packet: what it holds comes back, and nothing else does.
#include "codec/stamp.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace tessera {
namespace {

using Bytes = std::vector<std::uint8_t>;

const Bytes kPacket = {0, 0, 0, 1, 0x65, 0x88, 0x84, 0, 3, 1, 2, 3, 4, 5, 6, 7, 8, 9};

TEST(Stamp, ComesBack) {
  for (const FrameStamp& stamp :
       {FrameStamp{0, 0}, FrameStamp{1, 0}, FrameStamp{0x0000000100000003u, 0x0000000200000000u},
        FrameStamp{std::numeric_limits<std::uint64_t>::max(), std::numeric_limits<std::uint64_t>::max()}}) {
    const Bytes bytes = stamped(stamp, kPacket);
    const auto read = readStamp(bytes);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->stamp.frame, stamp.frame);
    EXPECT_EQ(read->stamp.reference, stamp.reference);
    EXPECT_EQ(read->stamp.iFrame(), stamp.frame == stamp.reference);
    EXPECT_EQ(Bytes(read->packet.begin(), read->packet.end()), kPacket);
  }
}

TEST(Stamp, AnyBitThatDiffersIsSeen) {
  Bytes bytes = stamped({41, 40}, kPacket);
  for (std::size_t i = 0; i < bytes.size() * 8; ++i) {
    const auto bit = static_cast<std::uint8_t>(1U << i % 8);
    bytes[i / 8] ^= bit;
    EXPECT_FALSE(readStamp(bytes)) << "bit " << i;
    bytes[i / 8] ^= bit;
  }
  EXPECT_TRUE(readStamp(bytes));
}

TEST(Stamp, BytesThatAreMissingOrTooManyAreSeen) {
  Bytes bytes = stamped({41, 40}, kPacket);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(readStamp(std::span(bytes).first(size))) << size;
  const auto cut = readStamp(std::span(bytes).first(bytes.size() - 1));
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().message, "frame 41: 17 bytes instead of 18");
  bytes.push_back(0);
  EXPECT_FALSE(readStamp(bytes));
}

TEST(Stamp, TwoPacketsAreNotOne) {
  Bytes bytes = stamped({41, 40}, kPacket);
  const Bytes next = stamped({42, 41}, kPacket);
  bytes.insert(bytes.end(), next.begin(), next.end());
  EXPECT_FALSE(readStamp(bytes));
}

}  // namespace
}  // namespace tessera
