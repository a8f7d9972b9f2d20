// Real atlases through the whole path: shaded, packed into planes on the GPU, encoded, decoded, unpacked into
// a texture, and compared with what was shaded.
#include <cstdio>

#include "codec/video.hpp"
#include "engine/frame/engine.hpp"
#include "engine/measure/metrics.hpp"
#include "engine/scene/gltf.hpp"
#include "engine/scene/stage.hpp"
#include "engine/yuv/packer.hpp"
#include "engine/yuv/unpacker.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using CodecAtlas = test::GlTest;

constexpr int kSide = 512;
constexpr int kFrames = 7;
constexpr int kInterval = 4;

/// The engine on the project's own scene, with a small atlas.
std::unique_ptr<Engine> makeAtrium() {
  const std::string assets = TESSERA_SOURCE_DIR "/assets/";
  auto scene = loadGltf(assets + "atrium.glb");
  auto stage = loadStage(assets + "stages/atrium.json");
  if (!scene || !stage) {
    ADD_FAILURE() << (scene ? stage.error().message : scene.error().message);
    return nullptr;
  }
  EngineOptions options;
  options.atlas.memory.width = options.atlas.memory.height = kSide;
  options.shadowSize = 512;
  auto engine = Engine::create(test::context(), std::move(*scene), std::move(*stage), options);
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return nullptr;
  }
  return std::move(*engine);
}

Image textureImage(const gl::Texture& texture) {
  return {texture.width(), texture.height(), gl::readTexture(texture, GL_RGBA, GL_UNSIGNED_BYTE, 4)};
}

TEST_F(CodecAtlas, ComesBackWithinTheBound) {
  auto engine = makeAtrium();
  ASSERT_TRUE(engine);
  struct Case {
    Chroma chroma;
    double worst;  // dB of any frame, over red, green and blue; measured 37.1 and 37.9
  };
  for (const auto& [chroma, worst] : {Case{Chroma::Yuv420, 36.0}, Case{Chroma::Yuv444, 37.0}}) {
    const gl::Texture& atlas = engine->gatherer()->atlas().encoded;
    ASSERT_TRUE(atlas);
    EncoderOptions options;
    options.width = atlas.width();
    options.height = atlas.height();
    options.chroma = chroma;
    options.rate = RateControl::ConstantQuality;
    options.quality = 20.0;
    options.iFrameInterval = kInterval;
    options.encoders = {"libx264"};
    options.threads = 2;
    auto encoder = VideoEncoder::create(options);
    auto decoder = VideoDecoder::create({.threads = 2});
    auto packer = YuvPacker::create(test::context(), atlas.width(), atlas.height(), chroma);
    auto unpacker = YuvUnpacker::create(test::context());
    ASSERT_TRUE(encoder) << encoder.error().message;
    ASSERT_TRUE(decoder && packer && unpacker);
    double least = 1e9;
    std::size_t iBytes = 0;
    std::size_t pBytes = 0;
    for (std::uint32_t i = 0; i < kFrames; ++i) {
      const double time = 0.04 * i;
      engine->update(time);
      engine->rect(viewOf(sampleCamera(engine->stage()->paths.front(), time), 320, 240, 0.05));
      ASSERT_TRUE(packer->pack(atlas, i));
      const auto packed = packer->read();
      ASSERT_TRUE(packed);
      const auto frame = encoder->encode(packed->planes.view(), packed->frame);
      ASSERT_TRUE(frame) << frame.error().message;
      (frame->iFrame() ? iBytes : pBytes) += frame->bytes.size();
      const Decoded decoded = decoder->decode(frame->bytes);
      ASSERT_TRUE(decoded.picture) << decoded.detail;
      ASSERT_EQ(decoded.frame, i);
      ASSERT_TRUE(unpacker->unpack(*decoded.picture));
      const auto quality = psnr(textureImage(atlas), textureImage(unpacker->encoded()));
      ASSERT_TRUE(quality) << quality.error().message;
      least = std::min(least, *quality);
    }
    const std::size_t iMean = iBytes / 2;
    const std::size_t pMean = pBytes / (kFrames - 2);
    std::printf("%s: at least %.1f dB; I-frames %zu bytes, P-frames %zu\n", nameOf(chroma), least, iMean,
                pMean);
    EXPECT_GT(least, worst);
    // Blocks stay where they are: what changes is little.
    EXPECT_LT(2 * pMean, iMean);
  }
}

}  // namespace
}  // namespace tessera
