// The engine end to end on scenes made in code: coverage, equality with forward, other cameras, effects.
#include "engine/frame/engine.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "engine/gl/draw_state.hpp"
#include "engine/measure/metrics.hpp"
#include "glsl/shared/bindings.h"
#include "tests/frame/pictures.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using EngineGl = test::GlTest;
using test::cornerScene;
using test::countCovered;
using test::largestDifference;
using test::meanDifference;
using test::unlit;

constexpr int kWidth = 320;
constexpr int kHeight = 240;

EngineOptions smallAtlas() {
  EngineOptions options;
  options.atlas.memory.width = 1024;
  options.atlas.memory.height = 1024;
  options.splitEdges = 0.0;
  options.shadowSize = 256;
  return options;
}

std::unique_ptr<Engine> make(Scene scene, const EngineOptions& options, std::optional<Stage> stage = {}) {
  auto engine = Engine::create(test::context(), std::move(scene), std::move(stage), options);
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return nullptr;
  }
  return std::move(*engine);
}

View cornerView(double shift = 0.0) {
  return lookAt({4.5 + shift, 2.2, 1.5}, {1.5, 0.9, -2.0}, 60.0, kWidth, kHeight, 0.05);
}

/// gather.vert with a fragment shader that adds one to its texel.
GLuint countingProgram() {
  const GladGLContext& gl = gl::api();
  std::vector<std::string> files;
  const auto vertex =
      gl::assembleShader(test::context().info().shaderHeader, "pass/gather.vert", {{"GATHER", "1"}}, files);
  EXPECT_TRUE(vertex) << (vertex ? "" : vertex.error().message);
  const std::string fragment =
      test::context().info().shaderHeader + "layout(location=0) out vec4 o; void main(){o=vec4(1);}\n";
  const GLuint program = gl.CreateProgram();
  for (const auto& [stage, text] :
       {std::pair<GLenum, std::string>{GL_VERTEX_SHADER, *vertex}, {GL_FRAGMENT_SHADER, fragment}}) {
    const GLuint shader = gl.CreateShader(stage);
    const char* source = text.c_str();
    gl.ShaderSource(shader, 1, &source, nullptr);
    gl.CompileShader(shader);
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);
  }
  gl.LinkProgram(program);
  GLint ok = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &ok);
  EXPECT_EQ(ok, GL_TRUE);
  return program;
}

// Draws the gather geometry additively and compares with the blocks that the patch states claim, texel by
// texel.
void expectExactCoverage(Engine& engine) {
  const gl::Texture& atlas = engine.atlas()->atlas().texture;
  gl::Texture counts(GL_RGBA16F, atlas.width(), atlas.height());
  gl::api().ClearTexImage(counts.get(), 0, GL_RGBA, GL_FLOAT, nullptr);
  const std::array<const gl::Texture*, 1> colors = {&counts};
  const gl::Framebuffer framebuffer(colors);
  const GLuint program = countingProgram();
  gl::apply({});
  gl::api().Enable(GL_BLEND);
  gl::api().BlendFunc(GL_ONE, GL_ONE);
  gl::api().BindFramebuffer(GL_FRAMEBUFFER, framebuffer.get());
  gl::api().Viewport(0, 0, atlas.width(), atlas.height());
  gl::api().UseProgram(program);
  gl::api().ProgramUniform2f(program, LOCATION_SIZE, 2.0f / static_cast<float>(atlas.width()),
                             2.0f / static_cast<float>(atlas.height()));
  engine.atlas()->bind();
  engine.atlas()->drawBatches(0, static_cast<std::uint32_t>(engine.drawScene().batches.size()), 0);
  const auto bytes = gl::readTexture(counts, GL_RED, GL_FLOAT, sizeof(float));
  gl::api().DeleteProgram(program);
  std::vector<float> drawn(bytes.size() / sizeof(float));
  std::memcpy(drawn.data(), bytes.data(), bytes.size());

  std::vector<int> claimed(drawn.size(), 0);
  const auto states =
      engine.atlas()->memory().patchStates().readAll<glsl::PatchState>(engine.drawScene().patchInstances);
  std::size_t texels = 0;
  for (const std::uint32_t patch : engine.visibleSet()->read()) {
    const glsl::PatchState& state = states[patch];
    // The block's axes in the atlas: levelWidth and levelHeight of the packed level.
    const std::uint32_t x = state.origin & 0xffffu;
    const std::uint32_t y = state.origin >> 16u;
    for (std::uint32_t j = 0; j < (1u << glsl::levelHeight(state.level)); ++j)
      for (std::uint32_t i = 0; i < (1u << glsl::levelWidth(state.level)); ++i) {
        ++claimed[(y + j) * static_cast<std::size_t>(atlas.width()) + x + i];
        ++texels;
      }
  }
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    if (static_cast<int>(drawn[i]) == claimed[i] && claimed[i] <= 1) continue;
    if (++wrong <= 5)
      ADD_FAILURE() << "texel (" << i % static_cast<std::size_t>(atlas.width()) << ", "
                    << i / static_cast<std::size_t>(atlas.width()) << ") drawn " << drawn[i]
                    << " times, claimed " << claimed[i];
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(texels, 0u);
}

