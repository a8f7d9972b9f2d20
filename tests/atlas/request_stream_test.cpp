#include "atlas/rect/request_stream.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "engine/core/file.hpp"

namespace tessera {
namespace {

using Bytes = std::vector<std::uint8_t>;

RequestHeader header(std::uint32_t patches = 500) {
  return {.scene = "höhle.glb", .width = 1920, .height = 1080, .patchInstances = patches, .fps = 99.9};
}

/// Frames of a camera that moves: patches come and go, and measures drift.
std::vector<RequestFrame> framesOf(std::uint32_t patches, std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> chance(0.0f, 1.0f);
  std::vector<glsl::PatchMeasure> measures(patches);
  std::vector<bool> visible(patches);
  for (std::uint32_t p = 0; p < patches; ++p) {
    measures[p] = {200.0f * chance(random) - 100.0f, 40.0f * chance(random) - 20.0f};
    visible[p] = chance(random) < 0.5f;
  }
  std::vector<RequestFrame> frames(count);
  for (std::size_t f = 0; f < count; ++f) {
    RequestFrame& frame = frames[f];
    for (std::uint32_t p = 0; p < patches; ++p) {
      if (chance(random) < 0.05f) visible[p] = !visible[p];
      if (!visible[p] || f == 3) continue;  // one frame sees nothing
      measures[p].logArea = std::clamp(measures[p].logArea + chance(random) - 0.5f, -100.0f, 100.0f);
      frame.patches.push_back(p);
      frame.measures.push_back(measures[p]);
    }
    if (f % 4 == 0) {
      frame.frameMs = 100.0f * chance(random);
      frame.memoryMs = chance(random);
    }
  }
  return frames;
}

RequestStream streamOf(const std::vector<RequestFrame>& frames, const RequestHeader& of = header()) {
  RequestStream stream(of);
  for (const RequestFrame& frame : frames) {
    const auto added = stream.add(frame);
    EXPECT_TRUE(added) << added.error().message;
  }
  return stream;
}

bool same(const RequestFrame& a, const RequestFrame& b) {
  const auto bits = [](const glsl::PatchMeasure& m) { return std::bit_cast<std::uint64_t>(m); };
  return a.patches == b.patches &&
         std::ranges::equal(a.measures, b.measures, std::ranges::equal_to{}, bits, bits) &&
         std::bit_cast<std::uint32_t>(a.frameMs) == std::bit_cast<std::uint32_t>(b.frameMs) &&
         std::bit_cast<std::uint32_t>(a.memoryMs) == std::bit_cast<std::uint32_t>(b.memoryMs);
}

std::string errorOf(const Bytes& bytes) {
  const auto parsed = RequestStream::parse("x.trs", bytes);
  return parsed ? "" : parsed.error().message;
}

/// Offsets of the header's fields, see request_stream.hpp.
constexpr std::size_t kAtVersion = 8;
constexpr std::size_t kAtWidth = 12;
constexpr std::size_t kAtPatches = 20;
constexpr std::size_t kAtFps = 24;
constexpr std::size_t kAtFrames = 32;
constexpr std::size_t kAtNameLength = 36;
constexpr std::size_t kAtName = 40;

template <class T>
Bytes with(Bytes bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(T));
  return bytes;
}

TEST(RequestStream, ReturnsEveryBit) {
  auto frames = framesOf(500, 40, 1);
  // Values at the edges, and both zeros.
  frames[5].patches = {0, 1, 2, 499};
  frames[5].measures = {
      {-0.0f, 0.0f}, {100.0f, -20.0f}, {std::numeric_limits<float>::denorm_min(), -0.0f}, {-100.0f, 20.0f}};
  const RequestStream written = streamOf(frames);
  const auto file = std::filesystem::path(TESSERA_BINARY_DIR) / "request_stream_test.trs";
  ASSERT_TRUE(written.save(file));
  const auto read = RequestStream::load(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->header(), header());
  ASSERT_EQ(read->frames(), frames.size());
  EXPECT_EQ(read->mostVisible(), written.mostVisible());
  EXPECT_EQ(read->bytes(), written.bytes());
  RequestStream::Reader reader(*read);
  RequestFrame frame;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const auto next = reader.next(frame);
    ASSERT_TRUE(next) << next.error().message;
    EXPECT_TRUE(same(frame, frames[f])) << "frame " << f;
  }
  EXPECT_FALSE(reader.next(frame));
  std::filesystem::remove(file);
}

TEST(RequestStream, NothingIsAStreamToo) {
  const auto read = RequestStream::parse("x", RequestStream(header(0)).bytes());
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->frames(), 0u);
  EXPECT_EQ(read->mostVisible(), 0u);
}

