// Shadows against the reference tracer: all sides of a point light, seams, holes, the ends of a map.
#include "tests/frame/shading_check.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using Shadows = test::GlTest;
using test::Lighting;

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

TEST_F(Shadows, PointLightShadowsOnAllSixSides) {
  Scene scene = test::emptyScene();
  const auto walls = test::addMaterial(scene, test::dull({0.8f, 0.7f, 0.6f}));
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
  lighting.lights.push_back(test::point(lamp, glm::vec3(20.0f)));
  lighting.lights[0].castsShadow = true;
  for (int i = 0; i < 6; ++i) {
    SCOPED_TRACE(::testing::Message() << "face " << i);
    glm::dvec3 out(0.0);
    out[i / 2] = i % 2 == 0 ? 1.0 : -1.0;
    // Between slab and wall.
    const View view = lookAt(lamp + 1.2 * out, lamp + 2.0 * out, 95.0, test::kWidth, test::kHeight, 0.05);
    const test::Reference reference = test::trace(scene, lighting, view);
    test::expectPictures(reference, scene, lighting, view);
    // The shadow is black and is there; the wall around it is lit.
    std::size_t black = 0;
    std::size_t bright = 0;
    for (int y = 0; y < test::kHeight; ++y)
      for (int x = 0; x < test::kWidth; ++x) {
        const float red = reference.centre(x, y).r;
        black += red == 0.0f ? 1 : 0;
        bright += red > 100.0f ? 1 : 0;
      }
    EXPECT_GT(black, 500u);
    EXPECT_GT(bright, 5000u);
  }
}

TEST_F(Shadows, NoLightLeavesAClosedBox) {
  Scene scene = test::emptyScene();
  const auto walls = test::addMaterial(scene, test::dull({0.8f, 0.7f, 0.6f}));
  addRoom(scene, walls);
  for (int i = 0; i < 6; ++i) {
    glm::vec3 centre(0.0f);
    centre[i / 2] = i % 2 == 0 ? 0.8f : -0.8f;
    addSlab(scene, centre, i / 2, 0.8f, walls);
  }
  test::finish(scene);
  Lighting lighting;
  lighting.lights.push_back(test::point({0.1, 0.05, -0.07}, glm::vec3(200.0f)));
  lighting.lights[0].castsShadow = true;
  lighting.ambient = {glm::vec3(0.2f), glm::vec3(0.2f)};
  // A coarse map: what leaks at the seams of its faces is as wide as its texels.
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) {
        const glm::dvec3 corner(x, y, z);
        SCOPED_TRACE(::testing::Message() << "corner " << x << " " << y << " " << z);
        test::expectReference(scene, lighting,
                              lookAt(1.0 * corner, 3.0 * corner, 100.0, test::kWidth, test::kHeight, 0.05),
                              {.shadowSize = 128});
      }
}

TEST_F(Shadows, ShadowsOfSunAndSpotAreWhereTheyMustBe) {
  Scene scene = test::emptyScene();
  // The normal offset of the shadow map lets light in by a shadow texel or two where things touch.
  const auto floor = test::addMaterial(scene, test::dull({0.8f, 0.7f, 0.6f}));
  Material leaf = test::dull({0.2f, 0.8f, 0.2f});
  leaf.alphaMode = AlphaMode::Mask;
  leaf.doubleSided = true;
  leaf.baseColor = test::nearest(test::addCheckers(scene, 64, 2, true));
  // One colour all over: what filtering finds beyond the holes' edges is the same.
  auto& pixels = scene.images[leaf.baseColor.image].image.pixels;
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (i % 4 != 3) pixels[i] = 200;
  const auto leaves = test::addMaterial(scene, leaf);
  test::place(scene, test::addGrid(scene, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4}, 8, 8, floor));
  test::place(scene, test::addGrid(scene, {-1.2f, 0.6f, 0.5f}, {1, 0, 0}, {0, 0.2f, -1}, 1, 1, leaves));
  test::place(scene, test::addGrid(scene, {0.5f, 0, 0}, {0.6f, 0, 0.2f}, {0, 0.9f, 0}, 1, 1, floor));
  test::finish(scene);
  const View view = lookAt({0.3, 2.6, 2.4}, {0, 0.2, 0}, 60.0, test::kWidth, test::kHeight, 0.05);
  Lighting sun;
  sun.lights.push_back(test::directional({0.5, -1.0, -0.4}, glm::vec3(3.0f)));
  sun.lights[0].castsShadow = true;
  test::expectReference(scene, sun, view, {.certain = 0.25, .reach = 1});
  Lighting spot;
  spot.lights.push_back(test::point({-0.4, 2.4, 1.0}, glm::vec3(15.0f)));
  spot.lights[0].type = LightType::Spot;
  spot.lights[0].direction = glm::normalize(glm::dvec3(0.1, -1.0, -0.45));
  spot.lights[0].innerCone = 0.3f;
  spot.lights[0].outerCone = 0.75f;
  spot.lights[0].castsShadow = true;
  test::expectReference(scene, spot, view, {.certain = 0.25, .reach = 1});
}

