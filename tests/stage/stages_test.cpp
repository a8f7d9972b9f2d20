// The stages in assets/stages with their scenes: they load, their lights are sane, and their paths are fit to
// fly.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "engine/scene/gltf.hpp"
#include "engine/scene/stage.hpp"

namespace tessera {
namespace {

constexpr int kRate = 240;  // samples a second

std::filesystem::path sceneFile(const std::string& name) {
  const std::filesystem::path own = std::filesystem::path(TESSERA_SOURCE_DIR) / "assets" / (name + ".glb");
  if (std::filesystem::exists(own)) return own;
  return std::filesystem::path(TESSERA_SHARED_DIR) / "scenes" / (name + ".glb");
}

Result<Stage> stageOf(const std::string& name) {
  return loadStage(std::filesystem::path(TESSERA_SOURCE_DIR) / "assets/stages" / (name + ".json"));
}

/// Squared distance from p to a triangle: to its plane where p lies above it, else to the nearest edge.
double squaredDistance(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 n = glm::cross(b - a, c - a);
  const auto edge = [&](const glm::dvec3& from, const glm::dvec3& to) {
    const glm::dvec3 along = to - from;
    const double length = glm::dot(along, along);
    const double s = length > 0.0 ? std::clamp(glm::dot(p - from, along) / length, 0.0, 1.0) : 0.0;
    const glm::dvec3 gap = p - (from + s * along);
    return glm::dot(gap, gap);
  };
  const auto inside = [&](const glm::dvec3& from, const glm::dvec3& to) {
    return glm::dot(glm::cross(to - from, p - from), n) >= 0.0;
  };
  const double area = glm::dot(n, n);
  if (area > 0.0 && inside(a, b) && inside(b, c) && inside(c, a)) {
    const double height = glm::dot(p - a, n);
    return height * height / area;
  }
  return std::min({edge(a, b), edge(b, c), edge(c, a)});
}

/// The least distance from any of the points to any triangle of the scene at rest; `reach` where it is more.
double clearance(const Scene& scene, const std::vector<glm::dvec3>& points, double reach) {
  SceneState state;
  evaluate(scene, 0.0, state);
  Box around;
  for (const glm::dvec3& p : points) {
    around.add(p - reach);
    around.add(p + reach);
  }
  const auto apart = [](const Box& a, const Box& b) {
    return glm::any(glm::lessThan(a.max, b.min)) || glm::any(glm::lessThan(b.max, a.min));
  };
  double least = reach * reach;
  for (const Instance& instance : scene.instances) {
    const Primitive& primitive = scene.primitives[instance.primitive];
    for (std::uint32_t i = 0; i < primitive.indexCount; i += 3) {
      std::array<glm::dvec3, 3> corner;
      Box box;
      for (std::uint32_t k = 0; k < 3; ++k) {
        const glm::vec3 local = scene.vertices.position[scene.indices[primitive.firstIndex + i + k]];
        corner[k] = glm::dvec3(state.world[instance.node] * glm::dvec4(local, 1.0));
        box.add(corner[k]);
      }
      if (apart(box, around)) continue;
      for (const glm::dvec3& p : points) {
        if (apart(box, Box{p - reach, p + reach})) continue;
        least = std::min(least, squaredDistance(p, corner[0], corner[1], corner[2]));
      }
    }
  }
  return std::sqrt(least);
}

class Stages : public ::testing::TestWithParam<const char*> {};

TEST_P(Stages, LoadsWithATourOfTenSeconds) {
  const Result<Stage> stage = stageOf(GetParam());
  ASSERT_TRUE(stage) << stage.error().message;
  ASSERT_EQ(stage->paths.size(), 1u);
  EXPECT_EQ(stage->paths[0].name, "tour");
  EXPECT_EQ(stage->paths[0].keys.front().time, 0.0);
  EXPECT_EQ(stage->paths[0].keys.back().time, 10.0);
  EXPECT_TRUE(stage->ambient);
}

// No jump: a step is never longer than five times the mean step, and neither eye nor view direction turns
// sharply.
TEST_P(Stages, TheTourMovesWithoutJumps) {
  const Result<Stage> stage = stageOf(GetParam());
  ASSERT_TRUE(stage) << stage.error().message;
  const CameraPath& path = stage->paths.at(0);
  const int count = 10 * kRate;
  double length = 0.0;
  double longest = 0.0;
  double sharpest = 1.0;
  CameraKey last = sampleCamera(path, 0.0);
  for (int i = 1; i <= count; ++i) {
    const CameraKey key = sampleCamera(path, static_cast<double>(i) / kRate);
    const double step = glm::length(key.eye - last.eye);
    length += step;
    longest = std::max(longest, step);
    const glm::dvec3 view = glm::normalize(key.target - key.eye);
    sharpest = std::min(sharpest, glm::dot(view, glm::normalize(last.target - last.eye)));
    EXPECT_LT(std::abs(view.y), 0.98) << "looks straight up or down at " << key.time << " s";
    EXPECT_GE(key.fovY, 30.0);
    EXPECT_LE(key.fovY, 80.0);
    last = key;
  }
  EXPECT_GT(length, 5.0);
  EXPECT_LT(longest, 5.0 * length / count);
  EXPECT_GT(sharpest, std::cos(glm::radians(0.75))) << "turns faster than 180 degrees a second";
}

TEST_P(Stages, TheTourStaysInsideItsSceneAndClearOfIt) {
  const std::filesystem::path file = sceneFile(GetParam());
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
  const Result<Scene> scene = loadGltf(file, {.loadImages = false, .progress = {}});
  ASSERT_TRUE(scene) << scene.error().message;
  const Result<Stage> stage = stageOf(GetParam());
  ASSERT_TRUE(stage) << stage.error().message;
  std::vector<glm::dvec3> eyes;
  for (int i = 0; i <= 10 * kRate; ++i) {
    const glm::dvec3 eye = sampleCamera(stage->paths.at(0), static_cast<double>(i) / kRate).eye;
    EXPECT_TRUE(glm::all(glm::greaterThan(eye, scene->bounds.min)) &&
                glm::all(glm::lessThan(eye, scene->bounds.max)))
        << "at " << i << "/" << kRate << " s";
    if (i % 10 == 0) eyes.push_back(eye);
  }
  EXPECT_GT(clearance(*scene, eyes, 0.5), 0.25) << "metres to the nearest triangle";
}

TEST_P(Stages, LightsAreFiniteAndSomeCastShadows) {
  const std::filesystem::path file = sceneFile(GetParam());
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
  const Result<Scene> scene = loadGltf(file, {.loadImages = false, .progress = {}});
  ASSERT_TRUE(scene) << scene.error().message;
  const Result<Stage> stage = stageOf(GetParam());
  ASSERT_TRUE(stage) << stage.error().message;
  SceneState state;
  for (int i = 0; i < 100; ++i) {
    const double time = i / 10.0;
    evaluate(*scene, time, state);
    const std::vector<LightSample> lights = evaluateLights(*scene, state, &*stage, time);
    EXPECT_TRUE(std::ranges::any_of(lights, &LightSample::castsShadow));
    for (const LightSample& light : lights) {
      EXPECT_NEAR(glm::length(light.direction), 1.0, 1e-9);
      EXPECT_TRUE(glm::all(glm::greaterThanEqual(light.radiance, glm::vec3(0.0f))));
      if (light.type == LightType::Directional) continue;
      EXPECT_TRUE(glm::all(glm::greaterThan(light.position, scene->bounds.min)) &&
                  glm::all(glm::lessThan(light.position, scene->bounds.max)));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Stages, ::testing::Values("atrium", "sponza", "warehouse", "candela_city"),
                         [](const auto& instance) { return std::string(instance.param); });

// What the atrium promises to hold, so that a change to its script cannot lose it.
TEST(Atrium, HoldsWhatItIsMadeFor) {
  const Result<Scene> scene = loadGltf(sceneFile("atrium"));
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_TRUE(scene->warnings.empty()) << scene->warnings.front();
  EXPECT_GE(scene->triangleCount(), 60'000u);
  EXPECT_LE(scene->triangleCount(), 100'000u);
  SceneState state;
  evaluate(*scene, 0.0, state);
  std::size_t objects = 0;
  std::size_t mirrored = 0;
  for (std::size_t i = 0; i < scene->nodes.size(); ++i) {
    if (scene->nodes[i].mesh == kNone) continue;
    ++objects;
    if (mirrors(state.world[i])) ++mirrored;
  }
  EXPECT_GT(objects, 150u);
  EXPECT_GT(mirrored, 20u);
  EXPECT_LT(std::filesystem::file_size(sceneFile("atrium")), 3'000'000u);
  EXPECT_GE(scene->lights.size(), 4u);
  EXPECT_GE(std::ranges::count_if(scene->lights, &Light::castsShadow), 3);
  EXPECT_LT(std::ranges::count_if(scene->lights, &Light::castsShadow), std::ssize(scene->lights));
  EXPECT_GE(scene->cameras.size(), 2u);
  EXPECT_EQ(scene->animations.size(), 2u);
  EXPECT_TRUE(scene->animated());
  const auto material = [&](auto has) { return std::ranges::any_of(scene->materials, has); };
  EXPECT_TRUE(material([](const Material& m) { return m.alphaMode == AlphaMode::Mask; }));
  EXPECT_EQ(std::ranges::count(scene->materials, AlphaMode::Blend, &Material::alphaMode), 1);
  EXPECT_TRUE(material([](const Material& m) { return m.unlit; }));
  EXPECT_TRUE(material([](const Material& m) { return m.emissiveFactor.x > 1.0f; }));
  EXPECT_TRUE(material([](const Material& m) { return m.normal.used(); }));
  EXPECT_TRUE(material([](const Material& m) { return m.occlusion.used() && m.occlusion.uvSet == 1; }));
  EXPECT_TRUE(material([](const Material& m) { return m.baseColor.hasTransform; }));
  EXPECT_TRUE(material([](const Material& m) { return m.metallicRoughness.used(); }));
  EXPECT_TRUE(std::ranges::any_of(scene->primitives, &Primitive::hasColor));
}

// The fan turns once in four seconds, the lamp is back after eight and in the middle of its rail at two and
// six; and the light of the lamp goes with it.
TEST(Atrium, FanAndLampMove) {
  const Result<Scene> scene = loadGltf(sceneFile("atrium"), {.loadImages = false, .progress = {}});
  ASSERT_TRUE(scene) << scene.error().message;
  const auto find = [&](const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(scene->nodes, name, &Node::name) -
                                    scene->nodes.begin());
  };
  const std::size_t fan = find("fan blades");
  const std::size_t lamp = find("moving lamp");
  ASSERT_LT(fan, scene->nodes.size());
  ASSERT_LT(lamp, scene->nodes.size());
  SceneState state;
  const auto at = [&](double time) -> const SceneState& {
    evaluate(*scene, time, state);
    return state;
  };
  EXPECT_NEAR(at(0.5).world[fan][0].x, std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(at(2.0).world[fan][0].x, -1.0, 1e-6);
  EXPECT_NEAR(at(4.5).world[fan][0].x, std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(at(0.0).world[lamp][3].x, -4.8, 1e-6);
  EXPECT_NEAR(at(2.0).world[lamp][3].x, 0.0, 1e-6);
  EXPECT_NEAR(at(4.0).world[lamp][3].x, 4.8, 1e-6);
  EXPECT_NEAR(at(6.0).world[lamp][3].x, 0.0, 1e-6);
  // Halfway through the first two seconds: h01 = 1/2, and h11 = -1/8 of the speed of 3.2 m/s over 2 s.
  EXPECT_NEAR(at(1.0).world[lamp][3].x, 0.5 * -4.8 - 2.0 * 0.125 * 3.2, 1e-6);
  const std::vector<LightSample> lights = evaluateLights(*scene, at(4.0), nullptr, 4.0);
  const auto moving = std::ranges::find_if(lights, &LightSample::moves);
  ASSERT_NE(moving, lights.end());
  EXPECT_NEAR(moving->position.x, 4.8, 1e-6);
  EXPECT_NEAR(moving->direction.y, -1.0, 1e-6);
}

/// Scenes of others: animations keep every transform finite and rigid parts rigid.
class OtherScenes : public ::testing::TestWithParam<const char*> {};

TEST_P(OtherScenes, AnimationsStayFinite) {
  const std::filesystem::path file = std::filesystem::path(TESSERA_SHARED_DIR) / "scenes" / GetParam();
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
  const Result<Scene> scene = loadGltf(file, {.loadImages = false, .progress = {}});
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_TRUE(scene->animated());
  SceneState first;
  evaluate(*scene, 0.0, first);
  bool moved = false;
  for (int i = 1; i < 50; ++i) {
    SceneState state;
    evaluate(*scene, i * 0.173, state);
    for (std::size_t k = 0; k < state.world.size(); ++k) {
      for (int c = 0; c < 4; ++c) {
        ASSERT_TRUE(glm::all(glm::lessThan(glm::abs(state.world[k][c]), glm::dvec4(1e6)))) << "node " << k;
      }
      moved = moved || state.world[k] != first.world[k];
    }
  }
  EXPECT_TRUE(moved);
}

INSTANTIATE_TEST_SUITE_P(All, OtherScenes,
                         ::testing::Values("feature/CesiumMilkTruck.glb", "littlest_tokyo.glb",
                                           "candela_city.glb"));

}  // namespace
}  // namespace tessera
