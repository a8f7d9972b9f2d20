// Shading against the reference tracer: lights, lobes, textures, sides, emission and shadows, for forward and
// for both displays of the atlas. Two pictures of one engine can be wrong alike; the reference shares no code
// with them.
#include <cmath>
#include <memory>

#include "engine/frame/engine.hpp"
#include "tests/frame/reference.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using Shading = test::GlTest;
using test::Lighting;

constexpr int kWidth = 160;
constexpr int kHeight = 120;

// Levels of 8 bits: rounding to the texture, and what drivers' sRGB curves differ by. The atlas rounds twice.
constexpr double kForwardTolerance = 1.5;
constexpr double kAtlasTolerance = 2.5;
// Half pixels around a centre that may speak for it: forward's edges are exact but for the shadow map's
// texels; a texel of the atlas reaches up to two pixels far, and is filtered.
constexpr int kForwardRadius = 1;
constexpr int kAtlasRadius = 4;

struct Expected {
  // The least share of covered pixels where the reference must allow nothing but one colour, so that it says
  // something.
  double certain = 0.4;
  double certainInAtlas = 0.15;
  int reach = 0;          // half pixels on top of the above
  int shadowSize = 1024;  // texels a side
  AtlasFormat format = AtlasFormat::Srgb8;
  bool silhouettes = true;  // false: pixels beside nothing may have any colour
};

