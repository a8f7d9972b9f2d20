// Access units through packets and back: whole, with losses, out of order, twice, and with bytes that are
// none.
#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "codec/transport/h264_payload.hpp"
#include "codec/transport/rtp_receive.hpp"
#include "codec/transport/rtp_send.hpp"
#include "tests/transport/access_units.hpp"

namespace tessera::transport {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kSource = 0xfedcba98;

struct Sent {
  std::uint32_t frame = 0;
  Bytes unit;
  std::vector<Datagram> packets;
};

/// Frames first, first + 1, … of several units each: small ones that go together, one in a packet, and large
/// ones in fragments.
std::vector<Sent> sendFrames(std::mt19937& random, std::uint32_t first, int count,
                             std::uint16_t sequence = 7) {
  auto packetiser = RtpPacketiser::make({kSource, sequence, 1200});
  EXPECT_TRUE(packetiser.has_value()) << packetiser.error().message;
  std::vector<Sent> all;
  for (int i = 0; i < count; ++i) {
    Sent sent;
    sent.frame = first + static_cast<std::uint32_t>(i);
    sent.unit = test::accessUnit(random, {20, 8, 600 + random() % 600, 2 + random() % 20000, 3000});
    auto packets = packetiser->packetise(sent.unit, sent.frame, sent.frame * 3000);
    EXPECT_TRUE(packets.has_value()) << packets.error().message;
    sent.packets = std::move(*packets);
    all.push_back(std::move(sent));
  }
  return all;
}

std::vector<ReceivedFrame> drain(RtpReceiver& receiver, Clock::time_point now) {
  std::vector<ReceivedFrame> frames;
  while (auto frame = receiver.next(now)) frames.push_back(std::move(*frame));
  return frames;
}

void append(std::vector<ReceivedFrame>& to, std::vector<ReceivedFrame> from) {
  for (ReceivedFrame& frame : from) to.push_back(std::move(frame));
}

TEST(RtpSend, PacketsAreBoundedNumberedAndMarked) {
  std::mt19937 random(1);
  const auto all = sendFrames(random, 40, 3);
  std::uint16_t sequence = 7;
  for (const Sent& sent : all) {
    EXPECT_GT(sent.packets.size(), 5u);
    for (std::size_t i = 0; i < sent.packets.size(); ++i) {
      EXPECT_LE(sent.packets[i].size(), 1200u);
      const auto packet = parseRtp(sent.packets[i]);
      ASSERT_TRUE(packet.has_value()) << packet.error().message;
      EXPECT_EQ(packet->sequence, sequence++);
      EXPECT_EQ(packet->timestamp, sent.frame * 3000);
      EXPECT_EQ(packet->source, kSource);
      EXPECT_EQ(packet->marker, i + 1 == sent.packets.size());
      EXPECT_EQ(packet->place.frame, sent.frame);
      EXPECT_EQ(packet->place.index, i);
      EXPECT_EQ(packet->place.count, sent.packets.size());
    }
  }
}

TEST(RtpSend, RefusesWhatIsNoAccessUnit) {
  auto packetiser = RtpPacketiser::make({kSource, 0, 1200});
  ASSERT_TRUE(packetiser.has_value());
  EXPECT_FALSE(packetiser->packetise({}, 1, 0).has_value());
  EXPECT_FALSE(packetiser->packetise(Bytes{0, 0, 1}, 1, 0).has_value());
  EXPECT_FALSE(packetiser->packetise(Bytes{1, 2, 3, 4, 5}, 1, 0).has_value());
  EXPECT_TRUE(packetiser->packetise(Bytes{0, 0, 1, 0x65, 1}, 1, 0).has_value());
  EXPECT_FALSE(RtpPacketiser::make({kSource, 0, 100}).has_value());
  EXPECT_FALSE(RtpPacketiser::make({0, 0, 1200}).has_value());
}

TEST(RtpReceive, FramesComeBackBitForBit) {
  std::mt19937 random(2);
  RtpReceiver receiver(kSource);
  auto now = Clock::time_point{} + 1h;
  // Sequence numbers and time stamps run over their ends.
  for (const Sent& sent : sendFrames(random, 0xffffffff - 300, 300, 0x7f00)) {
    for (const Datagram& packet : sent.packets) ASSERT_TRUE(receiver.push(packet, now += 1ms).has_value());
    const auto frames = drain(receiver, now);
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_TRUE(frames[0].complete);
    EXPECT_FALSE(frames[0].lostBefore);
    EXPECT_EQ(frames[0].frame, sent.frame);
    EXPECT_EQ(frames[0].bytes, sent.unit);
  }
  EXPECT_EQ(receiver.statistics().lost, 0u);
  EXPECT_EQ(receiver.statistics().frames, 300u);
  const double seconds = std::chrono::duration<double>(now.time_since_epoch() - 1h).count();
  const double mean = 8e-6 * static_cast<double>(receiver.statistics().bytes) / seconds;
  EXPECT_NEAR(receiver.statistics().mbitPerSecond, mean, 0.1 * mean);
}

/// Loses each packet with a probability, and compares what the receiver says with what was lost.
void lose(double share, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto all = sendFrames(random, 1, 200);
  RtpReceiver receiver(kSource);
  auto now = Clock::time_point{} + 1h;
  std::map<std::uint32_t, std::size_t> lostOf;
  std::vector<ReceivedFrame> frames;
  std::uint64_t lost = 0;
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  for (const Sent& sent : all) {
    for (const Datagram& packet : sent.packets) {
      now += 1ms;
      // The first packet of all tells where the stream begins, the last that it went that far.
      const bool end =
          (sent.frame == 1 && &packet == &sent.packets.front()) || sent.frame == all.back().frame;
      if (!end && chance(random) < share) {
        ++lost;
        ++lostOf[sent.frame];
      } else {
        ASSERT_TRUE(receiver.push(packet, now).has_value());
      }
      append(frames, drain(receiver, now));
    }
  }
  append(frames, drain(receiver, now + 1s));
  EXPECT_EQ(receiver.statistics().lost, lost);
  std::uint32_t last = 0;
  std::size_t whole = 0;
  for (const ReceivedFrame& frame : frames) {
    EXPECT_EQ(frame.complete, !lostOf.contains(frame.frame)) << "frame " << frame.frame;
    EXPECT_EQ(frame.lostBefore, frame.frame != last + 1);
    EXPECT_GT(frame.frame, last);
    last = frame.frame;
    const Bytes& unit = all[frame.frame - 1].unit;
    if (frame.complete) {
      ++whole;
      EXPECT_EQ(frame.bytes, unit);
    } else {
      EXPECT_LT(frame.bytes.size(), unit.size());
    }
  }
  EXPECT_EQ(last, all.back().frame);
  EXPECT_EQ(whole, all.size() - lostOf.size());
  EXPECT_GE(lost, share > 0.0 ? 10u : 0u);
}

TEST(RtpReceive, KnowsEveryLossAtNone) { lose(0.0, 3); }
TEST(RtpReceive, KnowsEveryLossAtFivePercent) { lose(0.05, 4); }
TEST(RtpReceive, KnowsEveryLossAtTwentyPercent) { lose(0.2, 5); }

TEST(RtpReceive, AWholeFrameThatNeverCameShowsAtTheNext) {
  std::mt19937 random(6);
  const auto all = sendFrames(random, 1, 3);
  RtpReceiver receiver(kSource);
  auto now = Clock::time_point{} + 1h;
  for (const Datagram& packet : all[0].packets) ASSERT_TRUE(receiver.push(packet, now).has_value());
  for (const Datagram& packet : all[2].packets) ASSERT_TRUE(receiver.push(packet, now).has_value());
  EXPECT_EQ(drain(receiver, now).size(), 1u);
  EXPECT_TRUE(drain(receiver, now + 19ms).empty()) << "it may still come";
  const auto frames = drain(receiver, now + 20ms);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].frame, 3u);
  EXPECT_TRUE(frames[0].complete);
  EXPECT_TRUE(frames[0].lostBefore);
  EXPECT_EQ(receiver.statistics().lost, all[1].packets.size());
  // What comes after all is late, and changes nothing.
  ASSERT_TRUE(receiver.push(all[1].packets[0], now + 21ms).has_value());
  EXPECT_EQ(receiver.statistics().late, 1u);
  EXPECT_TRUE(drain(receiver, now + 1s).empty());
}

