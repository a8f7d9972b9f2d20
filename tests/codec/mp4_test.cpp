// Videos for browsers: the boxes that one needs, and what is refused.
#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "codec/annexb.hpp"
#include "codec/mp4_writer.hpp"
#include "codec/stamp.hpp"

namespace tessera {
namespace {

bool holds(const std::vector<std::uint8_t>& file, std::span<const std::uint8_t> part) {
  return std::search(file.begin(), file.end(), part.begin(), part.end()) != file.end();
}
bool holds(const std::vector<std::uint8_t>& file, const std::string& text) {
  return holds(file, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

std::vector<EncodedFrame> coded(int count) {
  EncoderOptions options;
  options.width = 96;
  options.height = 64;
  options.iFrameInterval = 0;
  options.encoders = {"libx264"};
  auto encoder = VideoEncoder::create(options);
  std::vector<EncodedFrame> frames;
  for (int i = 0; i < count; ++i) {
    YuvImage planes(96, 64, Chroma::Yuv420);
    for (std::size_t at = 0; at < planes.bytes.size(); ++at)
      planes.bytes[at] = static_cast<std::uint8_t>(at * 7 + static_cast<std::size_t>(i) * 31);
    frames.push_back(*encoder->encode(planes.view(), static_cast<std::uint64_t>(i) + 1));
  }
  return frames;
}

TEST(Mp4Writer, PutsEveryPictureIntoTheFile) {
  const auto frames = coded(3);
  auto writer = Mp4Writer::create(96, 64, 60.0);
  ASSERT_TRUE(writer) << writer.error().message;
  for (const EncodedFrame& frame : frames) ASSERT_TRUE(writer->add(frame));
  const auto file = writer->finish();
  ASSERT_TRUE(file) << file.error().message;
  for (const char* box : {"ftyp", "moov", "avc1", "avcC", "mdat"})
    EXPECT_TRUE(holds(*file, std::string(box))) << box;
  // Each slice is there, behind its length instead of a start code.
  std::size_t slices = 0;
  for (const EncodedFrame& frame : frames)
    for (const Nal& nal : nalsOf(readStamp(frame.bytes)->packet)) {
      if (nal.type() != NalType::Slice && nal.type() != NalType::IdrSlice) continue;
      const auto size = static_cast<std::uint32_t>(nal.bytes.size());
      std::vector<std::uint8_t> unit = {
          static_cast<std::uint8_t>(size >> 24U), static_cast<std::uint8_t>(size >> 16U),
          static_cast<std::uint8_t>(size >> 8U), static_cast<std::uint8_t>(size)};
      unit.insert(unit.end(), nal.bytes.begin(), nal.bytes.end());
      EXPECT_TRUE(holds(*file, unit));
      ++slices;
    }
  EXPECT_GE(slices, 3u);
  EXPECT_FALSE(writer->finish()) << "it is finished";
}

TEST(Mp4Writer, RefusesWhatNoPlayerCouldBeginWith) {
  const auto frames = coded(2);
  auto empty = Mp4Writer::create(96, 64, 60.0);
  EXPECT_FALSE(empty->finish());
  auto late = Mp4Writer::create(96, 64, 60.0);
  const auto refused = late->add(frames[1]);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("I-frame"), std::string::npos);
  EncodedFrame cut = frames[0];
  cut.bytes.resize(cut.bytes.size() / 2);
  EXPECT_FALSE(late->add(cut));
}

}  // namespace
}  // namespace tessera
