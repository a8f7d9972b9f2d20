// Shading against the reference tracer: lobes, lamps, textures, sides, emission, ambient light and blending,
// for forward and for both displays of the atlas. Two pictures of one engine can be wrong alike; the
// reference shares no code with them.
#include <cmath>
#include <memory>

#include "engine/frame/engine.hpp"
#include "tests/frame/shading_check.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using Shading = test::GlTest;
using test::Lighting;

TEST_F(Shading, BothSidesOfAWallAreLitFromTheirOwnSide) {
  Scene scene = test::emptyScene();
  Material material = test::dull({0.8f, 0.5f, 0.3f});
  material.doubleSided = true;
  const auto index = test::addMaterial(scene, material);
  scene.nodes.resize(2);
  scene.nodes[1].scale = {-1.0, 1.0, 1.0};  // its winding is turned, its front is not
  scene.nodes[1].translation = {0.0, 0.0, -0.001};
  test::place(scene, test::addWall(scene, index, {-1, -1, 0}, 0.9f), 0);
  test::place(scene, test::addWall(scene, index, {-1, -1, 0}, 0.9f), 1);
  test::place(scene, test::addWall(scene, index, {-1, 0.1f, 0}, 0.9f), 0);
  test::finish(scene);
  for (const double eye : {3.0, -3.0})
    for (const double along : {-1.0, 1.0}) {
      SCOPED_TRACE(::testing::Message() << "eye at z " << eye << ", light towards " << along);
      Lighting lighting;
      lighting.lights.push_back(test::directional({0.2, -0.4, along}, {3.0f, 2.5f, 2.0f}));
      const test::Reference reference = test::trace(scene, lighting, test::wallView(eye));
      test::expectPictures(reference, scene, lighting, test::wallView(eye));
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
  Material material = test::dull({0.8f, 0.5f, 0.3f});
  material.doubleSided = true;
  const auto index = test::addMaterial(scene, material);
  test::place(scene, test::addWall(scene, index, {-1, -1, -3}));
  test::place(scene, test::addWall(scene, index, {-1, -1, 3}));
  test::finish(scene);
  Lighting lighting;
  lighting.lights.push_back(test::directional({0.2, -0.4, -1.0}, {3.0f, 2.5f, 2.0f}));
  lighting.ambient = {glm::vec3(0.1f), glm::vec3(0.1f)};
  for (const double z : {-3.0, 3.0}) {
    SCOPED_TRACE(::testing::Message() << "the wall at z " << z);
    test::expectReference(scene, lighting,
                          lookAt({0.1, 0.2, 0}, {0, 0, z}, 50.0, test::kWidth, test::kHeight, 0.05));
  }
}

TEST_F(Shading, HalvesOfAPatchAreSeenFromDifferentSides) {
  Lighting lighting;
  lighting.lights.push_back(test::directional({0.3, -1.0, 0.2}, glm::vec3(2.0f)));
  lighting.lights.push_back(test::directional({-0.2, 1.0, 0.1}, {0.2f, 0.4f, 0.8f}));
  for (const double mirror : {1.0, -1.0}) {
    Scene scene = test::emptyScene();
    Material material = test::dull({0.7f, 0.7f, 0.7f});
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
      const View view =
          lookAt({eye.x * mirror, eye.y, eye.z}, {0, 0.1, 0}, 60.0, test::kWidth, test::kHeight, 0.05);
      // The fold is a silhouette here, where filtering brings in the texels of its other side.
      test::expectReference(scene, lighting, view, {.certainInAtlas = 0.05, .silhouettes = false});
    }
  }
}

TEST_F(Shading, EmissionAddsToLight) {
  Scene scene = test::emptyScene();
  Material plain = test::dull({0.3f, 0.3f, 0.3f});
  plain.emissiveFactor = {0.20f, 0.05f, 0.01f};
  Material textured = test::dull({0.1f, 0.4f, 0.1f});
  // KHR_materials_emissive_strength: factors past 1.
  textured.emissiveFactor = {2.0f, 0.5f, 3.0f};
  textured.emissive = test::nearest(test::addCheckers(scene, 64, 4));
  Material dark = test::dull({0.3f, 0.3f, 0.3f});
  dark.emissive = textured.emissive;  // a factor of 0 keeps the texture's light away
  Material glaring = plain;
  glaring.emissiveFactor = glm::vec3(1e30f);  // its square is past float32
  test::place(scene, test::addWall(scene, test::addMaterial(scene, glaring), {-0.4f, 0.6f, 0}, 0.5f));
  test::place(scene, test::addWall(scene, test::addMaterial(scene, plain), {-1.2f, -1, 0}, 0.7f));
  test::place(scene, test::addWall(scene, test::addMaterial(scene, textured), {-0.4f, -1, 0}, 1.4f));
  test::place(scene, test::addWall(scene, test::addMaterial(scene, dark), {-1.2f, 0, 0}, 0.7f));
  test::finish(scene);
  Lighting lighting;
  test::expectReference(scene, lighting, test::wallView());
  test::expectReference(scene, lighting, test::wallView(), {.format = AtlasFormat::Rgba16f});
  lighting.exposure = 0.5;
  test::expectReference(scene, lighting, test::wallView());
  lighting.lights.push_back(test::directional({0.4, -0.5, -1.0}, {1.5f, 1.0f, 0.5f}));
  test::expectReference(scene, lighting, test::wallView());
}