TEST(RtpReceive, TheLastFrameIsGivenUpInSilence) {
  std::mt19937 random(7);
  const auto all = sendFrames(random, 1, 1);
  RtpReceiver receiver(kSource);
  const auto now = Clock::time_point{} + 1h;
  for (std::size_t i = 0; i + 1 < all[0].packets.size(); ++i)
    ASSERT_TRUE(receiver.push(all[0].packets[i], now).has_value());
  EXPECT_TRUE(drain(receiver, now + 99ms).empty());
  EXPECT_EQ(receiver.nextDeadline(), now + 100ms);
  const auto frames = drain(receiver, now + 100ms);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_FALSE(frames[0].complete);
  EXPECT_FALSE(receiver.nextDeadline().has_value());
}

TEST(RtpReceive, ReorderedAndDoubledPacketsCostNothing) {
  std::mt19937 random(8);
  auto all = sendFrames(random, 1, 100);
  RtpReceiver receiver(kSource);
  auto now = Clock::time_point{} + 1h;
  std::vector<Datagram> packets;
  for (const Sent& sent : all)
    for (const Datagram& packet : sent.packets) packets.push_back(packet);
  // Windows of twelve are shuffled: packets change frames' order too. The first stays.
  for (std::size_t i = 1; i + 12 < packets.size(); i += 12)
    std::shuffle(packets.begin() + static_cast<std::ptrdiff_t>(i),
                 packets.begin() + static_cast<std::ptrdiff_t>(i + 12), random);
  std::vector<ReceivedFrame> frames;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    now += 1ms;
    for (int again = 0; again < (i % 3 == 0 ? 2 : 1); ++again)
      ASSERT_TRUE(receiver.push(packets[i], now).has_value());
    append(frames, drain(receiver, now));
  }
  append(frames, drain(receiver, now + 1s));
  ASSERT_EQ(frames.size(), all.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].frame, all[i].frame);
    EXPECT_TRUE(frames[i].complete);
    EXPECT_EQ(frames[i].bytes, all[i].unit);
  }
  EXPECT_EQ(receiver.statistics().lost, 0u);
  // A frame whose double comes when it is handed out already counts as late.
  EXPECT_EQ(receiver.statistics().duplicated + receiver.statistics().late, (packets.size() + 2) / 3);
}