/// Draws the scene in every way there is, and holds each against the reference.
void expectPictures(const test::Reference& reference, const Scene& scene, const Lighting& lighting,
                    const View& view, const Expected& expected = {}) {
  EngineOptions options;
  options.atlas.memory.width = 1024;
  options.atlas.memory.height = 1024;
  options.atlas.format = expected.format;
  options.splitEdges = 0.0;
  options.shadowSize = expected.shadowSize;
  options.request.displayDeferred = true;
  auto made = Engine::create(test::context(), scene, test::stageOf(lighting), options);
  ASSERT_TRUE(made) << made.error().message;
  Engine& engine = **made;
  engine.update(0.0);
  const auto check = [&](const char* how, int radius, double tolerance, double certain) {
    const auto found = test::compare(engine.readColor(), reference, radius + expected.reach, tolerance);
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
                     const Expected& expected = {}) {
  expectPictures(test::trace(scene, lighting, view), scene, lighting, view, expected);
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

/// A wall two metres wide in the plane z = 0, its front towards +z.
std::uint32_t addWall(Scene& scene, std::uint32_t material, const glm::vec3& corner = {-1, -1, 0},
                      float side = 2.0f) {
  return test::addGrid(scene, corner, {side, 0, 0}, {0, side, 0}, 2, 2, material);
}

View wallView(double z = 3.0) { return lookAt({0.3, 0.2, z}, {0, 0, 0}, 50.0, kWidth, kHeight, 0.05); }

TEST_F(Shading, BothSidesOfAWallAreLitFromTheirOwnSide) {
  Scene scene = test::emptyScene();
  Material material = dull({0.8f, 0.5f, 0.3f});
  material.doubleSided = true;
  const auto index = test::addMaterial(scene, material);
  scene.nodes.resize(2);
  scene.nodes[1].scale = {-1.0, 1.0, 1.0};  // its winding is turned, its front is not
  scene.nodes[1].translation = {0.0, 0.0, -0.001};
  test::place(scene, addWall(scene, index, {-1, -1, 0}, 0.9f), 0);
  test::place(scene, addWall(scene, index, {-1, -1, 0}, 0.9f), 1);
  test::place(scene, addWall(scene, index, {-1, 0.1f, 0}, 0.9f), 0);
  test::finish(scene);
  for (const double eye : {3.0, -3.0})
    for (const double along : {-1.0, 1.0}) {
      SCOPED_TRACE(::testing::Message() << "eye at z " << eye << ", light towards " << along);
      Lighting lighting;
      lighting.lights.push_back(directional({0.2, -0.4, along}, {3.0f, 2.5f, 2.0f}));
      const test::Reference reference = test::trace(scene, lighting, wallView(eye));
      expectPictures(reference, scene, lighting, wallView(eye));
      // What physics says in one word: the side that the light falls on is bright, the other is black.
      float brightest = 0.0f;
      for (const glm::vec4& p : reference.points) brightest = std::max(brightest, p.r);
      if (eye * along < 0.0)
        EXPECT_GT(brightest, 150.0f);
      else
        EXPECT_EQ(brightest, 0.0f);
    }
}

TEST_F(Shading, WallsBeforeAndBehindTheEyeShowTheirSides) {
  Scene scene = test::emptyScene();
  Material material = dull({0.8f, 0.5f, 0.3f});
  material.doubleSided = true;
  const auto index = test::addMaterial(scene, material);
  test::place(scene, addWall(scene, index, {-1, -1, -3}));
  test::place(scene, addWall(scene, index, {-1, -1, 3}));
  test::finish(scene);
  Lighting lighting;
  lighting.lights.push_back(directional({0.2, -0.4, -1.0}, {3.0f, 2.5f, 2.0f}));
  lighting.ambient = {glm::vec3(0.1f), glm::vec3(0.1f)};
  for (const double z : {-3.0, 3.0}) {
    SCOPED_TRACE(::testing::Message() << "the wall at z " << z);
    expectReference(scene, lighting, lookAt({0.1, 0.2, 0}, {0, 0, z}, 50.0, kWidth, kHeight, 0.05));
  }
}

TEST_F(Shading, HalvesOfAPatchAreSeenFromDifferentSides) {
  Lighting lighting;
  lighting.lights.push_back(directional({0.3, -1.0, 0.2}, glm::vec3(2.0f)));
  lighting.lights.push_back(directional({-0.2, 1.0, 0.1}, {0.2f, 0.4f, 0.8f}));
  for (const double mirror : {1.0, -1.0}) {
    Scene scene = test::emptyScene();
    Material material = dull({0.7f, 0.7f, 0.7f});
    material.doubleSided = true;
    // A roof whose halves share the diagonal, low enough to be one patch, with normals straight up.
    test::place(scene, test::addGrid(scene, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 1, 1,
                                     test::addMaterial(scene, material)));
    scene.vertices.position[0].y = scene.vertices.position[3].y = 0.35f;
    scene.nodes[0].scale.x = mirror;
    test::finish(scene);
    for (const glm::dvec3 eye :
         {glm::dvec3(-1.8, 0.3, -1.2), glm::dvec3(1.5, 0.3, 1.8), glm::dvec3(1.4, 0.2, 1.0),
          glm::dvec3(-1.3, 0.1, -1.6), glm::dvec3(0.2, -0.9, 1.8)}) {
      SCOPED_TRACE(::testing::Message() << "mirror " << mirror << ", eye at x " << eye.x << ", z " << eye.z);
      const View view = lookAt({eye.x * mirror, eye.y, eye.z}, {0, 0.1, 0}, 60.0, kWidth, kHeight, 0.05);
      // The fold is a silhouette here, where filtering brings in the texels of its other side.
      expectReference(scene, lighting, view, {.certainInAtlas = 0.05, .silhouettes = false});
    }
  }
}

TextureSlot nearest(std::uint32_t image) {
  TextureSlot slot;
  slot.image = image;
  slot.sampler.mag = slot.sampler.min = Filter::Nearest;
  slot.sampler.mip = Mip::None;
  slot.sampler.wrapS = slot.sampler.wrapT = Wrap::Clamp;
  return slot;
}

/// A normal map of two tilts, in checkers.
TextureSlot bumps(Scene& scene) {
  const TextureSlot slot = nearest(test::addCheckers(scene, 64, 4));
  auto& pixels = scene.images[slot.image].image.pixels;
  for (std::size_t i = 0; i < pixels.size(); i += 4) {
    const bool on = pixels[i] > 128;
    pixels[i] = on ? 180 : 100;
    pixels[i + 1] = on ? 150 : 80;
    pixels[i + 2] = on ? 240 : 230;
  }
  return slot;
}

TEST_F(Shading, EmissionAddsToLight) {
  Scene scene = test::emptyScene();
  Material plain = dull({0.3f, 0.3f, 0.3f});
  plain.emissiveFactor = {0.20f, 0.05f, 0.01f};
  Material textured = dull({0.1f, 0.4f, 0.1f});
  // KHR_materials_emissive_strength: factors past 1.
  textured.emissiveFactor = {2.0f, 0.5f, 3.0f};
  textured.emissive = nearest(test::addCheckers(scene, 64, 4));
  Material dark = dull({0.3f, 0.3f, 0.3f});
  dark.emissive = textured.emissive;  // a factor of 0 keeps the texture's light away
  Material glaring = plain;
  glaring.emissiveFactor = glm::vec3(1e30f);  // its square is past float32
  test::place(scene, addWall(scene, test::addMaterial(scene, glaring), {-0.4f, 0.6f, 0}, 0.5f));
  test::place(scene, addWall(scene, test::addMaterial(scene, plain), {-1.2f, -1, 0}, 0.7f));
  test::place(scene, addWall(scene, test::addMaterial(scene, textured), {-0.4f, -1, 0}, 1.4f));
  test::place(scene, addWall(scene, test::addMaterial(scene, dark), {-1.2f, 0, 0}, 0.7f));
  test::finish(scene);
  Lighting lighting;
  expectReference(scene, lighting, wallView());
  expectReference(scene, lighting, wallView(), {.format = AtlasFormat::Rgba16f});
  lighting.exposure = 0.5;
  expectReference(scene, lighting, wallView());
  lighting.lights.push_back(directional({0.4, -0.5, -1.0}, {1.5f, 1.0f, 0.5f}));
  expectReference(scene, lighting, wallView());
}

TEST_F(Shading, EmissionAloneHasItsOwnColour) {
  // By hand: through the film curve 0.18, 0.05 and 1 are 0.2669, 0.04428 and 0.8038; in 8-bit sRGB
  // 141.1, 59.4, 231.6.
  Scene scene = test::emptyScene();
  Material material = dull(glm::vec3(0.9f));
  material.emissiveFactor = {0.18f, 0.05f, 1.0f};
  test::place(scene, addWall(scene, test::addMaterial(scene, material)));
  test::finish(scene);
  EngineOptions options;
  auto engine = Engine::create(test::context(), scene, test::stageOf({}), options);
  ASSERT_TRUE(engine) << engine.error().message;
  (*engine)->update(0.0);
  for (const bool atlas : {false, true}) {
    if (atlas)
      (*engine)->rect(wallView());
    else
      (*engine)->forward(wallView());
    const Image image = (*engine)->readColor();
    const std::uint8_t* p = image.at(kWidth / 2, kHeight / 2);
    EXPECT_NEAR(p[0], 141.1, 1.5);
    EXPECT_NEAR(p[1], 59.4, 1.5);
    EXPECT_NEAR(p[2], 231.6, 1.5);
  }
}

TEST_F(Shading, LobesOfEveryMetalAndRoughness) {
  Scene scene = test::emptyScene();
  for (int i = 0; i < 9; ++i) {
    Material material = dull({0.9f, 0.6f, 0.3f});
    material.metallicFactor = 0.5f * static_cast<float>(i % 3);
    material.roughnessFactor = 0.3f + 0.35f * static_cast<float>(i / 3);
    const float x = -1.05f + 0.72f * static_cast<float>(i % 3);
    const float y = -1.05f + 0.72f * static_cast<float>(i / 3);
    test::place(scene, addWall(scene, test::addMaterial(scene, material), {x, y, 0}, 0.66f));
  }
  test::finish(scene);
  Lighting sun;
  sun.lights.push_back(directional({0.1, 0.3, -1.0}, {1.0f, 0.9f, 0.8f}));
  Lighting grazing;
  grazing.lights.push_back(directional({1.0, 0.2, -0.15}, {6.0f, 6.0f, 6.0f}));
  Lighting lamps;
  lamps.exposure = 0.7;
  lamps.lights.push_back(point({0.5, 0.9, 1.1}, {0.8f, 0.5f, 0.9f}));
  lamps.lights.push_back(point({-0.9, -0.6, 0.7}, {0.1f, 0.5f, 0.3f}));
  for (const Lighting& lighting : {sun, grazing, lamps})
    for (const glm::dvec3 eye : {glm::dvec3(0.3, 0.2, 2.8), glm::dvec3(-2.6, 0.4, 0.9)})
      expectReference(scene, lighting, lookAt(eye, {0, 0, 0}, 55.0, kWidth, kHeight, 0.05),
                      {.certainInAtlas = 0.01});
}

TEST_F(Shading, LampsEndAtTheirRangeAndCone) {
  Scene scene = test::emptyScene();
  const auto index = test::addMaterial(scene, dull({0.8f, 0.8f, 0.8f}));
  test::place(scene, test::addGrid(scene, {-1.5f, -1, 0}, {3, 0, 0}, {0, 2, 0}, 6, 4, index));
  test::finish(scene);
  Lighting ranged;
  ranged.lights.push_back(point({0.4, 0.1, 0.6}, glm::vec3(1.5f)));
  ranged.lights[0].range = 1.2f;
  expectReference(scene, ranged, wallView());
  Lighting close;
  close.lights.push_back(point({0.1, 0.05, 0.05}, glm::vec3(0.01f)));
  expectReference(scene, close, lookAt({0, 0, 0.6}, {0, 0, 0}, 50.0, kWidth, kHeight, 0.05));
  Lighting spot;
  spot.lights.push_back(point({-0.6, 0.3, 1.0}, glm::vec3(2.5f)));
  spot.lights[0].type = LightType::Spot;
  spot.lights[0].direction = glm::normalize(glm::dvec3(0.5, -0.2, -1.0));
  spot.lights[0].innerCone = 0.2f;
  spot.lights[0].outerCone = 0.6f;
  expectReference(scene, spot, wallView());
}

TEST_F(Shading, AmbientLightFromSkyAndGround) {
  Scene scene = test::emptyScene();
  Material rough = dull({0.6f, 0.5f, 0.4f});
  Material metal = rough;
  metal.metallicFactor = 1.0f;
  metal.roughnessFactor = 0.4f;
  const std::uint32_t materials[] = {test::addMaterial(scene, rough), test::addMaterial(scene, metal)};
  for (int i = 0; i < 2; ++i) {
    const auto x = static_cast<float>(i);
    test::place(scene, addWall(scene, materials[i], {x - 1, 0.05f, 0}, 0.9f));
    // A floor and a ceiling look up and down.
    test::place(scene, test::addGrid(scene, {x - 1, -0.7f, 1}, {0.9f, 0, 0}, {0, 0, -1}, 1, 1, materials[i]));
    test::place(scene, test::addGrid(scene, {x - 1, 1.2f, 0}, {0.9f, 0, 0}, {0, 0, 1}, 1, 1, materials[i]));
  }
  test::finish(scene);
  Lighting even;
  even.ambient = {glm::vec3(0.3f), glm::vec3(0.3f)};
  expectReference(scene, even, wallView());
  Lighting outdoors;
  outdoors.ambient = {{0.3f, 0.4f, 0.6f}, {0.15f, 0.1f, 0.05f}};
  expectReference(scene, outdoors, wallView());
}

TEST_F(Shading, TexturesOfEverySlot) {
  Scene scene = test::emptyScene();
  const auto checkers = nearest(test::addCheckers(scene, 64, 4));
  std::vector<Material> materials(6, dull({0.9f, 0.8f, 0.7f}));
  materials[0].baseColor = checkers;
  materials[1].metallicRoughness = checkers;
  materials[1].metallicFactor = 0.8f;
  materials[2].occlusion = checkers;
  materials[2].occlusionStrength = 0.7f;
  materials[3].normal = bumps(scene);
  materials[3].normalScale = 0.6f;
  materials[4].baseColor = checkers;
  materials[4].baseColor.sampler.wrapS = materials[4].baseColor.sampler.wrapT = Wrap::Repeat;
  materials[4].baseColor.hasTransform = true;
  materials[4].baseColor.uvTransform = {glm::vec3(0.5f, 0.3f, 0.1f), glm::vec3(-0.2f, 0.7f, 0.2f)};
  materials[5].baseColor = checkers;
  materials[5].baseColor.uvSet = 1;
  materials[5].emissive = checkers;
  materials[5].emissiveFactor = glm::vec3(0.1f);
  for (std::size_t i = 0; i < 6; ++i) {
    materials[i].doubleSided = true;
    const glm::vec3 corner(-1.2f + 0.8f * static_cast<float>(i % 3), -0.8f + 0.8f * static_cast<float>(i / 3),
                           0);
    test::place(scene, test::addGrid(scene, corner, {0.75f, 0, 0}, {0, 0.75f, 0}, 2, 2,
                                     test::addMaterial(scene, materials[i]), i == 1));
  }
  scene.vertices.tangent.assign(scene.vertices.position.size(), glm::vec4(1, 0, 0, 1));
  for (const glm::vec2& uv : scene.vertices.uv0) scene.vertices.uv1.emplace_back(0.7f * uv.y, 0.4f * uv.x);
  scene.nodes.resize(2);
  scene.nodes[1].scale = {1.0, -1.0, 1.0};
  scene.nodes[1].rotation = glm::angleAxis(0.3, glm::normalize(glm::dvec3(0.7, 0.9, 1)));
  scene.nodes[1].translation = {-0.4, 1.15, 0.0};
  for (Instance& instance : scene.instances)
    if (instance.primitive == 3) instance.node = 1;
  test::finish(scene);
  Lighting lighting;
  lighting.lights.push_back(directional({0.6, -0.5, -1.0}, {2.0f, 1.8f, 1.6f}));
  lighting.lights.push_back(directional({0.6, -0.3, 1.0}, {1.0f, 1.2f, 1.6f}));
  lighting.ambient = {glm::vec3(0.2f), glm::vec3(0.2f)};
  for (const double z : {2.6, -2.6}) {
    SCOPED_TRACE(::testing::Message() << "eye at z " << z);
    expectReference(scene, lighting, wallView(z));
  }
}

TEST_F(Shading, UnlitColoursAreWhatTheyAre) {
  Scene scene = test::emptyScene();
  Material white;
  white.unlit = true;
  Material textured = white;
  textured.baseColor = nearest(test::addCheckers(scene, 64, 4));
  textured.baseColorFactor = {1.0f, 0.5f, 0.25f, 1.0f};
  const auto index = test::addMaterial(scene, white);
  test::place(scene, addWall(scene, index, {-1.2f, -1, 0}, 1.0f));
  test::place(scene, addWall(scene, test::addMaterial(scene, textured), {0, -1, 0}, 1.0f));
  test::place(scene, test::addGrid(scene, {-1.2f, 0.1f, 0}, {2, 0, 0}, {0, 0.8f, 0}, 4, 2, index, true));
  for (glm::vec4& color : scene.vertices.color) color = 0.2f + 0.8f * color;
  test::finish(scene);
  Lighting dim;
  dim.exposure = 0.25;  // neither it nor the film curve touches them
  expectReference(scene, dim, wallView());
}

TEST_F(Shading, TinyUnitsKeepTheirNormals) {
  // A mesh in units of 10 picometres: its normal matrix has entries whose squares are past float32.
  Scene scene = test::emptyScene();
  scene.nodes[0].scale = glm::dvec3(1e-11);
  const auto index = test::addMaterial(scene, dull({0.8f, 0.5f, 0.3f}));
  test::place(scene, addWall(scene, index, {-1e11f, -1e11f, 0}, 2e11f));
  scene.vertices.normal.assign(scene.vertices.position.size(), glm::vec3(0, 0, 1));
  test::finish(scene);
  Lighting lighting;
  lighting.lights.push_back(directional({0.2, -0.9, -0.6}, glm::vec3(3.0f)));
  expectReference(scene, lighting, wallView());
}

TEST_F(Shading, BlendedAlphaIsAShareOfLight) {
  Scene scene = test::emptyScene();
  Material ground;
  ground.unlit = true;
  ground.baseColorFactor = {0.1f, 0.2f, 0.8f, 1.0f};
  Material glass = ground;
  glass.alphaMode = AlphaMode::Blend;
  glass.baseColorFactor = {0.6f, 0.4f, 0.0f, 0.25f};
  test::place(scene, addWall(scene, test::addMaterial(scene, ground)));
  test::place(scene, addWall(scene, test::addMaterial(scene, glass), {-0.5f, -0.5f, 0.3f}, 1.0f));
  test::finish(scene);
  auto engine = Engine::create(test::context(), scene, test::stageOf({}), {});
  ASSERT_TRUE(engine) << engine.error().message;
  (*engine)->update(0.0);
  for (const bool atlas : {false, true}) {
    if (atlas)
      (*engine)->rect(wallView());
    else
      (*engine)->forward(wallView());
    const Image image = (*engine)->readColor();
    // By hand: 3/4 of the ground and 1/4 of the glass are 0.225, 0.25 and 0.6; in 8-bit sRGB 130.5, 136.9,
    // 203.0.
    const std::uint8_t* p = image.at(kWidth / 2, kHeight / 2);
    EXPECT_NEAR(p[0], 130.5, 2.0);
    EXPECT_NEAR(p[1], 136.9, 2.0);
    EXPECT_NEAR(p[2], 203.0, 2.0);
  }
}

TEST_F(Shading, BumpsTurnWithTheirInstance) {
  // The tangent of a wall that is turned about y lies along z, and so on about every axis.
  for (const glm::dvec3 axis : {glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1)}) {
    Scene scene = test::emptyScene();
    Material bumpy = dull({0.8f, 0.7f, 0.6f});
    bumpy.normal = bumps(scene);
    scene.nodes[0].rotation = glm::angleAxis(1.3, axis);
    test::place(scene, addWall(scene, test::addMaterial(scene, bumpy)));
    scene.vertices.tangent.assign(scene.vertices.position.size(), glm::vec4(0.6f, 0.8f, 0, 1));
    test::finish(scene);
    const glm::dvec3 front = scene.nodes[0].rotation * glm::dvec3(0, 0, 1);
    const glm::dvec3 aside = scene.nodes[0].rotation * glm::dvec3(0.9, 0.4, 0);
    Lighting sun;
    sun.lights.push_back(directional(aside - front, glm::vec3(3.0f)));
    SCOPED_TRACE(::testing::Message() << "about " << axis.x << " " << axis.y << " " << axis.z);
    const View view = lookAt(2.5 * front + glm::dvec3(0.2, 0.1, 0.1), {0, 0, 0}, 50.0, kWidth, kHeight, 0.05);
    expectReference(scene, sun, view, {.certainInAtlas = 0.1});
  }
}

TEST_F(Shading, LongWallsHaveTheirTexelsAlongTheirLength) {
  Scene scene = test::emptyScene();
  Material striped;
  striped.unlit = true;
  striped.baseColor = nearest(test::addCheckers(scene, 64, 16));
  const auto index = test::addMaterial(scene, striped);
  test::place(scene, test::addGrid(scene, {-1.2f, 0.7f, 0}, {2.4f, 0, 0}, {0, 0.3f, 0}, 1, 1, index));
  test::place(scene, test::addGrid(scene, {-1.2f, -1, 0}, {0.3f, 0, 0}, {0, 1.6f, 0}, 1, 1, index));
  // Stripes across the length only.
  for (glm::vec2& uv : scene.vertices.uv0) uv *= 0.99f;
  for (std::size_t i = 0; i < 4; ++i) scene.vertices.uv0[i].y = 0.01f;
  for (std::size_t i = 4; i < 8; ++i) scene.vertices.uv0[i].x = 0.01f;
  test::finish(scene);
  expectReference(scene, {}, wallView(2.6), {.certainInAtlas = 0.0});
}

TEST_F(Shading, FansOfTrianglesAreWholeInBothDisplays) {
  Scene scene = test::emptyScene();
  const auto material = test::addMaterial(scene, dull({0.9f, 0.9f, 0.9f}));
  scene.nodes.resize(2);
  scene.nodes[1].scale = {1.0, -1.0, 1.0};
  for (int fan = 0; fan < 3; ++fan) {
    const int sides = 5 + 2 * (fan % 2);  // three triangles are a triple, five leave one alone
    Primitive primitive;
    primitive.material = material;
    primitive.hasColor = true;
    primitive.firstVertex = static_cast<std::uint32_t>(scene.vertices.position.size());
    primitive.firstIndex = static_cast<std::uint32_t>(scene.indices.size());
    for (int i = 0; i < sides; ++i) {
      const float angle = 6.2831853f * (static_cast<float>(i) + 0.3f) / static_cast<float>(sides);
      const glm::vec3 p(static_cast<float>(fan) - 1 + 0.42f * std::cos(angle), 0.6f + 0.42f * std::sin(angle),
                        0);
      scene.vertices.position.push_back(p);
      scene.vertices.normal.emplace_back(0, 0, 1);
      scene.vertices.uv0.emplace_back(0);
      scene.vertices.color.emplace_back(0.2f + 0.8f * static_cast<float>(i % 2),
                                        0.15f * static_cast<float>(i), i % 3 == 0 ? 0.9f : 0.3f, 1.0f);
      primitive.bounds.add(glm::dvec3(p));
    }
    for (int i = 2; i < sides; ++i)
      for (const int v : {0, i - 1, i})
        scene.indices.push_back(primitive.firstVertex + static_cast<std::uint32_t>(v));
    primitive.vertexCount = static_cast<std::uint32_t>(sides);
    primitive.indexCount = static_cast<std::uint32_t>(3 * (sides - 2));
    scene.primitives.push_back(primitive);
    for (std::uint32_t node = 0; node < 2; ++node) test::place(scene, static_cast<std::uint32_t>(fan), node);
  }
  test::finish(scene);
  Lighting sun;
  sun.lights.push_back(directional({0.1, 0.3, -1.0}, glm::vec3(3.0f)));
  expectReference(scene, sun, wallView(2.4), {.certain = 0.1, .certainInAtlas = 0.0});
}

/// The six walls of a room of 6 m a side about the origin, fronts inwards.
void addRoom(Scene& scene, std::uint32_t material) {
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      glm::vec3 u(0.0f);
      glm::vec3 v(0.0f);
      u[(axis + 1) % 3] = 6.0f;
      v[(axis + 2) % 3] = 6.0f;
      if (side > 0.0f) std::swap(u, v);
      glm::vec3 centre(0.0f);
      centre[axis] = 3.0f * side;
      test::place(scene, test::addGrid(scene, centre - 0.5f * (u + v), u, v, 2, 2, material));
    }
}