TEST_F(Shading, EmissionAloneHasItsOwnColour) {
  // By hand: through the film curve 0.18, 0.05 and 1 are 0.2669, 0.04428 and 0.8038; in 8-bit sRGB
  // 141.1, 59.4, 231.6.
  Scene scene = test::emptyScene();
  Material material = test::dull(glm::vec3(0.9f));
  material.emissiveFactor = {0.18f, 0.05f, 1.0f};
  test::place(scene, test::addWall(scene, test::addMaterial(scene, material)));
  test::finish(scene);
  EngineOptions options;
  auto engine = Engine::create(test::context(), scene, test::stageOf({}), options);
  ASSERT_TRUE(engine) << engine.error().message;
  (*engine)->update(0.0);
  for (const bool atlas : {false, true}) {
    if (atlas)
      (*engine)->rect(test::wallView());
    else
      (*engine)->forward(test::wallView());
    const Image image = (*engine)->readColor();
    const std::uint8_t* p = image.at(test::kWidth / 2, test::kHeight / 2);
    EXPECT_NEAR(p[0], 141.1, 1.5);
    EXPECT_NEAR(p[1], 59.4, 1.5);
    EXPECT_NEAR(p[2], 231.6, 1.5);
  }
}

TEST_F(Shading, LobesOfEveryMetalAndRoughness) {
  Scene scene = test::emptyScene();
  for (int i = 0; i < 9; ++i) {
    const int row = i / 3;
    Material material = test::dull({0.9f, 0.6f, 0.3f});
    material.metallicFactor = 0.5f * static_cast<float>(i % 3);
    material.roughnessFactor = 0.3f + 0.35f * static_cast<float>(row);
    const float x = -1.05f + 0.72f * static_cast<float>(i % 3);
    const float y = -1.05f + 0.72f * static_cast<float>(row);
    test::place(scene, test::addWall(scene, test::addMaterial(scene, material), {x, y, 0}, 0.66f));
  }
  test::finish(scene);
  Lighting sun;
  sun.lights.push_back(test::directional({0.1, 0.3, -1.0}, {1.0f, 0.9f, 0.8f}));
  Lighting grazing;
  grazing.lights.push_back(test::directional({1.0, 0.2, -0.15}, {6.0f, 6.0f, 6.0f}));
  Lighting lamps;
  lamps.exposure = 0.7;
  lamps.lights.push_back(test::point({0.5, 0.9, 1.1}, {0.8f, 0.5f, 0.9f}));
  lamps.lights.push_back(test::point({-0.9, -0.6, 0.7}, {0.1f, 0.5f, 0.3f}));
  for (const Lighting& lighting : {sun, grazing, lamps})
    for (const glm::dvec3 eye : {glm::dvec3(0.3, 0.2, 2.8), glm::dvec3(-2.6, 0.4, 0.9)})
      test::expectReference(scene, lighting, lookAt(eye, {0, 0, 0}, 55.0, test::kWidth, test::kHeight, 0.05),
                            {.certainInAtlas = 0.01});
}

TEST_F(Shading, LampsEndAtTheirRangeAndCone) {
  Scene scene = test::emptyScene();
  const auto index = test::addMaterial(scene, test::dull({0.8f, 0.8f, 0.8f}));
  test::place(scene, test::addGrid(scene, {-1.5f, -1, 0}, {3, 0, 0}, {0, 2, 0}, 6, 4, index));
  test::finish(scene);
  Lighting ranged;
  ranged.lights.push_back(test::point({0.4, 0.1, 0.6}, glm::vec3(1.5f)));
  ranged.lights[0].range = 1.2f;
  test::expectReference(scene, ranged, test::wallView());
  Lighting close;
  close.lights.push_back(test::point({0.1, 0.05, 0.05}, glm::vec3(0.01f)));
  test::expectReference(scene, close,
                        lookAt({0, 0, 0.6}, {0, 0, 0}, 50.0, test::kWidth, test::kHeight, 0.05));
  Lighting spot;
  spot.lights.push_back(test::point({-0.6, 0.3, 1.0}, glm::vec3(2.5f)));
  spot.lights[0].type = LightType::Spot;
  spot.lights[0].direction = glm::normalize(glm::dvec3(0.5, -0.2, -1.0));
  spot.lights[0].innerCone = 0.2f;
  spot.lights[0].outerCone = 0.6f;
  test::expectReference(scene, spot, test::wallView());
}