TEST_F(Shadows, HolesByTextureCoordinatesVertexAlphaAndCutoff) {
  Scene scene = test::emptyScene();
  auto holes = test::nearest(test::addCheckers(scene, 64, 2, true));
  // One colour all over: what filtering finds beyond the holes' edges is the same.
  auto& pixels = scene.images[holes.image].image.pixels;
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (i % 4 != 3) pixels[i] = 200;
  Material leaf = test::dull({0.2f, 0.8f, 0.2f});
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
                                   test::addMaterial(scene, test::dull({0.8f, 0.7f, 0.6f}))));
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
  sun.lights.push_back(test::directional({0.3, -1.0, 0.9}, glm::vec3(3.0f)));
  sun.lights[0].castsShadow = true;
  const View view = lookAt({0.1, 2.2, 2.0}, {0, 0.3, 0.2}, 60.0, test::kWidth, test::kHeight, 0.05);
  test::expectReference(scene, sun, view, {.certain = 0.25, .reach = 1});
}

TEST_F(Shadows, BumpsSeeNoLightThatTheirSurfaceHides) {
  Scene scene = test::emptyScene();
  Material bumpy = test::dull({0.8f, 0.7f, 0.6f});
  bumpy.normal = test::bumps(scene);
  bumpy.normalScale = 2.0f;
  test::place(scene, test::addWall(scene, test::addMaterial(scene, bumpy)));
  scene.vertices.tangent.assign(scene.vertices.position.size(), glm::vec4(1, 0, 0, 1));
  test::finish(scene);
  Lighting sun;
  sun.ambient = {glm::vec3(0.1f), glm::vec3(0.1f)};
  sun.lights.push_back(
      test::directional({1.0, 0.1, 0.02}, glm::vec3(3.0f)));  // from behind, all but along the wall
  sun.lights[0].castsShadow = true;
  test::expectReference(scene, sun, test::wallView());
}

TEST_F(Shadows, WhatLiesLowUnderANearLampCastsItsShadow) {
  Scene scene = test::emptyScene();
  const auto material = test::addMaterial(scene, test::dull({0.8f, 0.7f, 0.6f}));
  test::place(scene, test::addGrid(scene, {-0.5f, 0, 0.5f}, {1, 0, 0}, {0, 0, -1}, 2, 2, material));
  // Its front looks down: from above it is not there, but it casts.
  test::place(scene,
              test::addGrid(scene, {-0.15f, 0.035f, -0.15f}, {0.3f, 0, 0}, {0, 0, 0.3f}, 1, 1, material));
  test::finish(scene);
  Lighting lamp;
  lamp.lights.push_back(test::point({0, 0.4, 0}, glm::vec3(0.5f)));
  lamp.lights[0].castsShadow = true;
  lamp.ambient = {glm::vec3(0.1f), glm::vec3(0.1f)};
  // A texel is 3 cm at a metre, and 12 mm here: the offset from the floor must be less than the gap.
  test::expectReference(scene, lamp,
                        lookAt({0.05, 0.9, 0.3}, {0, 0, 0}, 50.0, test::kWidth, test::kHeight, 0.05),
                        {.certain = 0.05, .certainInAtlas = 0.05, .reach = 6, .shadowSize = 64});
}

TEST_F(Shadows, WhatLeavesTheShadowMapIsLit) {
  Scene scene = test::emptyScene();
  const auto material = test::addMaterial(scene, test::dull({0.8f, 0.7f, 0.6f}));
  test::place(scene, test::addGrid(scene, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4}, 4, 4, material));
  test::finish(scene);
  // The bounds are those at rest: what moves out of them lies past the map's end, or beside it.
  test::place(scene, test::addGrid(scene, {2.1f, -9, 2}, {0.6f, 0, 0}, {0, 0, -4}, 1, 4, material));
  test::place(scene, test::addGrid(scene, {2.9f, -9, 2}, {3.0f, 0, 0}, {0, 0, -4}, 3, 4, material));
  Lighting sun;
  sun.lights.push_back(test::directional({0.0, -1.0, 0.001}, glm::vec3(3.0f)));
  sun.lights[0].castsShadow = true;
  test::expectReference(scene, sun,
                        lookAt({3.5, -3, 4}, {3.5, -9, 0}, 60.0, test::kWidth, test::kHeight, 0.05));

  // A beam as long as the map is wide: its end covers the map's last texels, and nothing past them.
  scene = test::emptyScene();
  test::place(scene, test::addGrid(scene, {-2, 0, 0.1f}, {4, 0, 0}, {0, 0, -0.2f}, 1, 1));
  test::finish(scene);
  scene.materials[0] = test::dull({0.8f, 0.7f, 0.6f});
  test::place(scene, test::addGrid(scene, {2.2f, -1, 0.1f}, {0.6f, 0, 0}, {0, 0, -0.2f}, 1, 1));
  test::expectReference(scene, sun,
                        lookAt({2.5, -0.4, 0.5}, {2.5, -1, 0}, 50.0, test::kWidth, test::kHeight, 0.05),
                        {.shadowSize = 64});
}

}  // namespace
}  // namespace tessera
