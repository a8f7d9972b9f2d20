// The decoder: pictures at once and whole, and after whatever a network does to packets either the right
// picture or the reason why there is none.
#include <algorithm>

#include <gtest/gtest.h>

#include "tests/codec/moving_picture.hpp"

namespace tessera {
namespace {

constexpr int kWidth = 96;
constexpr int kHeight = 64;

EncoderOptions small() {
  EncoderOptions options;
  options.width = kWidth;
  options.height = kHeight;
  options.rate = RateControl::ConstantQuality;
  options.quality = 20.0;
  options.iFrameInterval = 5;
  options.encoders = {"libx264"};
  options.threads = 2;
  return options;
}

VideoDecoder makeDecoder(const DecoderOptions& options = {}) {
  auto decoder = VideoDecoder::create(options);
  if (!decoder) ADD_FAILURE() << decoder.error().message;
  return std::move(*decoder);
}

std::vector<EncodedFrame> makeStream(const EncoderOptions& options, int frames) {
  auto encoder = VideoEncoder::create(options);
  if (!encoder) {
    ADD_FAILURE() << encoder.error().message;
    return {};
  }
  return test::encodeMoving(*encoder, options, frames);
}

/// What each packet decodes to when none is missing.
std::vector<YuvImage> cleanPictures(const std::vector<EncodedFrame>& stream) {
  VideoDecoder decoder = makeDecoder();
  std::vector<YuvImage> pictures;
  for (const EncodedFrame& frame : stream) {
    const Decoded decoded = decoder.decode(frame.bytes);
    if (!decoded.picture) {
      ADD_FAILURE() << decoded.detail;
      return {};
    }
    pictures.push_back(test::copyOf(*decoded.picture));
  }
  return pictures;
}

TEST(VideoDecoder, OnePacketInOnePictureOutAtAnySize) {
  // Also sizes that are no multiples of a macroblock's 16 texels, and threads on either side.
  const std::pair<int, int> sizes[] = {{96, 64}, {50, 38}, {16, 16}, {130, 18}};
  for (const Chroma chroma : {Chroma::Yuv420, Chroma::Yuv444})
    for (const auto& [width, height] : sizes)
      for (const int threads : {1, 2}) {
        EncoderOptions options = small();
        options.width = width;
        options.height = height;
        options.chroma = chroma;
        options.threads = threads;
        auto encoder = VideoEncoder::create(options);
        ASSERT_TRUE(encoder) << encoder.error().message;
        VideoDecoder decoder = makeDecoder({.threads = threads});
        EXPECT_EQ(decoder.status(), NoPicture::NoVideoYet);
        for (int i = 0; i < 12; ++i) {
          const YuvImage planes = test::movingPlanes(width, height, chroma, i);
          const auto number = static_cast<std::uint64_t>(100 + 7 * i);
          const auto frame = encoder->encode(planes.view(), number);
          ASSERT_TRUE(frame) << frame.error().message;
          const Decoded decoded = decoder.decode(frame->bytes);
          ASSERT_TRUE(decoded.picture) << decoded.detail;
          EXPECT_EQ(decoded.frame, number);
          EXPECT_EQ(decoded.iFrame, i % 5 == 0);
          EXPECT_FALSE(decoded.wantsIFrame);
          EXPECT_EQ(decoder.status(), NoPicture::None);
          ASSERT_EQ(decoded.picture->width, width);
          ASSERT_EQ(decoded.picture->height, height);
          ASSERT_EQ(decoded.picture->chroma, chroma);
          // A macroblock alone is mostly the speck that moves.
          EXPECT_GT(test::planesPsnr(planes.view(), *decoded.picture), width == 16 ? 30.0 : 38.0)
              << width << " x " << height << ", " << nameOf(chroma) << ", frame " << i;
        }
      }
}

TEST(VideoDecoder, AnOddSizeNeedsFullChroma) {
  EncoderOptions options = small();
  options.width = 51;
  options.height = 37;
  options.chroma = Chroma::Yuv444;
  const auto stream = makeStream(options, 3);
  ASSERT_EQ(stream.size(), 3u);
  const auto pictures = cleanPictures(stream);
  ASSERT_EQ(pictures.size(), 3u);
  EXPECT_EQ(pictures[2].width, 51);
  EXPECT_EQ(pictures[2].height, 37);
}

TEST(VideoDecoder, AfterALossNothingIsShownUntilTheNextIFrame) {
  const auto stream = makeStream(small(), 15);
  const auto clean = cleanPictures(stream);
  ASSERT_EQ(clean.size(), 15u);
  for (std::size_t lost = 0; lost < 10; ++lost) {
    VideoDecoder decoder = makeDecoder();
    for (std::size_t i = 0; i < stream.size(); ++i) {
      if (i == lost) continue;
      const Decoded decoded = decoder.decode(stream[i].bytes);
      const std::size_t heals = (lost / 5 + 1) * 5;
      if (i < lost || i >= heals) {
        ASSERT_TRUE(decoded.picture) << decoded.detail;
        // Exactly the picture of who lost nothing.
        EXPECT_EQ(test::copyOf(*decoded.picture).bytes, clean[i].bytes) << "lost " << lost << ", at " << i;
        continue;
      }
      EXPECT_FALSE(decoded.picture);
      EXPECT_TRUE(decoded.wantsIFrame);
      EXPECT_EQ(decoded.frame, stream[i].frame);
      const bool first = i == lost + 1 && lost > 0;
      EXPECT_EQ(decoded.reason, first ? NoPicture::FrameLost : NoPicture::WaitingForIFrame);
      EXPECT_EQ(decoder.status(), decoded.reason);
      EXPECT_NE(decoded.detail.find(fmt::format("frame {}: builds on frame {}", i + 1, i)), std::string::npos)
          << decoded.detail;
    }
  }
}

TEST(VideoDecoder, LossIsSeenAlsoWhereTheStreamsOwnCountWrapped) {
  // H.264 counts frames to 16 here: with 16 lost the next one seems to follow.
  EncoderOptions options = small();
  options.iFrameInterval = 0;
  const auto stream = makeStream(options, 40);
  ASSERT_EQ(stream.size(), 40u);
  VideoDecoder decoder = makeDecoder();
  for (std::size_t i = 0; i < 5; ++i) ASSERT_TRUE(decoder.decode(stream[i].bytes).picture);
  for (std::size_t i = 21; i < 40; ++i) EXPECT_FALSE(decoder.decode(stream[i].bytes).picture);
}

TEST(VideoDecoder, AForcedIFrameHealsAtOnce) {
  const EncoderOptions options = small();
  auto encoder = VideoEncoder::create(options);
  ASSERT_TRUE(encoder);
  VideoDecoder decoder = makeDecoder();
  bool ask = false;
  for (int i = 0; i < 8; ++i) {
    const YuvImage planes = test::movingPlanes(kWidth, kHeight, Chroma::Yuv420, i);
    const auto frame = encoder->encode(planes.view(), static_cast<std::uint64_t>(i), {.iFrame = ask});
    ASSERT_TRUE(frame);
    if (i == 1) continue;  // lost
    const Decoded decoded = decoder.decode(frame->bytes);
    ask = decoded.wantsIFrame;
    EXPECT_EQ(decoded.picture.has_value(), i != 2) << i;
    EXPECT_EQ(ask, i == 2) << i;
  }
}

TEST(VideoDecoder, DamageGivesNoPictureAndNoneThatBuildsOnIt) {
  const auto stream = makeStream(small(), 10);
  const auto clean = cleanPictures(stream);
  ASSERT_EQ(clean.size(), 10u);
  std::uint32_t seed = 11;
  const auto next = [&](std::size_t limit) {
    seed = seed * 1664525u + 1013904223u;
    return static_cast<std::size_t>(seed >> 8u) % limit;
  };
  for (int round = 0; round < 200; ++round) {
    VideoDecoder decoder = makeDecoder();
    const std::size_t victim = next(10);
    auto bytes = stream[victim].bytes;
    switch (round % 4) {
      case 0:
        bytes[next(bytes.size())] ^= static_cast<std::uint8_t>(1U << next(8));
        break;
      case 1:
        bytes.resize(next(bytes.size()));
        break;
      case 2: {
        const std::size_t from = next(bytes.size() - 1);
        bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(from),
                    bytes.begin() + static_cast<std::ptrdiff_t>(from + 1 + next(bytes.size() - from)));
        break;
      }
      default:
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(next(bytes.size() + 1)), 1 + next(40),
                     static_cast<std::uint8_t>(next(256)));
    }
    for (std::size_t i = 0; i < stream.size(); ++i) {
      const Decoded decoded = decoder.decode(i == victim ? bytes : stream[i].bytes);
      const bool broken = i >= victim && i < (victim == 5 || victim == 0 ? victim + 5 : (victim / 5 + 1) * 5);
      ASSERT_EQ(decoded.picture.has_value(), !broken)
          << "round " << round << ", frame " << i << decoded.detail;
      if (decoded.picture) {
        ASSERT_EQ(test::copyOf(*decoded.picture).bytes, clean[i].bytes);
      }
      if (i == victim) {
        EXPECT_EQ(decoded.reason, NoPicture::Damaged);
        EXPECT_FALSE(decoded.detail.empty());
      } else if (broken) {
        EXPECT_EQ(decoded.reason, NoPicture::WaitingForIFrame);
      }
    }
  }
}