TEST_F(EngineGl, EveryTexelOfABlockIsShadedOnce) {
  auto engine = make(cornerScene(), smallAtlas());
  ASSERT_TRUE(engine);
  engine->update(0.0);
  for (const double distance : {0.0, 1.0, 6.0, 40.0}) {
    const View view =
        lookAt({4.5 + distance, 2.2, 1.5 + distance}, {1.5, 0.9, -2.0}, 60.0, kWidth, kHeight, 0.05);
    engine->rect(view);
    expectExactCoverage(*engine);
  }
}

TEST_F(EngineGl, TriplesSinglesAndMirroredPatchesCoverTheirBlocks) {
  Scene scene = test::emptyScene();
  const auto material = test::addMaterial(scene, unlit());
  scene.nodes.resize(2);
  scene.nodes[1].scale = {-1.0, 1.0, 1.0};
  // Odd fans leave triples and singles behind.
  for (int sides = 3; sides < 9; ++sides) {
    Primitive fan;
    fan.material = material;
    fan.firstVertex = static_cast<std::uint32_t>(scene.vertices.position.size());
    fan.firstIndex = static_cast<std::uint32_t>(scene.indices.size());
    const glm::vec3 centre(static_cast<float>(sides) * 1.5f - 4.0f, 0.0f, -6.0f);
    for (int i = 0; i < sides; ++i) {
      const float a = 6.2831853f * static_cast<float>(i) / static_cast<float>(sides);
      scene.vertices.position.push_back(centre + glm::vec3(std::cos(a), std::sin(a), 0.0f) * 0.7f);
      scene.vertices.normal.emplace_back(0.0f, 0.0f, 1.0f);
      scene.vertices.uv0.emplace_back(0.0f);
      scene.vertices.color.emplace_back(1.0f);
      fan.bounds.add(glm::dvec3(scene.vertices.position.back()));
    }
    for (int i = 2; i < sides; ++i)
      for (const int v : {0, i - 1, i})
        scene.indices.push_back(fan.firstVertex + static_cast<std::uint32_t>(v));
    fan.vertexCount = static_cast<std::uint32_t>(sides);
    fan.indexCount = static_cast<std::uint32_t>(3 * (sides - 2));
    scene.primitives.push_back(fan);
    test::place(scene, static_cast<std::uint32_t>(scene.primitives.size() - 1));
    test::place(scene, static_cast<std::uint32_t>(scene.primitives.size() - 1), 1);
  }
  test::finish(scene);
  auto engine = make(std::move(scene), smallAtlas());
  ASSERT_TRUE(engine);
  EXPECT_GT(engine->drawScene().trianglesTripled, 0u);
  EXPECT_GT(engine->drawScene().trianglesAlone, 0u);
  engine->update(0.0);
  const View view = lookAt({0, 0.5, 2}, {0, 0, -6}, 70.0, kWidth, kHeight, 0.05);
  engine->rect(view);
  const Image rect = engine->readColor();
  expectExactCoverage(*engine);
  engine->forward(view);
  const Image forward = engine->readColor();
  EXPECT_EQ(countCovered(rect), countCovered(forward));
}