/// A slab about `centre`, across the axis.
void addSlab(Scene& scene, const glm::vec3& centre, int axis, float half, std::uint32_t material) {
  glm::vec3 u(0.0f);
  glm::vec3 v(0.0f);
  u[(axis + 1) % 3] = 2.0f * half;
  v[(axis + 2) % 3] = 2.0f * half;
  test::place(scene, test::addGrid(scene, centre - 0.5f * (u + v), u, v, 1, 1, material));
}

TEST_F(Shading, PointLightShadowsOnAllSixSides) {
  Scene scene = test::emptyScene();
  const auto walls = test::addMaterial(scene, dull({0.8f, 0.7f, 0.6f}));
  addRoom(scene, walls);
  const glm::dvec3 lamp(0.2, 0.1, -0.15);
  // Slabs of different size, off centre, so that no face passes for another or for its mirror image.
  for (int i = 0; i < 6; ++i) {
    const int axis = i / 2;
    glm::vec3 centre = glm::vec3(lamp);
    centre[axis] += i % 2 == 0 ? 1.0f : -1.0f;
    centre[(axis + 1) % 3] += 0.1f;
    centre[(axis + 2) % 3] -= 0.2f;
    addSlab(scene, centre, axis, 0.25f + 0.03f * static_cast<float>(i), walls);
  }
  test::finish(scene);
  Lighting lighting;
  lighting.lights.push_back(point(lamp, glm::vec3(20.0f)));
  lighting.lights[0].castsShadow = true;
  for (int i = 0; i < 6; ++i) {
    SCOPED_TRACE(::testing::Message() << "face " << i);
    glm::dvec3 out(0.0);
    out[i / 2] = i % 2 == 0 ? 1.0 : -1.0;
    // Between slab and wall.
    const View view = lookAt(lamp + 1.2 * out, lamp + 2.0 * out, 95.0, kWidth, kHeight, 0.05);
    const test::Reference reference = test::trace(scene, lighting, view);
    expectPictures(reference, scene, lighting, view);
    // The shadow is black and is there; the wall around it is lit.
    std::size_t black = 0;
    std::size_t bright = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const float red = reference.centre(x, y).r;
        black += red == 0.0f ? 1 : 0;
        bright += red > 100.0f ? 1 : 0;
      }
    EXPECT_GT(black, 500u);
    EXPECT_GT(bright, 5000u);
  }
}