TEST(VideoDecoder, DamageUnderARightChecksumIsNoCrash) {
  // As of a sender that is broken, or hostile.
  const auto stream = makeStream(small(), 10);
  ASSERT_EQ(stream.size(), 10u);
  std::uint32_t seed = 5;
  const auto next = [&](std::size_t limit) {
    seed = seed * 1664525u + 1013904223u;
    return static_cast<std::size_t>(seed >> 8u) % limit;
  };
  std::size_t failed = 0;
  for (int round = 0; round < 300; ++round) {
    VideoDecoder decoder = makeDecoder({.threads = 1 + round % 2, .maxPixels = std::size_t{1} << 20u});
    for (const EncodedFrame& frame : stream) {
      const auto inner = readStamp(frame.bytes);
      ASSERT_TRUE(inner);
      std::vector<std::uint8_t> packet(inner->packet.begin(), inner->packet.end());
      if (round % 3 == 0)
        packet.resize(next(packet.size()));
      else
        for (std::size_t i = 0; i < 1 + next(20); ++i)
          packet[next(packet.size())] = static_cast<std::uint8_t>(next(256));
      const Decoded decoded = decoder.decode(stamped(inner->stamp, packet));
      if (decoded.picture) {
        // What is shown can be read to its last byte.
        ASSERT_GT(test::copyOf(*decoded.picture).bytes.size(), 0u);
        ASSERT_EQ(decoded.reason, NoPicture::None);
      } else {
        ASSERT_NE(decoded.reason, NoPicture::None);
        ASSERT_FALSE(decoded.detail.empty());
        failed += decoded.reason == NoPicture::DecodeFailed ? 1 : 0;
      }
    }
    // A good stream after that is shown.
    decoder.reset();
    EXPECT_EQ(decoder.status(), NoPicture::NoVideoYet);
    for (const EncodedFrame& frame : stream) ASSERT_TRUE(decoder.decode(frame.bytes).picture) << round;
  }
  EXPECT_GT(failed, 300u);
}

