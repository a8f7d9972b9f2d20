#include "tests/frame/shading_check.hpp"

#include "engine/frame/engine.hpp"
#include "tests/gl_test.hpp"

namespace tessera::test {

namespace {

// Levels of 8 bits: rounding to the texture, and what drivers' sRGB curves differ by. The atlas rounds twice.
constexpr double kForwardTolerance = 1.5;
constexpr double kAtlasTolerance = 2.5;
// Half pixels around a centre that may speak for it: forward's edges are exact but for the shadow map's
// texels; a texel of the atlas reaches up to two pixels far, and is filtered.
constexpr int kForwardRadius = 1;
constexpr int kAtlasRadius = 4;

}  // namespace

void expectPictures(const Reference& reference, const Scene& scene, const Lighting& lighting,
                    const View& view, const Expected& expected) {
  EngineOptions options;
  options.atlas.memory.width = 1024;
  options.atlas.memory.height = 1024;
  options.atlas.format = expected.format;
  options.splitEdges = 0.0;
  options.shadowSize = expected.shadowSize;
  options.request.displayDeferred = true;
  auto made = Engine::create(context(), scene, stageOf(lighting), options);
  ASSERT_TRUE(made) << made.error().message;
  Engine& engine = **made;
  engine.update(0.0);
  const auto check = [&](const char* how, int radius, double tolerance, double certain) {
    const auto found = compare(engine.readColor(), reference, radius + expected.reach, tolerance);
    EXPECT_GT(found.covered, 300u) << how;
    EXPECT_GE(static_cast<double>(found.tight), certain * static_cast<double>(found.covered))
        << how << ": too few pixels whose colour is certain, of " << found.covered;
    EXPECT_EQ(expected.silhouettes ? found.outside : found.outsideWithin, 0u) << how << found.first;
  };
  engine.forward(view);
  check("forward", kForwardRadius, kForwardTolerance, expected.certain);
  engine.forward(view, true);
  check("forward after a depth pre-pass", kForwardRadius, kForwardTolerance, expected.certain);
  engine.rect(view);
  check("atlas, geometry display", kAtlasRadius, kAtlasTolerance, expected.certainInAtlas);
  engine.display(view, DisplayMode::Deferred);
  check("atlas, deferred display", kAtlasRadius, kAtlasTolerance, expected.certainInAtlas);
}

void expectReference(const Scene& scene, const Lighting& lighting, const View& view,
                     const Expected& expected) {
  expectPictures(trace(scene, lighting, view), scene, lighting, view, expected);
}

LightSample directional(const glm::dvec3& along, const glm::vec3& lux) {
  LightSample light;
  light.type = LightType::Directional;
  light.direction = glm::normalize(along);
  light.radiance = lux;
  return light;
}

LightSample point(const glm::dvec3& position, const glm::vec3& candela) {
  LightSample light;
  light.position = position;
  light.radiance = candela;
  return light;
}

Material dull(const glm::vec3& color) {
  Material material;
  material.baseColorFactor = glm::vec4(color, 1.0f);
  material.metallicFactor = 0.0f;
  material.roughnessFactor = 0.9f;
  return material;
}

std::uint32_t addWall(Scene& scene, std::uint32_t material, const glm::vec3& corner, float side) {
  return addGrid(scene, corner, {side, 0, 0}, {0, side, 0}, 2, 2, material);
}

View wallView(double z) { return lookAt({0.3, 0.2, z}, {0, 0, 0}, 50.0, kWidth, kHeight, 0.05); }

TextureSlot nearest(std::uint32_t image) {
  TextureSlot slot;
  slot.image = image;
  slot.sampler.mag = slot.sampler.min = Filter::Nearest;
  slot.sampler.mip = Mip::None;
  slot.sampler.wrapS = slot.sampler.wrapT = Wrap::Clamp;
  return slot;
}

TextureSlot bumps(Scene& scene) {
  const TextureSlot slot = nearest(addCheckers(scene, 64, 4));
  auto& pixels = scene.images[slot.image].image.pixels;
  for (std::size_t i = 0; i < pixels.size(); i += 4) {
    const bool on = pixels[i] > 128;
    pixels[i] = on ? 180 : 100;
    pixels[i + 1] = on ? 150 : 80;
    pixels[i + 2] = on ? 240 : 230;
  }
  return slot;
}

}  // namespace tessera::test