TEST(RequestStream, RefusesFramesThatMakeNoSense) {
  const auto refused = [](const RequestFrame& frame, const std::string& named) {
    RequestStream stream(header());
    const auto added = stream.add(frame);
    ASSERT_FALSE(added) << named;
    EXPECT_NE(added.error().message.find(named), std::string::npos) << added.error().message;
    EXPECT_EQ(stream.frames(), 0u);
  };
  refused({.patches = {1, 500}, .measures = {{}, {}}}, "instance 500 of 500");
  refused({.patches = {7, 7}, .measures = {{}, {}}}, "instance 7 after 7");
  refused({.patches = {7, 3}, .measures = {{}, {}}}, "instance 3 after 7");
  refused({.patches = {7}, .measures = {}}, "0 measures of 1 patches");
  refused({.patches = {7}, .measures = {{std::nanf(""), 0.0f}}}, "log2 area nan");
  refused({.patches = {7}, .measures = {{100.5f, 0.0f}}}, "log2 area 100.5");
  refused({.patches = {7}, .measures = {{0.0f, -20.5f}}}, "log2 aspect -20.5");
  refused({.patches = {}, .measures = {}, .frameMs = -1.0f}, "time of -1 ms");
  auto loaded = RequestStream::parse("x.trs", streamOf(framesOf(500, 2, 1)).bytes());
  ASSERT_TRUE(loaded);
  EXPECT_FALSE(loaded->add({}));
}

TEST(RequestStream, NamesWhatIsWrongInAFile) {
  const Bytes good = streamOf(framesOf(500, 6, 1)).bytes();
  ASSERT_EQ(errorOf(good), "");
  EXPECT_EQ(errorOf({}), "x.trs: not a request stream");
  EXPECT_EQ(errorOf(with<std::uint8_t>(good, 0, 'X')), "x.trs: not a request stream");
  EXPECT_EQ(errorOf(with<std::uint32_t>(good, kAtVersion, 2)), "x.trs: version 2, this reads version 1");
  EXPECT_NE(errorOf(with<std::uint32_t>(good, kAtWidth, 0)).find("0 x 1080"), std::string::npos);
  EXPECT_NE(errorOf(with<std::uint32_t>(good, kAtPatches, 0xffffffffu)).find("4294967295 patch instances"),
            std::string::npos);
  EXPECT_NE(errorOf(with<std::uint32_t>(good, kAtPatches, 10)).find("visible patches of 10"),
            std::string::npos);
  // Enough instances for the count, too few for the ids.
  EXPECT_NE(errorOf(with<std::uint32_t>(good, kAtPatches, 400)).find("of 400"), std::string::npos);
  EXPECT_NE(errorOf(with<std::uint32_t>(good, kAtPatches, 400)).find("is instance 4"), std::string::npos);
  EXPECT_NE(errorOf(with<double>(good, kAtFps, 0.0)).find("0 frames a second"), std::string::npos);
  EXPECT_NE(errorOf(with<std::uint32_t>(good, kAtFrames, 0x10000000u)).find("268435456 frames do not fit"),
            std::string::npos);
  EXPECT_NE(errorOf(with<std::uint32_t>(good, kAtFrames, 5)).find("after the last frame"), std::string::npos);
  EXPECT_NE(errorOf(with<std::uint32_t>(good, kAtFrames, 7)).find("frame 6"), std::string::npos);
  EXPECT_NE(errorOf(with<std::uint32_t>(good, kAtNameLength, 0xfffffff0u)).find("scene name"),
            std::string::npos);
  const std::size_t first = kAtName + header().scene.size();
  EXPECT_NE(errorOf(with<std::uint32_t>(good, first, 501)).find("frame 0: 501 visible patches of 500"),
            std::string::npos);
  EXPECT_NE(errorOf(with<std::uint32_t>(good, first, 1)).find("do not hold 1 patches"), std::string::npos);
  EXPECT_NE(errorOf(with<std::uint32_t>(good, first + 4, 0xffffffu)).find("frame 0: 16777215 bytes"),
            std::string::npos);
  EXPECT_NE(errorOf(with<float>(good, first + 8, std::nanf(""))).find("frame 0: a time of nan"),
            std::string::npos);
  // A bit of the packed frame itself: its checksum tells.
  Bytes flipped = good;
  flipped[first + 16 + 40] ^= 4;
  EXPECT_NE(errorOf(flipped).find("frame 0"), std::string::npos) << errorOf(flipped);
}

TEST(RequestStream, EveryTruncationIsRefused) {
  const Bytes good = streamOf(framesOf(60, 5, 2), header(60)).bytes();
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_NE(errorOf(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size))), "") << size;
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_NE(errorOf(longer), "");
}

TEST(RequestStream, MutationsAreRefusedOrReadWithinBounds) {
  const Bytes good = streamOf(framesOf(60, 5, 3), header(60)).bytes();
  std::mt19937 random(4);
  std::size_t refused = 0;
  for (int round = 0; round < 20000; ++round) {
    Bytes bytes = good;
    const int changes = 1 + static_cast<int>(random() % 4);
    for (int i = 0; i < changes; ++i)
      bytes[random() % bytes.size()] = round % 2 == 0
                                           ? static_cast<std::uint8_t>(random())
                                           : static_cast<std::uint8_t>(random() % 2 == 0 ? 0xff : 0);
    auto stream = RequestStream::parse("x.trs", bytes);
    if (!stream) {
      ++refused;
      continue;
    }
    RequestStream::Reader reader(*stream);
    RequestFrame frame;
    for (std::size_t f = 0; f < stream->frames(); ++f) {
      ASSERT_TRUE(reader.next(frame));
      for (const std::uint32_t patch : frame.patches) ASSERT_LT(patch, stream->header().patchInstances);
    }
  }
  // What can change unseen: times, the scene's name, its picture size, a byte set to what it was.
  EXPECT_GT(refused, 15000u);
}

}  // namespace
}  // namespace tessera