TEST(VideoDecoder, LateAndRepeatedPacketsChangeNothing) {
  const auto stream = makeStream(small(), 10);
  const auto clean = cleanPictures(stream);
  ASSERT_EQ(clean.size(), 10u);
  VideoDecoder decoder = makeDecoder();
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const Decoded decoded = decoder.decode(stream[i].bytes);
    ASSERT_TRUE(decoded.picture) << decoded.detail;
    EXPECT_EQ(test::copyOf(*decoded.picture).bytes, clean[i].bytes);
    for (const std::size_t again : {i, i / 2, std::size_t{0}}) {
      const Decoded late = decoder.decode(stream[again].bytes);
      EXPECT_FALSE(late.picture);
      EXPECT_EQ(late.reason, NoPicture::Late);
      EXPECT_FALSE(late.wantsIFrame) << "what comes next is not harmed";
    }
  }
  // A stream that begins anew is another one.
  decoder.reset();
  EXPECT_TRUE(decoder.decode(stream[0].bytes).picture);
}

TEST(VideoDecoder, TheSizeAndTheChromaMayChangeAtAnIFrame) {
  VideoDecoder decoder = makeDecoder({.threads = 2});
  std::uint64_t number = 1;
  for (const auto& [width, height, chroma] :
       {std::tuple{96, 64, Chroma::Yuv420}, std::tuple{160, 90, Chroma::Yuv420},
        std::tuple{160, 90, Chroma::Yuv444}, std::tuple{34, 22, Chroma::Yuv420}}) {
    EncoderOptions options = small();
    options.width = width;
    options.height = height;
    options.chroma = chroma;
    auto encoder = VideoEncoder::create(options);
    ASSERT_TRUE(encoder);
    for (int i = 0; i < 3; ++i) {
      const YuvImage planes = test::movingPlanes(width, height, chroma, i);
      const auto frame = encoder->encode(planes.view(), number++);
      ASSERT_TRUE(frame);
      const Decoded decoded = decoder.decode(frame->bytes);
      ASSERT_TRUE(decoded.picture) << decoded.detail;
      ASSERT_EQ(decoded.picture->width, width);
      ASSERT_EQ(decoded.picture->height, height);
      ASSERT_EQ(decoded.picture->chroma, chroma);
      EXPECT_GT(test::planesPsnr(planes.view(), *decoded.picture), 38.0);
    }
  }
}