TEST(RtpReceive, GoesOnAfterALongSilence) {
  std::mt19937 random(9);
  const auto all = sendFrames(random, 1, 800);
  RtpReceiver receiver(kSource);
  auto now = Clock::time_point{} + 1h;
  for (const Datagram& packet : all[0].packets) ASSERT_TRUE(receiver.push(packet, now).has_value());
  ASSERT_EQ(drain(receiver, now).size(), 1u);
  // More than 3000 packets later: the first is taken for a stray one, the second says that the stream moved.
  now += 10s;
  std::size_t refused = 0;
  for (const Sent* sent : {&all[798], &all[799]})
    for (const Datagram& packet : sent->packets) refused += receiver.push(packet, now) ? 0 : 1;
  EXPECT_EQ(refused, 1u);
  const auto frames = drain(receiver, now + 1s);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_FALSE(frames[0].complete);
  EXPECT_TRUE(frames[0].lostBefore);
  EXPECT_TRUE(frames[1].complete);
  EXPECT_EQ(frames[1].bytes, all[799].unit);
}

TEST(RtpReceive, RefusesPacketsThatContradict) {
  std::mt19937 random(10);
  const auto all = sendFrames(random, 1, 2);
  RtpReceiver receiver(kSource);
  const auto now = Clock::time_point{} + 1h;
  const auto refused = [&](const Datagram& packet) { return !receiver.push(packet, now).has_value(); };
  Datagram other = all[0].packets[1];
  other[11] ^= 1;
  EXPECT_TRUE(refused(other)) << "another source";
  ASSERT_FALSE(refused(all[0].packets[0]));
  for (const std::size_t at : {7u, 20u, 24u}) {
    other = all[0].packets[1];
    other[at] ^= 1;
    EXPECT_TRUE(refused(other)) << "another time stamp, frame or count, byte " << at;
  }
  // A frame that would begin inside the first one.
  other = all[1].packets[0];
  other[3] = static_cast<std::uint8_t>(other[3] - 1);
  EXPECT_TRUE(refused(other));
  EXPECT_EQ(receiver.statistics().malformed, 5u);
  // None of it did harm.
  for (const Datagram& packet : all[0].packets) EXPECT_FALSE(refused(packet));
  const auto frames = drain(receiver, now);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].bytes, all[0].unit);
}

TEST(RtpReceive, HoldsNoMoreThanItsLimits) {
  std::mt19937 random(11);
  ReceiveLimits limits;
  limits.frames = 4;
  RtpReceiver receiver(kSource, limits);
  const auto now = Clock::time_point{} + 1h;
  std::size_t out = 0;
  // Each frame lacks its second packet, and time stands still.
  for (const Sent& sent : sendFrames(random, 1, 50)) {
    for (std::size_t i = 0; i < sent.packets.size(); ++i) {
      if (i == 1) continue;
      ASSERT_TRUE(receiver.push(sent.packets[i], now).has_value());
    }
    out += drain(receiver, now).size();
    EXPECT_GE(out + limits.frames, sent.frame);
  }
  EXPECT_EQ(out, 46u);
}

TEST(RtpReceive, JitterIsOfTheNetworkNotOfThePacing) {
  std::mt19937 random(12);
  const auto all = sendFrames(random, 1, 40);
  const auto jitterOf = [&](Clock::duration most) {
    RtpReceiver receiver(kSource);
    auto sentAt = Clock::time_point{} + 1h;
    for (const Sent& sent : all)
      for (Datagram packet : sent.packets) {
        sentAt += 2ms;
        const double seconds = std::chrono::duration<double>(sentAt.time_since_epoch()).count();
        stampSendTime(packet, static_cast<std::uint32_t>(static_cast<std::uint64_t>(seconds * kSendTimeHz)));
        const auto extra = most.count() == 0 ? Clock::duration{} : Clock::duration(random() % most.count());
        EXPECT_TRUE(receiver.push(packet, sentAt + 30ms + extra).has_value());
      }
    return receiver.statistics().jitterMs;
  };
  EXPECT_LT(jitterOf(0ms), 0.01);
  // The mean difference of two even draws from [0, 1.5 ms) is 0.5 ms.
  EXPECT_NEAR(jitterOf(1500us), 0.5, 0.25);
}

