// The encoder: which one is taken, what it refuses, and what comes of one frame.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "codec/frame_planes.hpp"
#include "tests/codec/moving_picture.hpp"

namespace tessera {
namespace {

EncoderOptions small(Chroma chroma = Chroma::Yuv420) {
  EncoderOptions options;
  options.width = 96;
  options.height = 64;
  options.chroma = chroma;
  options.rate = RateControl::ConstantQuality;
  options.quality = 18.0;
  options.encoders = {"libx264"};
  options.threads = 1;
  return options;
}

TEST(VideoEncoder, TakesTheFirstThatOpensAndSaysWhyOthersDidNot) {
  EncoderOptions options = small();
  options.encoders = {"no_such_encoder", "mpeg4", "libx264"};
  const auto encoder = VideoEncoder::create(options);
  ASSERT_TRUE(encoder) << encoder.error().message;
  EXPECT_EQ(encoder->name(), "libx264");
  EXPECT_TRUE(encoder->takesRegions());

  options.encoders = {"no_such_encoder", "mpeg4", "h264_v4l2m2m"};
  options.chroma = Chroma::Yuv444;
  const auto none = VideoEncoder::create(options);
  ASSERT_FALSE(none);
  const std::string& message = none.error().message;
  EXPECT_NE(message.find("96 x 64, 4:4:4"), std::string::npos) << message;
  EXPECT_NE(message.find("no_such_encoder: this libavcodec has no such encoder"), std::string::npos)
      << message;
  EXPECT_NE(message.find("mpeg4: it encodes mpeg4, not H.264"), std::string::npos) << message;
  EXPECT_NE(message.find("h264_v4l2m2m: "), std::string::npos) << message;
}

TEST(VideoEncoder, SomeEncoderOpensWithoutANameGiven) {
  EncoderOptions options = small();
  options.encoders.clear();
  const auto encoder = VideoEncoder::create(options);
  ASSERT_TRUE(encoder) << encoder.error().message;
  const auto& names = defaultEncoders();
  EXPECT_NE(std::find(names.begin(), names.end(), encoder->name()), names.end());
  std::printf("encoder: %s\n", encoder->name().c_str());
}

TEST(VideoEncoder, OptionsOutOfRangeAreNamed) {
  const auto refused = [](auto change, const std::string& what) {
    EncoderOptions options = small();
    change(options);
    const auto encoder = VideoEncoder::create(options);
    ASSERT_FALSE(encoder) << what;
    EXPECT_NE(encoder.error().message.find(what), std::string::npos) << encoder.error().message;
  };
  refused([](EncoderOptions& o) { o.width = 15; }, "width 15");
  refused([](EncoderOptions& o) { o.height = 16386; }, "height 16386");
  refused([](EncoderOptions& o) { o.width = 97; }, "width 97 is odd");
  refused([](EncoderOptions& o) { o.framesPerSecond = 0.0; }, "0 frames a second");
  refused([](EncoderOptions& o) { o.framesPerSecond = std::nan(""); }, "nan frames a second");
  refused([](EncoderOptions& o) { o.quality = 51.5; }, "quality 51.5");
  refused([](EncoderOptions& o) { o.quality = std::nan(""); }, "quality nan");
  refused([](EncoderOptions& o) { o.iFrameInterval = -1; }, "every -1 frames");
  refused([](EncoderOptions& o) { o.threads = 65; }, "65 threads");
  refused([](EncoderOptions& o) { o.preset = "no_such_preset"; }, "libx264: it does not open");
  const auto rate = [](EncoderOptions& o) { o.rate = RateControl::Bitrate; };
  refused([&](EncoderOptions& o) { rate(o), o.bitrate = 9999; }, "bitrate 9999");
  refused([&](EncoderOptions& o) { rate(o), o.bufferSeconds = 0.0; }, "a buffer of 0 s");
  EncoderOptions odd = small(Chroma::Yuv444);
  odd.width = 97;
  EXPECT_TRUE(VideoEncoder::create(odd)) << "4:4:4 may be odd";
}

TEST(VideoEncoder, FramesThatDoNotFitAreNamedAndTheNextIsAnIFrame) {
  const EncoderOptions options = small();
  auto encoder = VideoEncoder::create(options);
  ASSERT_TRUE(encoder);
  const YuvImage good = test::movingPlanes(96, 64, Chroma::Yuv420, 0);
  ASSERT_TRUE(encoder->encode(good.view(), 7));
  const auto refused = [&](const YuvView& planes, std::uint64_t frame, std::vector<Region> regions,
                           const std::string& what) {
    const auto result = encoder->encode(planes, frame, {.iFrame = false, .regions = regions});
    ASSERT_FALSE(result) << what;
    EXPECT_NE(result.error().message.find(what), std::string::npos) << result.error().message;
  };
  refused(YuvImage(64, 96, Chroma::Yuv420).view(), 8, {}, "frame 8: planes of 64 x 96");
  refused(YuvImage(96, 64, Chroma::Yuv444).view(), 8, {}, "planes of 96 x 64, 4:4:4");
  refused(good.view(), 7, {}, "frame 7: comes after frame 7");
  refused(good.view(), 6, {}, "frame 6: comes after frame 7");
  YuvView missing = good.view();
  missing.planes[1] = nullptr;
  refused(missing, 8, {}, "plane 1");
  refused(good.view(), 8, {{90, 0, 7, 1, 1.0}}, "region 0: 7 x 1 texels at (90, 0)");
  refused(good.view(), 8, {{0, 0, 8, 8, 2.0}, {0, -1, 8, 8, 2.0}}, "region 1");
  refused(good.view(), 8, {{0, 0, 8, 2147483647, 2.0}}, "region 0");
  refused(good.view(), 8, {{0, 0, 8, 8, 0.0}}, "importance 0");
  refused(good.view(), 8, {{0, 0, 8, 8, std::nan("")}}, "importance nan");
  // None of these reached the encoder.
  const auto next = encoder->encode(good.view(), 9);
  ASSERT_TRUE(next);
  EXPECT_FALSE(next->iFrame());
  EXPECT_EQ(next->reference, 7u);
}

TEST(VideoEncoder, IFramesComeAtTheIntervalAndOnDemand) {
  EncoderOptions options = small();
  options.iFrameInterval = 4;
  auto encoder = VideoEncoder::create(options);
  ASSERT_TRUE(encoder);
  std::string kinds;
  std::uint64_t before = 0;
  for (int i = 0; i < 16; ++i) {
    const YuvImage planes = test::movingPlanes(96, 64, Chroma::Yuv420, i);
    const auto frame =
        encoder->encode(planes.view(), static_cast<std::uint64_t>(10 + 3 * i), {.iFrame = i == 6 || i == 7});
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->frame, static_cast<std::uint64_t>(10 + 3 * i));
    EXPECT_EQ(frame->reference, frame->iFrame() ? frame->frame : before);
    EXPECT_GE(frame->milliseconds, 0.0);
    before = frame->frame;
    kinds += frame->iFrame() ? 'I' : 'P';
  }
  EXPECT_EQ(kinds, "IPPPIPIIPPPIPPPI");