TEST_F(Shading, NoLightLeavesAClosedBox) {
  Scene scene = test::emptyScene();
  const auto walls = test::addMaterial(scene, dull({0.8f, 0.7f, 0.6f}));
  addRoom(scene, walls);
  for (int i = 0; i < 6; ++i) {
    glm::vec3 centre(0.0f);
    centre[i / 2] = i % 2 == 0 ? 0.8f : -0.8f;
    addSlab(scene, centre, i / 2, 0.8f, walls);
  }
  test::finish(scene);
  Lighting lighting;
  lighting.lights.push_back(point({0.1, 0.05, -0.07}, glm::vec3(200.0f)));
  lighting.lights[0].castsShadow = true;
  lighting.ambient = {glm::vec3(0.2f), glm::vec3(0.2f)};
  // A coarse map: what leaks at the seams of its faces is as wide as its texels.
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) {
        const glm::dvec3 corner(x, y, z);
        SCOPED_TRACE(::testing::Message() << "corner " << x << " " << y << " " << z);
        expectReference(scene, lighting, lookAt(1.0 * corner, 3.0 * corner, 100.0, kWidth, kHeight, 0.05),
                        {.shadowSize = 128});
      }
}

TEST_F(Shading, ShadowsOfSunAndSpotAreWhereTheyMustBe) {
  Scene scene = test::emptyScene();
  // The normal offset of the shadow map lets light in by a shadow texel or two where things touch.
  const auto floor = test::addMaterial(scene, dull({0.8f, 0.7f, 0.6f}));
  Material leaf = dull({0.2f, 0.8f, 0.2f});
  leaf.alphaMode = AlphaMode::Mask;
  leaf.doubleSided = true;
  leaf.baseColor = nearest(test::addCheckers(scene, 64, 2, true));
  // One colour all over: what filtering finds beyond the holes' edges is the same.
  auto& pixels = scene.images[leaf.baseColor.image].image.pixels;
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (i % 4 != 3) pixels[i] = 200;
  const auto leaves = test::addMaterial(scene, leaf);
  test::place(scene, test::addGrid(scene, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4}, 8, 8, floor));
  test::place(scene, test::addGrid(scene, {-1.2f, 0.6f, 0.5f}, {1, 0, 0}, {0, 0.2f, -1}, 1, 1, leaves));
  test::place(scene, test::addGrid(scene, {0.5f, 0, 0}, {0.6f, 0, 0.2f}, {0, 0.9f, 0}, 1, 1, floor));
  test::finish(scene);
  const View view = lookAt({0.3, 2.6, 2.4}, {0, 0.2, 0}, 60.0, kWidth, kHeight, 0.05);
  Lighting sun;
  sun.lights.push_back(directional({0.5, -1.0, -0.4}, glm::vec3(3.0f)));
  sun.lights[0].castsShadow = true;
  expectReference(scene, sun, view, {.certain = 0.25, .reach = 1});
  Lighting spot;
  spot.lights.push_back(point({-0.4, 2.4, 1.0}, glm::vec3(15.0f)));
  spot.lights[0].type = LightType::Spot;
  spot.lights[0].direction = glm::normalize(glm::dvec3(0.1, -1.0, -0.45));
  spot.lights[0].innerCone = 0.3f;
  spot.lights[0].outerCone = 0.75f;
  spot.lights[0].castsShadow = true;
  expectReference(scene, spot, view, {.certain = 0.25, .reach = 1});
}