TEST_F(EngineGl, LinearColoursComeBackExactly) {
  auto engine = make(cornerScene(), smallAtlas());
  ASSERT_TRUE(engine);
  engine->update(0.0);
  const View view = cornerView();
  engine->forward(view);
  const Image forward = engine->readColor();
  for (const DisplayMode mode : {DisplayMode::Geometry}) {
    engine->rect(view, mode);
    const Image rect = engine->readColor();
    EXPECT_EQ(countCovered(rect), countCovered(forward)) << "holes or extra pixels";
    // Encoded 8-bit values are interpolated where forward encodes interpolated values: a bend of the curve's
    // size.
    EXPECT_LT(meanDifference(rect, forward), 1.0);
    auto similarity = mssim(forward, rect);
    ASSERT_TRUE(similarity);
    EXPECT_GT(similarity->mean, 0.985);
  }
}

TEST_F(EngineGl, DeferredDisplayEqualsGeometryDisplay) {
  EngineOptions options = smallAtlas();
  options.request.displayDeferred = true;
  Scene scene = cornerScene();
  scene.nodes.emplace_back();
  scene.nodes.back().scale = {-1, 1, 1};
  scene.nodes.back().translation = {3.4, 0.2, 0.6};
  scene.instances.push_back({1, 3});
  test::finish(scene);
  auto engine = make(std::move(scene), options);
  ASSERT_TRUE(engine);
  engine->update(0.0);
  const View view = cornerView();
  engine->rect(view, DisplayMode::Geometry);
  const Image geometry = engine->readColor();
  engine->display(view, DisplayMode::Deferred);
  const Image deferred = engine->readColor();
  EXPECT_EQ(countCovered(geometry), countCovered(deferred));
  EXPECT_LT(meanDifference(geometry, deferred), 0.02);
  EXPECT_LE(largestDifference(geometry, deferred), 6);
}

TEST_F(EngineGl, AnotherCameraSeesWhatWasShaded) {
  // Shading is view-independent here, so a picture from another eye must equal one that is shaded for it
  // wherever the geometry was visible to the shaded view; the second view is a small step aside, with the
  // union as the visible set.
  Scene scene = cornerScene(false);
  scene.materials[1].baseColor.image = test::addCheckers(scene, 128, 8);
  test::finish(scene);
  auto engine = make(std::move(scene), smallAtlas());
  ASSERT_TRUE(engine);
  engine->update(0.0);
  const View shaded = cornerView();
  const View other = cornerView(0.35);
  const std::array<View, 2> both = {shaded, other};
  engine->findVisible(both);
  engine->place(both);
  engine->shade(shaded);
  engine->display(other);
  const Image displayed = engine->readColor();
  engine->rect(other);
  const Image rerendered = engine->readColor();
  engine->forward(other);
  const Image forward = engine->readColor();
  EXPECT_EQ(countCovered(displayed), countCovered(forward));
  auto against = mssim(rerendered, displayed);
  ASSERT_TRUE(against);
  EXPECT_GT(against->mean, 0.97);
  auto reference = mssim(forward, displayed);
  ASSERT_TRUE(reference);
  EXPECT_GT(reference->mean, 0.90);
}

TEST_F(EngineGl, UnionOfViewsIsTheUnion) {
  auto engine = make(cornerScene(), smallAtlas());
  ASSERT_TRUE(engine);
  engine->update(0.0);
  const std::array<View, 2> views = {cornerView(-2.0),
                                     lookAt({2, 2, -1}, {0.1, 0.2, -3.9}, 40.0, kWidth, kHeight, 0.05)};
  std::vector<std::uint32_t> expected;
  for (const View& view : views) {
    engine->findVisible({&view, 1});
    const auto one = engine->visibleSet()->read();
    expected.insert(expected.end(), one.begin(), one.end());
  }
  std::sort(expected.begin(), expected.end());
  expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
  engine->findVisible(views);
  auto found = engine->visibleSet()->read();
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, expected);
}

TEST_F(EngineGl, VisibleSetIsExact) {
  auto engine = make(cornerScene(), smallAtlas());
  ASSERT_TRUE(engine);
  engine->update(0.0);
  // Looking away from everything, and at one wall only.
  const View away = lookAt({4.5, 2.2, 1.5}, {9, 2.2, 6}, 60.0, kWidth, kHeight, 0.05);
  engine->rect(away);
  EXPECT_TRUE(engine->visibleSet()->read().empty());
  EXPECT_EQ(countCovered(engine->readColor()), 0u);
  const View wall = lookAt({2, 1.5, -3.5}, {2, 1.5, -4}, 40.0, kWidth, kHeight, 0.05);
  engine->rect(wall);
  for (const std::uint32_t patch : engine->visibleSet()->read()) {
    const auto instance = engine->drawScene().instanceOfPatch[patch];
    EXPECT_EQ(engine->drawScene().instances[instance].primitive, 1u);
  }
}