  // A picture that changes altogether is no reason for one.
  options.iFrameInterval = 0;
  auto rare = VideoEncoder::create(options);
  ASSERT_TRUE(rare);
  std::string rareKinds;
  for (int i = 0; i < 300; ++i) {
    const YuvImage planes = test::movingPlanes(96, 64, Chroma::Yuv420, i * (i % 50 == 49 ? 31 : 1));
    const auto frame = rare->encode(planes.view(), static_cast<std::uint64_t>(i));
    ASSERT_TRUE(frame);
    rareKinds += frame->iFrame() ? 'I' : 'P';
  }
  EXPECT_EQ(rareKinds, "I" + std::string(299, 'P'));
}

TEST(VideoEncoder, BitrateHoldsAndQualityIsWhatIsAskedFor) {
  EncoderOptions options = small();
  options.width = 320;
  options.height = 192;
  options.rate = RateControl::Bitrate;
  options.iFrameInterval = 10;
  // Noise needs far more bits than it gets.
  YuvImage planes(options.width, options.height, options.chroma);
  std::uint32_t seed = 1;
  const auto shuffle = [&] {
    for (std::uint8_t& value : planes.bytes)
      value = static_cast<std::uint8_t>((seed = seed * 1664525u + 7u) >> 25u);
  };
  for (const std::int64_t bitrate : {400'000, 1'600'000}) {
    options.bitrate = bitrate;
    auto encoder = VideoEncoder::create(options);
    ASSERT_TRUE(encoder);
    double bytes = 0.0;
    for (std::uint64_t i = 0; i < 60; ++i) {
      shuffle();
      const auto frame = encoder->encode(planes.view(), i);
      ASSERT_TRUE(frame);
      bytes += static_cast<double>(frame->bytes.size());
    }
    const double rate = bytes * 8.0 / (60.0 / options.framesPerSecond) / static_cast<double>(bitrate);
    std::printf("bitrate %lld: %.3f of it\n", static_cast<long long>(bitrate), rate);
    EXPECT_GT(rate, 0.85);
    // What the buffer lets through at once, over the two seconds, and one frame.
    EXPECT_LT(rate, 1.0 + options.bufferSeconds / 2.0 + 0.02);
  }

  options = small();
  double before = 0.0;
  for (const double quality : {40.0, 25.0, 10.0}) {
    options.quality = quality;
    auto encoder = VideoEncoder::create(options);
    auto decoder = VideoDecoder::create();
    ASSERT_TRUE(encoder && decoder);
    double psnr = 0.0;
    for (int i = 0; i < 5; ++i) {
      const YuvImage moving = test::movingPlanes(96, 64, Chroma::Yuv420, i);
      const auto frame = encoder->encode(moving.view(), static_cast<std::uint64_t>(i));
      ASSERT_TRUE(frame);
      const Decoded decoded = decoder->decode(frame->bytes);
      ASSERT_TRUE(decoded.picture) << decoded.detail;
      psnr = test::planesPsnr(moving.view(), *decoded.picture);
    }
    EXPECT_GT(psnr, before + 3.0) << "quality " << quality;
    before = psnr;
  }
  EXPECT_GT(before, 45.0);
}

TEST(VideoEncoder, RegionsThatCountMoreAreBetter) {
  EncoderOptions options = small();
  options.width = 256;
  options.height = 128;
  options.quality = 30.0;
  // The same noise on both halves, so that only the region tells them apart.
  Image image{256, 128, std::vector<std::uint8_t>(std::size_t{4} * 256 * 128)};
  std::uint32_t seed = 3;
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x)
      for (int i = 0; i < 4; ++i)
        image.at(x, y)[i] = image.at(x + 128, y)[i] =
            static_cast<std::uint8_t>((seed = seed * 1664525u + 7u) >> 26u);
  const auto planes = toYuv(image, Chroma::Yuv420);
  ASSERT_TRUE(planes);
  const auto errorsOf = [&](std::span<const Region> regions, double& left, double& right) {
    auto encoder = VideoEncoder::create(options);
    auto decoder = VideoDecoder::create();
    ASSERT_TRUE(encoder && decoder);
    const auto frame = encoder->encode(planes->view(), 1, {.iFrame = false, .regions = regions});
    ASSERT_TRUE(frame) << frame.error().message;
    const Decoded decoded = decoder->decode(frame->bytes);
    ASSERT_TRUE(decoded.picture) << decoded.detail;
    left = right = 0.0;
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 256; ++x) {
        const double d = static_cast<double>(planes->view().at(0, x, y)) - decoded.picture->at(0, x, y);
        (x < 128 ? left : right) += d * d / (128.0 * 128.0);
      }
  };
  double left = 0.0;
  double right = 0.0;
  errorsOf({}, left, right);
  EXPECT_NEAR(left / right, 1.0, 0.1);
  const double even = left;
  const Region more[] = {{0, 0, 128, 128, 4.0}};
  errorsOf(more, left, right);
  std::printf("squared error %.2f; left counts four times: %.2f and %.2f\n", even, left, right);
  EXPECT_LT(left, 0.55 * right);
  EXPECT_LT(left, even);
  // Of two that overlap, the first holds.
  const Region both[] = {{128, 0, 128, 128, 4.0}, {0, 0, 256, 128, 0.25}};
  errorsOf(both, left, right);
  EXPECT_LT(right, 0.25 * left);
}

TEST(VideoEncoder, PlanesGoIntoInterleavedFramesToo) {
  const YuvImage planes = test::movingPlanes(20, 6, Chroma::Yuv420, 2);
  libav::Owned<AVFrame> frame(av_frame_alloc());
  frame->format = AV_PIX_FMT_NV12;
  frame->width = 20;
  frame->height = 6;
  ASSERT_GE(av_frame_get_buffer(frame.get(), 0), 0);
  copyPlanes(planes.view(), *frame);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 20; ++x)
      ASSERT_EQ(frame->data[0][y * frame->linesize[0] + x], planes.view().at(0, x, y));
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 20; ++x)
      ASSERT_EQ(frame->data[1][y * frame->linesize[1] + x], planes.view().at(x % 2 == 0 ? 1 : 2, x / 2, y));
}

}  // namespace
}  // namespace tessera