TEST_F(Shading, AmbientLightFromSkyAndGround) {
  Scene scene = test::emptyScene();
  Material rough = test::dull({0.6f, 0.5f, 0.4f});
  Material metal = rough;
  metal.metallicFactor = 1.0f;
  metal.roughnessFactor = 0.4f;
  const std::uint32_t materials[] = {test::addMaterial(scene, rough), test::addMaterial(scene, metal)};
  for (int i = 0; i < 2; ++i) {
    const auto x = static_cast<float>(i);
    test::place(scene, test::addWall(scene, materials[i], {x - 1, 0.05f, 0}, 0.9f));
    // A floor and a ceiling look up and down.
    test::place(scene, test::addGrid(scene, {x - 1, -0.7f, 1}, {0.9f, 0, 0}, {0, 0, -1}, 1, 1, materials[i]));
    test::place(scene, test::addGrid(scene, {x - 1, 1.2f, 0}, {0.9f, 0, 0}, {0, 0, 1}, 1, 1, materials[i]));
  }
  test::finish(scene);
  Lighting even;
  even.ambient = {glm::vec3(0.3f), glm::vec3(0.3f)};
  test::expectReference(scene, even, test::wallView());
  Lighting outdoors;
  outdoors.ambient = {{0.3f, 0.4f, 0.6f}, {0.15f, 0.1f, 0.05f}};
  test::expectReference(scene, outdoors, test::wallView());
}