TEST_F(EngineGl, CullingMaskMirrorAndDoubleSideMatchForward) {
  Scene scene = test::emptyScene();
  Material single = unlit();
  single.baseColorFactor = {0.9f, 0.2f, 0.2f, 1.0f};
  Material both = unlit();
  both.doubleSided = true;
  both.baseColorFactor = {0.2f, 0.9f, 0.2f, 1.0f};
  Material leaf = unlit();
  leaf.alphaMode = AlphaMode::Mask;
  leaf.doubleSided = true;
  leaf.baseColor.image = test::addCheckers(scene, 64, 8, true);
  const std::array<std::uint32_t, 3> materials = {
      test::addMaterial(scene, single), test::addMaterial(scene, both), test::addMaterial(scene, leaf)};
  scene.nodes.resize(3);
  scene.nodes[1].scale = {1.0, 1.0, -1.0};
  scene.nodes[1].translation = {0.0, 1.3, -10.0};
  scene.nodes[2].translation = {0.0, -1.3, 0.0};
  scene.nodes[2].rotation = glm::angleAxis(glm::radians(180.0), glm::dvec3(0, 1, 0));
  scene.nodes[2].translation.z = -10.0;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const auto grid = test::addGrid(scene, {-2.5f + 1.8f * static_cast<float>(i), -0.5f, -5.0f}, {1.2f, 0, 0},
                                    {0, 1, 0}, 2, 2, materials[i]);
    for (std::uint32_t node = 0; node < 3; ++node) test::place(scene, grid, node);
  }
  test::finish(scene);
  EngineOptions options = smallAtlas();
  options.request.displayDeferred = true;
  auto engine = make(std::move(scene), options);
  ASSERT_TRUE(engine);
  engine->update(0.0);
  for (const double side : {1.0, -1.0}) {
    const View view = lookAt({0.3, 0.2, -5.0 + side * 5.0}, {0, 0, -5}, 60.0, kWidth, kHeight, 0.05);
    engine->forward(view);
    const Image forward = engine->readColor();
    EXPECT_GT(countCovered(forward), 2000u);
    for (const DisplayMode mode : {DisplayMode::Geometry, DisplayMode::Deferred}) {
      engine->rect(view, mode);
      const Image rect = engine->readColor();
      EXPECT_EQ(countCovered(rect), countCovered(forward))
          << "side " << side << " mode " << static_cast<int>(mode);
      auto similarity = mssim(forward, rect);
      ASSERT_TRUE(similarity);
      EXPECT_GT(similarity->mean, 0.95) << "side " << side << " mode " << static_cast<int>(mode);
    }
  }
}

TEST_F(EngineGl, BlendedSurfacesAreSortedAndEqualInBothMethods) {
  Scene scene = test::emptyScene();
  const auto solid = test::addMaterial(scene, unlit());
  Material red = unlit();
  red.alphaMode = AlphaMode::Blend;
  red.baseColorFactor = {1.0f, 0.0f, 0.0f, 0.5f};
  Material blue = red;
  blue.baseColorFactor = {0.0f, 0.0f, 1.0f, 0.5f};
  const auto redIndex = test::addMaterial(scene, red);
  const auto blueIndex = test::addMaterial(scene, blue);
  test::place(scene, test::addGrid(scene, {-2, -2, -6}, {4, 0, 0}, {0, 4, 0}, 4, 4, solid, true));
  // The nearer one is listed first: only sorting draws it last.
  test::place(scene, test::addGrid(scene, {-1, -1, -4}, {2, 0, 0}, {0, 2, 0}, 1, 1, redIndex));
  test::place(scene, test::addGrid(scene, {-1, -1, -5}, {2, 0, 0}, {0, 2, 0}, 1, 1, blueIndex));
  test::finish(scene);
  auto engine = make(std::move(scene), smallAtlas());
  ASSERT_TRUE(engine);
  engine->update(0.0);
  const View view = lookAt({0, 0, 0}, {0, 0, -6}, 50.0, kWidth, kHeight, 0.05);
  engine->forward(view);
  const Image forward = engine->readColor();
  const std::uint8_t* centre = forward.at(kWidth / 2, kHeight / 2);
  EXPECT_GT(centre[0], centre[2]) << "red is in front";
  engine->rect(view);
  const Image rect = engine->readColor();
  EXPECT_LT(meanDifference(forward, rect), 1.0);
}