TEST(RtpPacket, RefusesBytesThatAreNone) {
  std::mt19937 random(13);
  const Datagram good = sendFrames(random, 1, 1)[0].packets[0];
  ASSERT_TRUE(parseRtp(good).has_value());
  for (std::size_t size = 0; size <= 28; ++size)
    EXPECT_FALSE(parseRtp(std::span(good).first(size)).has_value()) << size;
  for (const std::size_t at : {0u, 1u, 12u, 15u, 16u}) {
    Datagram bad = good;
    bad[at] ^= 0x40;
    EXPECT_FALSE(parseRtp(bad).has_value()) << "byte " << at;
  }
  Datagram bad = good;
  bad[21] = 0xff;
  EXPECT_FALSE(parseRtp(bad).has_value()) << "an index past its count";
  bad = good;
  bad[1] ^= 0x80;
  EXPECT_FALSE(parseRtp(bad).has_value()) << "a marker on the first packet of many";
}

TEST(H264Payload, ReadsTheThreeForms) {
  H264Assembler assembler;
  ASSERT_TRUE(assembler.push(Bytes{0x18, 0, 2, 0x67, 0xaa, 0, 1, 0x68}, false).has_value());
  ASSERT_TRUE(assembler.push(Bytes{0x65, 1, 2}, false).has_value());
  ASSERT_TRUE(assembler.push(Bytes{0x7c, 0x81, 3}, false).has_value());
  EXPECT_TRUE(assembler.damaged()) << "a unit without its end";
  ASSERT_TRUE(assembler.push(Bytes{0x7c, 0x41, 4}, false).has_value());
  EXPECT_FALSE(assembler.damaged());
  EXPECT_EQ(assembler.take(), (Bytes{0, 0, 0,    1, 0x67, 0xaa, 0, 0, 0, 1,    0x68, 0, 0,
                                     0, 1, 0x65, 1, 2,    0,    0, 0, 1, 0x61, 3,    4}));
}

TEST(H264Payload, RefusesWhatTheFormDoesNotAllow) {
  const Bytes bad[] = {
      {},
      {0xe5, 1},              // forbidden bit
      {0x00, 1},              // type 0
      {0x19, 1, 2, 3, 4, 5},  // STAP-B
      {0x1d, 0x81, 0, 0, 1},  // FU-B
      {0x1e, 1},              // none
      {0x18},                 // an aggregate of nothing
      {0x18, 0},              // half a length
      {0x18, 0, 0},           // an empty unit
      {0x18, 0, 3, 0x67, 1},  // longer than what is there
      {0x18, 0, 1, 0x18},     // an aggregate in an aggregate
      {0x7c, 0x81},           // an empty fragment
      {0x7c, 0xc1, 1},        // first and last
      {0x7c, 0x9c, 1},        // a fragment of a fragment
  };
  for (const Bytes& payload : bad) {
    H264Assembler assembler;
    EXPECT_FALSE(assembler.push(payload, false).has_value()) << ::testing::PrintToString(payload);
    EXPECT_TRUE(assembler.damaged());
    EXPECT_TRUE(assembler.take().empty());
  }
  H264Assembler assembler;
  ASSERT_TRUE(assembler.push(Bytes{0x7c, 0x81, 1}, false).has_value());
  EXPECT_FALSE(assembler.push(Bytes{0x7c, 0x45, 1}, false).has_value()) << "of another unit";
  EXPECT_TRUE(assembler.take().empty()) << "half a unit is none";
}

TEST(H264Payload, AGapDropsTheUnitAroundItAlone) {
  H264Assembler assembler;
  ASSERT_TRUE(assembler.push(Bytes{0x67, 9}, false).has_value());
  ASSERT_TRUE(assembler.push(Bytes{0x7c, 0x81, 1}, false).has_value());
  ASSERT_TRUE(assembler.push(Bytes{0x7c, 0x41, 3}, true).has_value());
  ASSERT_TRUE(assembler.push(Bytes{0x65, 7}, false).has_value());
  EXPECT_TRUE(assembler.damaged());
  EXPECT_EQ(assembler.take(), (Bytes{0, 0, 0, 1, 0x67, 9, 0, 0, 0, 1, 0x65, 7}));
}

}  // namespace
}  // namespace tessera::transport
