// What the GPU makes of textures and of planes is, byte by byte, what the CPU does.
#include <chrono>
#include <thread>

#include "engine/yuv/packer.hpp"
#include "engine/yuv/unpacker.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using Planes = test::GlTest;

Image noise(int width, int height, std::uint32_t seed) {
  Image image{width, height, {}};
  image.pixels.resize(std::size_t{4} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (std::uint8_t& value : image.pixels) {
    seed = seed * 1664525u + 1013904223u;
    value = static_cast<std::uint8_t>(seed >> 24u);
  }
  return image;
}

gl::Texture textureOf(const Image& image, GLenum format = GL_RGBA8) {
  gl::Texture texture(format, image.width, image.height);
  texture.upload(0, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());
  return texture;
}

/// The first plane and place at which they differ; empty where they do not.
std::string difference(const YuvView& a, const YuvView& b) {
  if (a.width != b.width || a.height != b.height || a.chroma != b.chroma) return "another size";
  for (int plane = 0; plane < 3; ++plane)
    for (int y = 0; y < a.planeHeight(plane); ++y)
      for (int x = 0; x < a.planeWidth(plane); ++x) {
        const auto i = static_cast<std::size_t>(plane);
        const int left = a.at(i, x, y);
        const int right = b.at(i, x, y);
        if (left != right) return fmt::format("plane {} at ({}, {}): {} and {}", plane, x, y, left, right);
      }
  return {};
}

// Sizes that fill no word, no thread and no group, and one that fills all.
const std::pair<int, int> kSizes[] = {{1, 1}, {2, 3}, {9, 5}, {33, 18}, {130, 67}, {256, 64}};

TEST_F(Planes, PackingIsWhatTheProcessorGives) {
  for (const Chroma chroma : {Chroma::Yuv444, Chroma::Yuv420})
    for (const auto& [width, height] : kSizes) {
      const Image image = noise(width, height, static_cast<std::uint32_t>(width * 31 + height));
      auto packer = YuvPacker::create(test::context(), width, height, chroma);
      ASSERT_TRUE(packer) << packer.error().message;
      EXPECT_FALSE(packer->read());
      ASSERT_TRUE(packer->pack(textureOf(image), 4000000000u));
      const auto read = packer->read();
      ASSERT_TRUE(read);
      EXPECT_EQ(read->frame, 4000000000u);
      const auto wanted = toYuv(image, chroma);
      ASSERT_TRUE(wanted);
      EXPECT_EQ(difference(read->planes.view(), wanted->view()), "")
          << width << " x " << height << ", " << nameOf(chroma);
    }
}

TEST_F(Planes, EveryColourIsPackedAndUnpackedAsOnTheProcessor) {
  // All 2^24, 16 reds at a time.
  auto packer = YuvPacker::create(test::context(), 1024, 1024, Chroma::Yuv444);
  auto unpacker = YuvUnpacker::create(test::context());
  ASSERT_TRUE(packer && unpacker);
  Image image{1024, 1024, std::vector<std::uint8_t>(std::size_t{4} << 20u)};
  for (std::uint32_t part = 0; part < 16; ++part) {
    for (std::uint32_t i = 0; i < (1u << 20u); ++i) {
      const std::uint32_t color = part << 20u | i;
      std::uint8_t* to = image.pixels.data() + std::size_t{4} * i;
      for (std::uint32_t k = 0; k < 3; ++k) to[k] = static_cast<std::uint8_t>(color >> (8u * (2u - k)));
      to[3] = static_cast<std::uint8_t>(i);
    }
    ASSERT_TRUE(packer->pack(textureOf(image), part));
    const auto read = packer->read();
    const auto wanted = toYuv(image, Chroma::Yuv444);
    ASSERT_TRUE(read && wanted);
    ASSERT_EQ(read->planes.bytes, wanted->bytes) << "part " << part;
    ASSERT_TRUE(unpacker->unpack(wanted->view()));
    const auto back = toRgb(wanted->view());
    ASSERT_TRUE(back);
    ASSERT_EQ(gl::readTexture(unpacker->encoded(), GL_RGBA, GL_UNSIGNED_BYTE, 4), back->pixels)
        << "part " << part;
  }
}

TEST_F(Planes, UnpackingIsWhatTheProcessorGivesAtAnySize) {
  auto unpacker = YuvUnpacker::create(test::context());
  ASSERT_TRUE(unpacker) << unpacker.error().message;
  EXPECT_FALSE(unpacker->texture());
  // From large to small and back: memory is kept, sizes are not.
  for (const auto& [width, height] :
       {std::pair{256, 64}, std::pair{9, 5}, std::pair{1, 1}, std::pair{130, 67}})
    for (const Chroma chroma : {Chroma::Yuv444, Chroma::Yuv420}) {
      // Any values, also those that no colour has, with rows further apart than they need be.
      YuvImage yuv(width, height, chroma);
      std::uint32_t seed = 5;
      for (std::uint8_t& value : yuv.bytes)
        value = static_cast<std::uint8_t>((seed = seed * 1664525u + 77u) >> 24u);
      YuvView planes = yuv.view();
      std::array<std::vector<std::uint8_t>, 3> apart;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t stride = planes.strides[i] + 13;
        const auto rows = static_cast<std::size_t>(planes.planeHeight(static_cast<int>(i)));
        apart[i].resize(stride * rows, 99);
        for (std::size_t y = 0; y < rows; ++y)
          std::copy_n(planes.planes[i] + y * planes.strides[i], planes.planeWidth(static_cast<int>(i)),
                      apart[i].begin() + static_cast<std::ptrdiff_t>(y * stride));
        planes.planes[i] = apart[i].data();
        planes.strides[i] = stride;
      }
      ASSERT_TRUE(unpacker->unpack(planes));
      const auto wanted = toRgb(planes);
      ASSERT_TRUE(wanted);
      EXPECT_EQ(unpacker->texture().width(), width);
      EXPECT_EQ(gl::readTexture(unpacker->encoded(), GL_RGBA, GL_UNSIGNED_BYTE, 4), wanted->pixels)
          << width << " x " << height << ", " << nameOf(chroma);
    }
  const auto pixels = gl::readTexture(unpacker->encoded(), GL_RGBA, GL_UNSIGNED_BYTE, 4);
  EXPECT_FALSE(unpacker->unpack(YuvView{}));
  EXPECT_EQ(gl::readTexture(unpacker->encoded(), GL_RGBA, GL_UNSIGNED_BYTE, 4), pixels)
      << "and nothing changed";
}

