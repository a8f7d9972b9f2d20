// Which passes and permutations a scene makes: CPU only.
#include <algorithm>
#include <array>

#include <glad/gl.h>
#include <gtest/gtest.h>

#include "engine/frame/batches.hpp"
#include "engine/frame/features.hpp"
#include "engine/frame/graph.hpp"
#include "engine/frame/view.hpp"
#include "tests/frame/small_scenes.hpp"

namespace tessera {
namespace {

using Names = std::vector<std::string>;

Names passNames(const FrameGraph& graph) {
  Names names;
  for (const Pass& pass : graph.passes()) names.push_back(pass.name);
  return names;
}

Names effectNames(const SceneFeatures& features) {
  Names names;
  for (const Effect& effect : features.effects) names.push_back(effect.name);
  return names;
}

Scene oneQuad(const Material& material) {
  Scene scene = test::emptyScene();
  const auto index = test::addMaterial(scene, material);
  test::place(scene, test::addGrid(scene, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1, 1, index));
  test::finish(scene);
  return scene;
}

void addLight(Scene& scene, bool casts) {
  Light light;
  light.name = "lamp";
  light.castsShadow = casts;
  scene.lights.push_back(light);
  Node node;
  node.name = "lamp node";
  node.light = static_cast<std::uint32_t>(scene.lights.size() - 1);
  scene.nodes.push_back(node);
}

const FrameRequest kRect{.rect = true};
const FrameRequest kForward{.forward = true};

TEST(Plan, BaselinesTakeForwardsPicture) {
  const SceneFeatures features = findFeatures(oneQuad({}), nullptr);
  EXPECT_EQ(passNames(planFrame(features, {.forward = true, .upsample = true, .warp = true})),
            (Names{"forward", "upsample-rows", "upsample-columns", "warp"}));
  // Without forward there is nothing to take.
  EXPECT_EQ(passNames(planFrame(features, {.upsample = true, .warp = true})), Names{});
}

TEST(Plan, PlainSceneHasNoEffects) {
  const SceneFeatures features = findFeatures(oneQuad({}), nullptr);
  EXPECT_TRUE(features.effects.empty());
  EXPECT_EQ(passNames(planFrame(features, kForward)), (Names{"forward"}));
  EXPECT_EQ(passNames(planFrame(features, kRect)),
            (Names{"id", "mark", "levels", "memory", "emit", "gather", "display"}));
  EXPECT_EQ(permutationOf({}, false, features).name(), "plain");
}

TEST(Plan, LightWithoutShadowMakesNoShadowPass) {
  Scene scene = oneQuad({});
  addLight(scene, false);
  const SceneFeatures features = findFeatures(scene, nullptr);
  EXPECT_EQ(effectNames(features), (Names{"punctual-lights"}));
  EXPECT_NE(features.effects[0].reason.find("lamp"), std::string::npos);
  EXPECT_EQ(planFrame(features, kForward).find("shadow"), nullptr);
  EXPECT_EQ(permutationOf({}, false, features).name(), "LIGHTS");
}

TEST(Plan, CastingLightMakesTheShadowPass) {
  Scene scene = oneQuad({});
  addLight(scene, true);
  const SceneFeatures features = findFeatures(scene, nullptr);
  EXPECT_EQ(passNames(planFrame(features, kForward)), (Names{"shadow", "forward"}));
  EXPECT_EQ(permutationOf({}, false, features).name(), "LIGHTS SHADOWS");
}

TEST(Plan, LightsShineOnNothingWhenAllIsUnlit) {
  Material material;
  material.unlit = true;
  Scene scene = oneQuad(material);
  addLight(scene, true);
  const SceneFeatures features = findFeatures(scene, nullptr);
  EXPECT_EQ(effectNames(features), (Names{"unlit"}));
  EXPECT_EQ(passNames(planFrame(features, kForward)), (Names{"forward"}));
  EXPECT_EQ(permutationOf(material, false, features).name(), "UNLIT");
}

TEST(Plan, MaterialsThatNothingUsesCallForNothing) {
  Scene scene = oneQuad({});
  Material fancy;
  fancy.alphaMode = AlphaMode::Blend;
  fancy.normal.image = 0;
  test::addMaterial(scene, fancy);
  EXPECT_TRUE(findFeatures(scene, nullptr).effects.empty());
}

TEST(Plan, BlendMakesTheTransparentPassAndNoAtlasByItself) {
  Material glass;
  glass.alphaMode = AlphaMode::Blend;
  glass.name = "glass";
  const SceneFeatures features = findFeatures(oneQuad(glass), nullptr);
  EXPECT_EQ(features.effects[0].reason, "material 'glass'");
  EXPECT_EQ(passNames(planFrame(features, kRect)), (Names{"rect-transparent"}));
  EXPECT_EQ(passNames(planFrame(features, kForward)), (Names{"forward-transparent"}));
}

TEST(Plan, AnAtlasHoldsBlendedSurfacesByRequestOnly) {
  Material glass;
  glass.alphaMode = AlphaMode::Blend;
  FrameRequest request = kRect;
  request.blended = true;
  EXPECT_EQ(passNames(planFrame(findFeatures(oneQuad(glass), nullptr), request)),
            (Names{"id", "mark", "mark-blended", "levels", "memory", "emit", "gather", "display",
                   "rect-transparent"}));
  const SceneFeatures opaque = findFeatures(oneQuad({}), nullptr);
  EXPECT_EQ(passNames(planFrame(opaque, request)), passNames(planFrame(opaque, kRect)));
}

TEST(Plan, MaskAddsItsTestOnlyToMaskedMaterials) {
  Material leaf;
  leaf.alphaMode = AlphaMode::Mask;
  leaf.baseColor.image = 0;
  const SceneFeatures features = findFeatures(oneQuad(leaf), nullptr);
  EXPECT_TRUE(features.mask);
  EXPECT_EQ(depthPermutationOf(leaf, false).name(), "BASE_TEX MASK");
  EXPECT_EQ(depthPermutationOf({}, true).name(), "plain");
}

TEST(Plan, PermutationsDropImpossiblePairs) {
  Material material;
  material.unlit = true;
  material.normal.image = 0;
  material.emissive.image = 0;
  material.doubleSided = true;
  SceneFeatures features;
  features.lights = features.shadows = features.hemisphere = true;
  EXPECT_EQ(permutationOf(material, false, features).name(), "UNLIT");
  material.unlit = false;
  material.emissiveFactor = glm::vec3(0.0f);
  EXPECT_EQ(permutationOf(material, false, features).name(),
            "NORMAL_TEX USES_UV0 DOUBLE_SIDED LIGHTS SHADOWS HEMISPHERE");
}

TEST(Plan, DisplayModesAndPrepassAreByRequest) {
  const SceneFeatures features = findFeatures(oneQuad({}), nullptr);
  EXPECT_EQ(passNames(planFrame(features, {.rect = true, .displayGeometry = false, .displayDeferred = true})),
            (Names{"id", "mark", "levels", "memory", "emit", "gather", "display-deferred"}));
  EXPECT_EQ(passNames(planFrame(features, {.forward = true, .depthPrepass = true})),
            (Names{"depth-prepass", "forward"}));
  EXPECT_TRUE(planFrame(features, {}).passes().empty());
}

TEST(Plan, TheLensIsByRequestAndSeesWhatIsDrawn) {
  const SceneFeatures features = findFeatures(oneQuad({}), nullptr);
  EXPECT_EQ(passNames(planFrame(features, {.forward = true, .lens = true})), (Names{"forward", "distort"}));
  const FrameGraph both = planFrame(features, {.rect = true, .forward = true, .lens = true});
  ASSERT_NE(both.find("distort"), nullptr);
  Names reads;
  for (const Use& use : both.find("distort")->reads) reads.push_back(use.resource);
  EXPECT_EQ(reads, (Names{"rect-color", "forward-color"}));
  EXPECT_EQ(planFrame(features, kRect).find("distort"), nullptr);
  EXPECT_TRUE(planFrame(features, {.lens = true}).passes().empty()) << "nothing is drawn to be seen";
}

TEST(Graph, KeepsOnlyWhatOutputsNeed) {
  FrameGraph graph;
  graph.add({"a", "s", {}, {{"x", Access::Storage}}});
  graph.add({"b", "s", {}, {{"y", Access::Storage}}});
  graph.add({"c", "s", {{"x", Access::Texture}}, {{"z", Access::Target}}});
  const std::array<std::string, 1> outputs = {"z"};
  graph.keep(outputs);
  EXPECT_EQ(passNames(graph), (Names{"a", "c"}));
  const std::string text = graph.graphviz();
  EXPECT_NE(text.find("\"a\" -> \"c\" [label=\"x\"]"), std::string::npos);
  EXPECT_EQ(text.find("\"b\""), std::string::npos);
}

TEST(Graph, BarriersFollowTheDeclarations) {
  BarrierTracker tracker;
  const Pass write{"w", "s", {}, {{"x", Access::Storage}}};
  const Pass fetch{"f", "s", {{"x", Access::Texture}}, {}};
  const Pass draw{"d", "s", {{"x", Access::Indirect}, {"x", Access::Storage}}, {}};
  EXPECT_EQ(tracker.before(fetch), 0u);
  EXPECT_EQ(tracker.before(write), 0u);
  EXPECT_EQ(tracker.before(fetch), std::uint32_t{GL_TEXTURE_FETCH_BARRIER_BIT});
  EXPECT_EQ(tracker.before(fetch), 0u);
  EXPECT_EQ(tracker.before(draw), std::uint32_t{GL_COMMAND_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT});
  // Writing again after a write is ordered too.
  EXPECT_EQ(tracker.before(write), 0u);
  EXPECT_EQ(tracker.before(write), std::uint32_t{GL_SHADER_STORAGE_BARRIER_BIT});
}

TEST(View, ProjectionIsReversedAndInfinite) {
  const View view = lookAt({1, 2, 3}, {1, 2, -7}, 60.0, 800, 600, 0.1);
  const glm::dmat4 m = viewProjection(view, {0, 0, 0});
  const auto project = [&](glm::dvec3 p) {
    const glm::dvec4 clip = m * glm::dvec4(p, 1.0);
    return glm::dvec3(clip) / clip.w;
  };
  EXPECT_NEAR(project({1, 2, 2.9}).z, 1.0, 1e-12);
  EXPECT_NEAR(project({1, 2, -1e9}).z, 0.0, 1e-9);
  // Half the height at distance d is d tan 30.
  EXPECT_NEAR(project({1, 2 + std::tan(glm::radians(30.0)) * 5.0, -2}).y, 1.0, 1e-12);
  EXPECT_NEAR(project({1 + std::tan(glm::radians(30.0)) * 5.0 * 800.0 / 600.0, 2, -2}).x, 1.0, 1e-12);
}

TEST(View, PixelRaysMeetTheProjection) {
  const View view = lookAt({1, 2, 3}, {4, -1, -2}, 75.0, 640, 480, 0.1);
  const glm::dmat3 rays = pixelToRay(view);
  const glm::dmat4 m = viewProjection(view, {0, 0, 0});
  for (const glm::dvec2 pixel : {glm::dvec2(0, 0), glm::dvec2(320, 240), glm::dvec2(633.5, 17.25)}) {
    const glm::dvec3 p = view.eye + rays * glm::dvec3(1.0, pixel) * 7.0;
    const glm::dvec4 clip = m * glm::dvec4(p, 1.0);
    EXPECT_NEAR((clip.x / clip.w * 0.5 + 0.5) * 640.0, pixel.x, 1e-9);
    EXPECT_NEAR((clip.y / clip.w * 0.5 + 0.5) * 480.0, pixel.y, 1e-9);
  }
}

TEST(View, FrustumKeepsWhatItTouches) {
  const View view = lookAt({0, 0, 0}, {0, 0, -1}, 60.0, 100, 100, 0.1);
  const Frustum frustum = frustumOf(viewProjection(view, {0, 0, 0}));
  const auto box = [](glm::dvec3 centre, double half) {
    Box b;
    b.add(centre - half);
    b.add(centre + half);
    return b;
  };
  EXPECT_TRUE(frustum.touches(box({0, 0, -5}, 0.1)));
  EXPECT_TRUE(frustum.touches(box({0, 0, -1e9}, 0.1)));
  EXPECT_TRUE(frustum.touches(box({0, 0, 0}, 10.0)));
  EXPECT_FALSE(frustum.touches(box({0, 0, 5}, 0.1)));
  EXPECT_FALSE(frustum.touches(box({10, 0, -5}, 0.1)));
  EXPECT_FALSE(frustum.touches(Box{}));
}

TEST(Batches, SortByStateAndCountEntries) {
  Scene scene = test::emptyScene();
  Material mask;
  mask.alphaMode = AlphaMode::Mask;
  Material both;
  both.doubleSided = true;
  Material glass;
  glass.alphaMode = AlphaMode::Blend;
  const auto maskIndex = test::addMaterial(scene, mask);
  const auto bothIndex = test::addMaterial(scene, both);
  const auto glassIndex = test::addMaterial(scene, glass);
  for (const std::uint32_t material : {maskIndex, glassIndex, bothIndex, 0u, maskIndex})
    test::place(scene, test::addGrid(scene, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 2, 3, material));
  test::finish(scene);
  const DrawScene draw = prepare(scene, {});
  ASSERT_EQ(draw.batches.size(), 3u);
  EXPECT_EQ(draw.batches[0].material, 0u);
  EXPECT_EQ(draw.batches[1].material, bothIndex);
  EXPECT_EQ(draw.batches[2].material, maskIndex);
  EXPECT_EQ(draw.batches[2].instanceCount, 2u);
  EXPECT_EQ(draw.blended.size(), 1u);
  EXPECT_EQ(draw.trianglesPaired + draw.trianglesTripled + draw.trianglesAlone, 4u * 12u);
  std::uint32_t entries = 0;
  for (const Batch& batch : draw.batches) {
    EXPECT_EQ(batch.firstEntry, entries);
    entries += batch.entryCapacity;
  }
  EXPECT_EQ(draw.entries, entries);
  EXPECT_EQ(draw.instanceOfPatch.size(), draw.patchInstances);
  const DrawScene all = prepare(scene, {}, true);
  ASSERT_EQ(all.batches.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(all.batches[i].blend, i == 3);
  EXPECT_EQ(all.batches[3].material, glassIndex);
  EXPECT_EQ(all.batches[3].firstEntry, draw.entries);
  EXPECT_EQ(all.blended.size(), 1u);
  EXPECT_EQ(all.triangles, draw.triangles + 12u);
}

TEST(Batches, CullMergesNeighboursAndSplitsMirrored) {
  Scene scene = test::emptyScene();
  scene.nodes.resize(4);
  scene.nodes[1].translation = {2, 0, 0};
  scene.nodes[2].translation = {4, 0, 0};
  scene.nodes[2].scale = {-1, 1, 1};
  scene.nodes[3].translation = {0, 0, 50};  // behind the eye
  const auto grid = test::addGrid(scene, {0, 0, -10}, {1, 0, 0}, {0, 1, 0}, 1, 1);
  for (std::uint32_t node = 0; node < 4; ++node) test::place(scene, grid, node);
  test::finish(scene);
  const DrawScene draw = prepare(scene, {});
  SceneState state;
  evaluate(scene, 0.0, state);
  std::vector<bool> mirrored;
  for (const Instance& instance : draw.instances) mirrored.push_back(mirrors(state.world[instance.node]));
  const View view = lookAt({1, 0, 0}, {1, 0, -1}, 90.0, 100, 100, 0.1);
  const auto bounds = instanceBounds(scene, draw.instances, state);
  const Frustum frustum = frustumOf(viewProjection(view, {0, 0, 0}));
  const DrawList list = cull(scene, draw, bounds, mirrored, {&frustum, 1});
  ASSERT_EQ(list.ranges.size(), 2u);
  EXPECT_FALSE(list.ranges[0].mirrored);
  EXPECT_TRUE(list.ranges[1].mirrored);
  ASSERT_EQ(list.commands.size(), 2u);
  EXPECT_EQ(list.commands[0].instanceCount, 2u);
  EXPECT_EQ(list.triangles, 6u);
}

}  // namespace
}  // namespace tessera
