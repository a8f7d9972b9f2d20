// Packets over the frame time, on a clock of the test's own.
#include "codec/transport/pacer.hpp"

#include <gtest/gtest.h>

namespace tessera::transport {
namespace {

using namespace std::chrono_literals;

std::vector<Datagram> frameOf(std::size_t packets, std::uint8_t mark = 0) {
  return std::vector<Datagram>(packets, Datagram{mark});
}

/// Times since `start` at which packets left, in a loop that wakes when the next is due.
std::vector<double> departures(Pacer& pacer, Clock::time_point start) {
  std::vector<double> times;
  while (const auto due = pacer.nextDue()) {
    EXPECT_FALSE(pacer.pop(*due - 1ns).has_value()) << "not before it is due";
    EXPECT_TRUE(pacer.pop(*due).has_value());
    times.push_back(std::chrono::duration<double, std::milli>(*due - start).count());
  }
  return times;
}

TEST(Pacer, SpreadsAFrameEvenly) {
  Pacer pacer(30ms, 0.8);
  const auto start = Clock::time_point{} + 1h;
  pacer.push(frameOf(100), start);
  const auto times = departures(pacer, start);
  ASSERT_EQ(times.size(), 100u);
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(times[i], 0.24 * static_cast<double>(i), 1e-3);
}

// A receiver gives a frame up that stays without its next packet for 100 ms.
TEST(Pacer, SlowFramesAreSentAsOnes) {
  Pacer pacer(10s, 0.8);
  const auto start = Clock::time_point{} + 1h;
  pacer.push(frameOf(2), start);
  EXPECT_LE(departures(pacer, start).back(), 50.0);
}

TEST(Pacer, AFrameWaitsForTheOneBefore) {
  Pacer pacer(30ms, 0.8);
  const auto start = Clock::time_point{} + 1h;
  pacer.push(frameOf(10), start);
  pacer.push(frameOf(10), start + 10ms);
  const auto times = departures(pacer, start);
  EXPECT_NEAR(times[10], 24.0, 1e-3);
  EXPECT_NEAR(times[19], 24.0 + 0.9 * 24.0, 1e-3);
}

TEST(Pacer, ASlowFrameDelaysNoLaterOne) {
  Pacer pacer(30ms, 0.8);
  const auto start = Clock::time_point{} + 1h;
  pacer.push(frameOf(1), start);
  ASSERT_TRUE(pacer.pop(start).has_value());
  pacer.push(frameOf(1), start + 100ms);
  EXPECT_EQ(pacer.nextDue(), start + 100ms);
}

TEST(Pacer, NeverHoldsBackMoreThanTwoIntervals) {
  Pacer pacer(30ms, 0.8);
  const auto start = Clock::time_point{} + 1h;
  for (std::uint8_t i = 0; i < 20; ++i) pacer.push(frameOf(10, i), start);
  std::uint8_t last = 0;
  std::size_t count = 0;
  while (const auto packet = pacer.pop(start + 90ms)) {
    EXPECT_GE(packet->front(), last) << "in order";
    last = packet->front();
    ++count;
  }
  EXPECT_EQ(count, 200u);
}

TEST(Pacer, TakesAFrameOfNothing) {
  Pacer pacer(30ms);
  pacer.push({}, Clock::time_point{} + 1h);
  EXPECT_FALSE(pacer.nextDue().has_value());
}

}  // namespace
}  // namespace tessera::transport
