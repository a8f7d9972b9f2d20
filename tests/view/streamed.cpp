#include "tests/view/streamed.hpp"

#include <gtest/gtest.h>

#include "codec/video.hpp"
#include "engine/measure/metrics.hpp"
#include "engine/stream/feed.hpp"
#include "engine/yuv/packer.hpp"
#include "tests/gl_test.hpp"

namespace tessera::test {

namespace {

/// Through H.264, with little loss.
YuvImage coded(const YuvImage& planes) {
  EncoderOptions options;
  options.width = planes.width;
  options.height = planes.height;
  options.chroma = planes.chroma;
  options.rate = RateControl::ConstantQuality;
  options.quality = 12.0;
  options.encoders = {"libx264"};
  auto encoder = VideoEncoder::create(options);
  auto decoder = VideoDecoder::create();
  if (!encoder || !decoder) {
    ADD_FAILURE() << (encoder ? decoder.error().message : encoder.error().message);
    return planes;
  }
  const auto packet = encoder->encode(planes.view(), 1);
  if (!packet) {
    ADD_FAILURE() << packet.error().message;
    return planes;
  }
  const Decoded decoded = decoder->decode(packet->bytes);
  if (!decoded.picture) {
    ADD_FAILURE() << decoded.detail;
    return planes;
  }
  auto rgb = toRgb(*decoded.picture);
  return std::move(*toYuv(*rgb, planes.chroma));
}

}  // namespace

double psnrOf(const Image& engine, const Image& viewer) {
  const auto value = psnr(engine, viewer);
  if (!value) ADD_FAILURE() << value.error().message;
  return value.value_or(0.0);
}

Streamed streamed(Scene scene, GathererKind gatherer, const View& shaded,
                  const view::DisplayOptions& displayOptions) {
  EngineOptions options;
  options.gatherer = gatherer;
  options.request = {.rect = true, .lens = true, .blended = true};
  options.atlas.memory.width = options.atlas.memory.height = 1024;
  // Before the engine takes the scene, which keeps no pixels.
  auto masks = std::make_shared<const std::vector<wire::MaskImage>>(masksOf(scene));
  auto engine = Engine::create(context(), std::move(scene), std::nullopt, options);
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return {};
  }
  Streamed result{std::move(*engine), std::nullopt};
  Engine& e = *result.engine;
  e.update(0.0);
  e.findVisible({&shaded, 1});
  if (auto placed = e.place({&shaded, 1}); !placed) ADD_FAILURE() << placed.error().message;
  e.shade(shaded);

  const GeometryFeed feed(e);
  wire::VisibleDelta delta(feed.source());
  const auto elements = feed.visible(e);
  const auto objects = feed.objects(e);
  const wire::Camera camera = cameraOf(shaded);
  const auto message = delta.next({elements, objects, {}, wire::boundOf(camera, 0.01, 0.0), camera.eye});
  const gl::Texture& atlas = e.gatherer()->atlas().encoded;
  auto packer = YuvPacker::create(context(), atlas.width(), atlas.height(), Chroma::Yuv444);
  if (!packer || !packer->pack(atlas, 1)) {
    ADD_FAILURE() << "the atlas gives no planes";
    return result;
  }
  const YuvImage planes = packer->read()->planes;
  view::ShadedFrame frame;
  frame.atlas = coded(planes);
  frame.header.camera = camera;
  wire::VisibleMirror mirror(feed.source().method, {static_cast<std::uint32_t>(planes.width),
                                                    static_cast<std::uint32_t>(planes.height)});
  if (auto applied = mirror.apply(message); !applied) ADD_FAILURE() << applied.error().message;
  frame.masks = std::move(masks);
  frame.take(mirror);

  auto display = view::StreamedDisplay::create(context(), displayOptions);
  if (!display) {
    ADD_FAILURE() << display.error().message;
    return result;
  }
  if (auto uploaded = display->upload(frame); !uploaded) ADD_FAILURE() << uploaded.error().message;
  result.display.emplace(std::move(*display));
  return result;
}

}  // namespace tessera::test