TEST_F(Planes, FramesArriveWithTheirNumbersWithoutAWait) {
  constexpr int kWidth = 64;
  constexpr int kHeight = 32;
  auto packer = YuvPacker::create(test::context(), kWidth, kHeight, Chroma::Yuv420, 2);
  ASSERT_TRUE(packer);
  EXPECT_FALSE(packer->latest());
  std::optional<std::uint32_t> newest;
  std::size_t arrived = 0;
  for (std::uint32_t frame = 1; frame <= 40; ++frame) {
    ASSERT_TRUE(packer->pack(textureOf(noise(kWidth, kHeight, frame)), frame));
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    std::optional<YuvPacker::Packed> packed;
    // A driver may take its time; what has arrived is whole and of its own number.
    do {
      packed = packer->latest();
      if (!packed || packed->frame != frame) std::this_thread::yield();
    } while ((!packed || packed->frame != frame) && std::chrono::steady_clock::now() < deadline);
    ASSERT_TRUE(packed);
    EXPECT_TRUE(!newest || packed->frame > *newest);
    newest = packed->frame;
    ++arrived;
    const auto wanted = toYuv(noise(kWidth, kHeight, packed->frame), Chroma::Yuv420);
    ASSERT_TRUE(wanted);
    EXPECT_EQ(difference(packed->planes, wanted->view()), "") << "frame " << packed->frame;
  }
  EXPECT_EQ(arrived, 40u);
}

TEST_F(Planes, WhatDoesNotFitIsRefused) {
  auto packer = YuvPacker::create(test::context(), 16, 8, Chroma::Yuv420);
  ASSERT_TRUE(packer);
  const auto size = packer->pack(textureOf(noise(16, 16, 1)), 1);
  ASSERT_FALSE(size);
  EXPECT_NE(size.error().message.find("16 x 16"), std::string::npos) << size.error().message;
  // Sampling would decode it, and planes would hold linear colours.
  EXPECT_FALSE(packer->pack(textureOf(noise(16, 8, 1), GL_SRGB8_ALPHA8), 1));
  EXPECT_TRUE(packer->pack(textureOf(noise(16, 8, 1), GL_SRGB8_ALPHA8).view(GL_RGBA8), 1));
  EXPECT_FALSE(YuvPacker::create(test::context(), 0, 8, Chroma::Yuv420));
  EXPECT_FALSE(YuvPacker::create(test::context(), 8, kMaxImageSide + 1, Chroma::Yuv420));
  EXPECT_FALSE(YuvPacker::create(test::context(), 8, 8, Chroma::Yuv420, 1));
}

}  // namespace
}  // namespace tessera