TEST_F(Shading, HolesByTextureCoordinatesVertexAlphaAndCutoff) {
  Scene scene = test::emptyScene();
  auto holes = nearest(test::addCheckers(scene, 64, 2, true));
  // One colour all over: what filtering finds beyond the holes' edges is the same.
  auto& pixels = scene.images[holes.image].image.pixels;
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (i % 4 != 3) pixels[i] = 200;
  Material leaf = dull({0.2f, 0.8f, 0.2f});
  leaf.alphaMode = AlphaMode::Mask;
  leaf.doubleSided = true;
  std::vector<Material> materials(5, leaf);
  materials[0].baseColor = holes;
  materials[0].baseColor.uvSet = 1;
  materials[1].baseColor = holes;
  materials[1].baseColor.hasTransform = true;
  materials[1].baseColor.uvTransform = {glm::vec3(0.5f, 0.3f, 0.1f), glm::vec3(-0.2f, 0.7f, 0.3f)};
  materials[2].alphaCutoff = 0.6f;        // vertex alpha alone
  materials[3].baseColorFactor.a = 0.5f;  // at the cutoff: not a hole
  materials[4].baseColor = holes;
  materials[4].baseColor.uvSet = 1;  // with a transform and vertex alpha besides
  materials[4].baseColor.hasTransform = true;
  materials[4].baseColor.uvTransform = {glm::vec3(0.9f, 0.0f, 0.05f), glm::vec3(0.0f, 0.6f, 0.1f)};
  test::place(scene, test::addGrid(scene, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4}, 4, 4,
                                   test::addMaterial(scene, dull({0.8f, 0.7f, 0.6f}))));
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const glm::vec3 corner(-1.6f + 0.7f * static_cast<float>(i), 0.7f, 0.3f);
    const bool alpha = i == 2 || i == 4;
    const auto first = scene.vertices.position.size();
    test::place(scene, test::addGrid(scene, corner, {0.6f, 0, 0}, {0, 0.1f, -0.6f}, 1, 1,
                                     test::addMaterial(scene, materials[i]), alpha));
    if (!alpha) continue;
    for (std::size_t v = first; v < scene.vertices.color.size(); ++v)
      scene.vertices.color[v] = {1, 1, 1, scene.vertices.uv0[v].x};
  }
  for (const glm::vec2& uv : scene.vertices.uv0)
    scene.vertices.uv1.emplace_back(0.3f + 0.6f * uv.y, 0.8f * uv.x);
  for (Primitive& primitive : scene.primitives) primitive.hasUv1 = true;
  test::finish(scene);
  Lighting sun;
  sun.lights.push_back(directional({0.3, -1.0, 0.9}, glm::vec3(3.0f)));
  sun.lights[0].castsShadow = true;
  const View view = lookAt({0.1, 2.2, 2.0}, {0, 0.3, 0.2}, 60.0, kWidth, kHeight, 0.05);
  expectReference(scene, sun, view, {.certain = 0.25, .reach = 1});
}