TEST_F(Shading, TexturesOfEverySlot) {
  Scene scene = test::emptyScene();
  const auto checkers = test::nearest(test::addCheckers(scene, 64, 4));
  std::vector<Material> materials(6, test::dull({0.9f, 0.8f, 0.7f}));
  materials[0].baseColor = checkers;
  materials[1].metallicRoughness = checkers;
  materials[1].metallicFactor = 0.8f;
  materials[2].occlusion = checkers;
  materials[2].occlusionStrength = 0.7f;
  materials[3].normal = test::bumps(scene);
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
    const std::size_t row = i / 3;
    materials[i].doubleSided = true;
    const glm::vec3 corner(-1.2f + 0.8f * static_cast<float>(i % 3), -0.8f + 0.8f * static_cast<float>(row),
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
  lighting.lights.push_back(test::directional({0.6, -0.5, -1.0}, {2.0f, 1.8f, 1.6f}));
  lighting.lights.push_back(test::directional({0.6, -0.3, 1.0}, {1.0f, 1.2f, 1.6f}));
  lighting.ambient = {glm::vec3(0.2f), glm::vec3(0.2f)};
  for (const double z : {2.6, -2.6}) {
    SCOPED_TRACE(::testing::Message() << "eye at z " << z);
    test::expectReference(scene, lighting, test::wallView(z));
  }
}

TEST_F(Shading, UnlitColoursAreWhatTheyAre) {
  Scene scene = test::emptyScene();
  Material white;
  white.unlit = true;
  Material textured = white;
  textured.baseColor = test::nearest(test::addCheckers(scene, 64, 4));
  textured.baseColorFactor = {1.0f, 0.5f, 0.25f, 1.0f};
  const auto index = test::addMaterial(scene, white);
  test::place(scene, test::addWall(scene, index, {-1.2f, -1, 0}, 1.0f));
  test::place(scene, test::addWall(scene, test::addMaterial(scene, textured), {0, -1, 0}, 1.0f));
  test::place(scene, test::addGrid(scene, {-1.2f, 0.1f, 0}, {2, 0, 0}, {0, 0.8f, 0}, 4, 2, index, true));
  for (glm::vec4& color : scene.vertices.color) color = 0.2f + 0.8f * color;
  test::finish(scene);
  Lighting dim;
  dim.exposure = 0.25;  // neither it nor the film curve touches them
  test::expectReference(scene, dim, test::wallView());
}

TEST_F(Shading, TinyUnitsKeepTheirNormals) {
  // A mesh in units of 10 picometres: its normal matrix has entries whose squares are past float32.
  Scene scene = test::emptyScene();
  scene.nodes[0].scale = glm::dvec3(1e-11);
  const auto index = test::addMaterial(scene, test::dull({0.8f, 0.5f, 0.3f}));
  test::place(scene, test::addWall(scene, index, {-1e11f, -1e11f, 0}, 2e11f));
  scene.vertices.normal.assign(scene.vertices.position.size(), glm::vec3(0, 0, 1));
  test::finish(scene);
  Lighting lighting;
  lighting.lights.push_back(test::directional({0.2, -0.9, -0.6}, glm::vec3(3.0f)));
  test::expectReference(scene, lighting, test::wallView());
}

TEST_F(Shading, BlendedAlphaIsAShareOfLight) {
  Scene scene = test::emptyScene();
  Material ground;
  ground.unlit = true;
  ground.baseColorFactor = {0.1f, 0.2f, 0.8f, 1.0f};
  Material glass = ground;
  glass.alphaMode = AlphaMode::Blend;
  glass.baseColorFactor = {0.6f, 0.4f, 0.0f, 0.25f};
  test::place(scene, test::addWall(scene, test::addMaterial(scene, ground)));
  test::place(scene, test::addWall(scene, test::addMaterial(scene, glass), {-0.5f, -0.5f, 0.3f}, 1.0f));
  test::finish(scene);
  auto engine = Engine::create(test::context(), scene, test::stageOf({}), {});
  ASSERT_TRUE(engine) << engine.error().message;
  (*engine)->update(0.0);
  for (const bool atlas : {false, true}) {
    if (atlas)
      (*engine)->rect(test::wallView());
    else
      (*engine)->forward(test::wallView());
    const Image image = (*engine)->readColor();
    // By hand: 3/4 of the ground and 1/4 of the glass are 0.225, 0.25 and 0.6; in 8-bit sRGB 130.5, 136.9,
    // 203.0.
    const std::uint8_t* p = image.at(test::kWidth / 2, test::kHeight / 2);
    EXPECT_NEAR(p[0], 130.5, 2.0);
    EXPECT_NEAR(p[1], 136.9, 2.0);
    EXPECT_NEAR(p[2], 203.0, 2.0);
  }
}

TEST_F(Shading, BumpsTurnWithTheirInstance) {
  // The tangent of a wall that is turned about y lies along z, and so on about every axis.
  for (const glm::dvec3 axis : {glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1)}) {
    Scene scene = test::emptyScene();
    Material bumpy = test::dull({0.8f, 0.7f, 0.6f});
    bumpy.normal = test::bumps(scene);
    scene.nodes[0].rotation = glm::angleAxis(1.3, axis);
    test::place(scene, test::addWall(scene, test::addMaterial(scene, bumpy)));
    scene.vertices.tangent.assign(scene.vertices.position.size(), glm::vec4(0.6f, 0.8f, 0, 1));
    test::finish(scene);
    const glm::dvec3 front = scene.nodes[0].rotation * glm::dvec3(0, 0, 1);
    const glm::dvec3 aside = scene.nodes[0].rotation * glm::dvec3(0.9, 0.4, 0);
    Lighting sun;
    sun.lights.push_back(test::directional(aside - front, glm::vec3(3.0f)));
    SCOPED_TRACE(::testing::Message() << "about " << axis.x << " " << axis.y << " " << axis.z);
    const View view =
        lookAt(2.5 * front + glm::dvec3(0.2, 0.1, 0.1), {0, 0, 0}, 50.0, test::kWidth, test::kHeight, 0.05);
    test::expectReference(scene, sun, view, {.certainInAtlas = 0.1});
  }
}

TEST_F(Shading, LongWallsHaveTheirTexelsAlongTheirLength) {
  Scene scene = test::emptyScene();
  Material striped;
  striped.unlit = true;
  striped.baseColor = test::nearest(test::addCheckers(scene, 64, 16));
  const auto index = test::addMaterial(scene, striped);
  test::place(scene, test::addGrid(scene, {-1.2f, 0.7f, 0}, {2.4f, 0, 0}, {0, 0.3f, 0}, 1, 1, index));
  test::place(scene, test::addGrid(scene, {-1.2f, -1, 0}, {0.3f, 0, 0}, {0, 1.6f, 0}, 1, 1, index));
  // Stripes across the length only.
  for (glm::vec2& uv : scene.vertices.uv0) uv *= 0.99f;
  for (std::size_t i = 0; i < 4; ++i) scene.vertices.uv0[i].y = 0.01f;
  for (std::size_t i = 4; i < 8; ++i) scene.vertices.uv0[i].x = 0.01f;
  test::finish(scene);
  test::expectReference(scene, {}, test::wallView(2.6), {.certainInAtlas = 0.0});
}

TEST_F(Shading, FansOfTrianglesAreWholeInBothDisplays) {
  Scene scene = test::emptyScene();
  const auto material = test::addMaterial(scene, test::dull({0.9f, 0.9f, 0.9f}));
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
  sun.lights.push_back(test::directional({0.1, 0.3, -1.0}, glm::vec3(3.0f)));
  test::expectReference(scene, sun, test::wallView(2.4), {.certain = 0.1, .certainInAtlas = 0.0});
}

}  // namespace
}  // namespace tessera