TEST_F(EngineGl, AnAtlasWithBlendedSurfacesShowsThePicturesOfOneWithout) {
  Scene scene = test::emptyScene();
  Material glass;
  glass.alphaMode = AlphaMode::Blend;
  glass.baseColorFactor = {0.2f, 0.3f, 1.0f, 0.5f};
  const auto glassIndex = test::addMaterial(scene, glass);
  test::place(scene, test::addGrid(scene, {-3, -1, 1}, {6, 0, 0}, {0, 0, -8}, 6, 8));
  test::place(scene, test::addGrid(scene, {-1, -0.8f, -4}, {2, 0, 0}, {0, 2, 0}, 2, 2, glassIndex));
  test::place(scene, test::addGrid(scene, {-0.5f, -0.9f, -5}, {2, 0, 0}, {0, 2, 0}, 2, 2, glassIndex));
  test::finish(scene);
  const View view = lookAt({0, 0.5, 0}, {0, 0, -5}, 60.0, kWidth, kHeight, 0.05);
  for (const GathererKind gatherer : {GathererKind::Rect, GathererKind::Tess}) {
    std::array<Image, 2> displayed, drawn;
    for (const bool blended : {false, true}) {
      EngineOptions options = smallAtlas();
      options.gatherer = gatherer;
      options.request.blended = blended;
      auto engine = make(scene, options, test::lampStage());
      ASSERT_TRUE(engine);
      EXPECT_EQ(engine->drawScene().triangles, blended ? 112u : 96u);
      engine->update(0.0);
      engine->rect(view);
      displayed[blended ? 1 : 0] = engine->readColor();
      engine->forward(view);
      drawn[blended ? 1 : 0] = engine->readColor();
      // All of both panes is seen, one behind the other.
      std::size_t panes = 0;
      for (const std::uint32_t element : engine->visibleSet()->read()) {
        const std::uint32_t patch = gatherer == GathererKind::Tess ? element >> 2u : element;
        const DrawScene& draw = engine->drawScene();
        panes += draw.batches[draw.batchOf[draw.instanceOfPatch[patch]]].blend ? 1 : 0;
      }
      EXPECT_EQ(panes, !blended ? 0u : gatherer == GathererKind::Tess ? 16u : 8u);
    }
    // Blocks lie elsewhere, no more.
    EXPECT_LT(meanDifference(displayed[0], displayed[1]), 0.05);
    EXPECT_EQ(drawn[0].pixels, drawn[1].pixels) << "glass casts a shadow, or hides";
  }
  EngineOptions texel = smallAtlas();
  texel.gatherer = GathererKind::Texel;
  texel.request.blended = true;
  const auto refused = Engine::create(test::context(), scene, {}, texel);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("blended"), std::string::npos) << refused.error().message;
}