TEST_F(Shading, BumpsSeeNoLightThatTheirSurfaceHides) {
  Scene scene = test::emptyScene();
  Material bumpy = dull({0.8f, 0.7f, 0.6f});
  bumpy.normal = bumps(scene);
  bumpy.normalScale = 2.0f;
  test::place(scene, addWall(scene, test::addMaterial(scene, bumpy)));
  scene.vertices.tangent.assign(scene.vertices.position.size(), glm::vec4(1, 0, 0, 1));
  test::finish(scene);
  Lighting sun;
  sun.ambient = {glm::vec3(0.1f), glm::vec3(0.1f)};
  sun.lights.push_back(
      directional({1.0, 0.1, 0.02}, glm::vec3(3.0f)));  // from behind, all but along the wall
  sun.lights[0].castsShadow = true;
  expectReference(scene, sun, wallView());
}

TEST_F(Shading, WhatLiesLowUnderANearLampCastsItsShadow) {
  Scene scene = test::emptyScene();
  const auto material = test::addMaterial(scene, dull({0.8f, 0.7f, 0.6f}));
  test::place(scene, test::addGrid(scene, {-0.5f, 0, 0.5f}, {1, 0, 0}, {0, 0, -1}, 2, 2, material));
  // Its front looks down: from above it is not there, but it casts.
  test::place(scene,
              test::addGrid(scene, {-0.15f, 0.035f, -0.15f}, {0.3f, 0, 0}, {0, 0, 0.3f}, 1, 1, material));
  test::finish(scene);
  Lighting lamp;
  lamp.lights.push_back(point({0, 0.4, 0}, glm::vec3(0.5f)));
  lamp.lights[0].castsShadow = true;
  lamp.ambient = {glm::vec3(0.1f), glm::vec3(0.1f)};
  // A texel is 3 cm at a metre, and 12 mm here: the offset from the floor must be less than the gap.
  expectReference(scene, lamp, lookAt({0.05, 0.9, 0.3}, {0, 0, 0}, 50.0, kWidth, kHeight, 0.05),
                  {.certain = 0.05, .certainInAtlas = 0.05, .reach = 6, .shadowSize = 64});
}