TEST(VideoDecoder, MorePixelsThanAllowedAreRefused) {
  const auto stream = makeStream(small(), 1);
  ASSERT_EQ(stream.size(), 1u);
  VideoDecoder decoder = makeDecoder({.threads = 1, .maxPixels = 4096});
  const Decoded decoded = decoder.decode(stream[0].bytes);
  EXPECT_FALSE(decoded.picture);
  EXPECT_EQ(decoded.reason, NoPicture::DecodeFailed);
  EXPECT_FALSE(VideoDecoder::create({.threads = 0}));
  EXPECT_FALSE(VideoDecoder::create({.threads = 1, .maxPixels = 255}));
}

TEST(VideoDecoder, WhatIsNoPacketIsDamage) {
  VideoDecoder decoder = makeDecoder();
  const std::vector<std::uint8_t> nothing;
  EXPECT_EQ(decoder.decode(nothing).reason, NoPicture::Damaged);
  // A packet without anything in it, rightly stamped.
  EXPECT_EQ(decoder.decode(stamped({1, 1}, nothing)).reason, NoPicture::DecodeFailed);
  const auto stream = makeStream(small(), 1);
  ASSERT_EQ(stream.size(), 1u);
  // The stream itself, without the stamp.
  const auto inner = readStamp(stream[0].bytes);
  ASSERT_TRUE(inner);
  EXPECT_EQ(decoder.decode(inner->packet).reason, NoPicture::Damaged);
  EXPECT_TRUE(decoder.decode(stream[0].bytes).picture);
}

TEST(VideoDecoder, EveryReasonHasAName) {
  std::vector<std::string> names;
  for (int i = 0; i <= static_cast<int>(NoPicture::WrongColors); ++i)
    names.emplace_back(nameOf(static_cast<NoPicture>(i)));
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::unique(names.begin(), names.end()), names.end());
  EXPECT_EQ(std::count(names.begin(), names.end(), "unknown"), 0);
}

}  // namespace
}  // namespace tessera