TEST_F(EngineGl, ShadowsFallAndLeave) {
  Scene scene = test::emptyScene();
  test::place(scene, test::addGrid(scene, {-3, 0, 3}, {6, 0, 0}, {0, 0, -6}, 6, 6));
  test::place(scene, test::addGrid(scene, {-0.8f, 1, 0.8f}, {1.6f, 0, 0}, {0, 0, -1.6f}, 1, 1));
  test::finish(scene);
  Light sun;
  sun.type = LightType::Directional;
  sun.castsShadow = true;
  StageLight lamp;
  lamp.light = sun;
  lamp.keys.push_back({0.0, {0, 5, 0}, {0.001, 0, 0}, glm::vec3(1.0f), 3.0f});
  Stage stage;
  stage.lights.push_back(lamp);
  stage.ambient = Ambient{glm::vec3(0.05f), glm::vec3(0.05f)};
  const View view = lookAt({0, 4, 4}, {0, 0, 0}, 60.0, kWidth, kHeight, 0.05);
  const auto luma = [&](bool casts) {
    Stage now = stage;
    now.lights[0].light.castsShadow = casts;
    auto engine = make(scene, smallAtlas(), now);
    if (!engine) return std::pair<int, int>(0, 0);
    engine->update(0.0);
    engine->rect(view);
    const Image image = engine->readColor();
    // Under the lid, seen past its front edge, and out in the open.
    const View eye = view;
    const auto at = [&](glm::dvec3 p) {
      const glm::dvec4 clip = viewProjection(eye, {0, 0, 0}) * glm::dvec4(p, 1.0);
      const int x = static_cast<int>((clip.x / clip.w * 0.5 + 0.5) * kWidth);
      const int y = static_cast<int>((0.5 - clip.y / clip.w * 0.5) * kHeight);
      return static_cast<int>(image.at(x, y)[1]);
    };
    return std::make_pair(at({0, 0, 0.5}), at({2, 0, 1}));
  };
  const auto with = luma(true);
  const auto without = luma(false);
  EXPECT_GT(with.second, 120);
  EXPECT_LT(with.first, with.second / 2) << "no shadow under the lid";
  EXPECT_NEAR(without.first, without.second, 12) << "shadow without a casting light";
}

TEST_F(EngineGl, OutOfMemoryLosesDetailAndNothingElse) {
  EngineOptions options = smallAtlas();
  options.atlas.memory.width = 256;
  options.atlas.memory.height = 256;
  options.atlas.memory.superblockLog2 = 8;  // one, for blocks of one width
  options.atlas.memory.pressureBias = false;
  auto engine = make(cornerScene(), options);
  ASSERT_TRUE(engine);
  engine->update(0.0);
  const View view = cornerView();
  engine->rect(view);
  const Image rect = engine->readColor();
  const RectStatistics stats = engine->atlas()->memory().readStatistics();
  EXPECT_GT(stats.failures, 0u);
  expectExactCoverage(*engine);
  engine->forward(view);
  EXPECT_EQ(countCovered(rect), countCovered(engine->readColor()));
}

TEST_F(EngineGl, NoTexelIsEverNonFinite) {
  Scene scene = cornerScene();
  Material metal;
  metal.roughnessFactor = 0.0f;
  metal.emissiveFactor = glm::vec3(60000.0f);
  scene.materials[1] = metal;
  for (std::size_t i = 0; i < scene.vertices.normal.size(); i += 7)
    scene.vertices.normal[i] = glm::vec3(0.0f);
  Light lamp;
  lamp.type = LightType::Point;
  lamp.intensity = 65504.0f;
  StageLight light;
  light.light = lamp;
  light.keys.push_back({0.0, {1.5, 0.0, -2.0}, {0, 0, 0}, glm::vec3(1.0f), 65504.0f});  // on the floor itself
  Stage stage;
  stage.lights.push_back(light);
  EngineOptions options = smallAtlas();
  options.atlas.format = AtlasFormat::Rgba16f;
  auto engine = make(std::move(scene), options, stage);
  ASSERT_TRUE(engine);
  engine->update(0.0);
  engine->rect(cornerView());
  EXPECT_EQ(engine->nonFiniteTexels(), 0u);
}

TEST_F(EngineGl, DebugViewsShowSomethingOfEverything) {
  auto engine = make(cornerScene(), smallAtlas());
  ASSERT_TRUE(engine);
  engine->update(0.0);
  const View view = cornerView();
  engine->rect(view);
  const std::size_t covered = countCovered(engine->readColor());
  for (const DebugView what :
       {DebugView::Ids, DebugView::Patches, DebugView::Levels, DebugView::TexelDensity}) {
    const auto image = engine->debugView(what, view);
    ASSERT_TRUE(image) << image.error().message;
    std::size_t shown = 0;
    for (std::size_t i = 0; i < image->pixels.size(); i += 4)
      shown += std::max({image->pixels[i], image->pixels[i + 1], image->pixels[i + 2]}) > 40 ? 1 : 0;
    EXPECT_EQ(shown, covered) << static_cast<int>(what);
  }
  const auto blocks = engine->debugView(DebugView::Blocks, view);
  ASSERT_TRUE(blocks);
  EXPECT_EQ(blocks->width, engine->atlas()->atlas().texture.width());
}

}  // namespace
}  // namespace tessera