TEST_F(Shading, WhatLeavesTheShadowMapIsLit) {
  Scene scene = test::emptyScene();
  const auto material = test::addMaterial(scene, dull({0.8f, 0.7f, 0.6f}));
  test::place(scene, test::addGrid(scene, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4}, 4, 4, material));
  test::finish(scene);
  // The bounds are those at rest: what moves out of them lies past the map's end, or beside it.
  test::place(scene, test::addGrid(scene, {2.1f, -9, 2}, {0.6f, 0, 0}, {0, 0, -4}, 1, 4, material));
  test::place(scene, test::addGrid(scene, {2.9f, -9, 2}, {3.0f, 0, 0}, {0, 0, -4}, 3, 4, material));
  Lighting sun;
  sun.lights.push_back(directional({0.0, -1.0, 0.001}, glm::vec3(3.0f)));
  sun.lights[0].castsShadow = true;
  expectReference(scene, sun, lookAt({3.5, -3, 4}, {3.5, -9, 0}, 60.0, kWidth, kHeight, 0.05));

  // A beam as long as the map is wide: its end covers the map's last texels, and nothing past them.
  scene = test::emptyScene();
  test::place(scene, test::addGrid(scene, {-2, 0, 0.1f}, {4, 0, 0}, {0, 0, -0.2f}, 1, 1));
  test::finish(scene);
  scene.materials[0] = dull({0.8f, 0.7f, 0.6f});
  test::place(scene, test::addGrid(scene, {2.2f, -1, 0.1f}, {0.6f, 0, 0}, {0, 0, -0.2f}, 1, 1));
  expectReference(scene, sun, lookAt({2.5, -0.4, 0.5}, {2.5, -1, 0}, 50.0, kWidth, kHeight, 0.05),
                  {.shadowSize = 64});
}

}  // namespace
}  // namespace tessera
