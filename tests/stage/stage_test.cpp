// Stage and path files, good and bad; camera splines and lights against hand-worked values.
#include "engine/scene/stage.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace tessera {
namespace {

std::filesystem::path write(const std::string& text) {
  const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::filesystem::path path = std::filesystem::path(TESSERA_BINARY_DIR) / ("stage_" + test + ".json");
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

Result<Stage> stageOf(const std::string& text) { return loadStage(write(text)); }

void expectNear(const glm::dvec3& actual, const glm::dvec3& expected, double tolerance = 1e-12) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "component " << i;
}

const char* const kGood = R"({
  "scene_lights": false, "scene_lights_cast_shadows": true, "exposure": 0.5,
  "ambient": {"sky": [0.5, 0.25, 0.125], "ground": [0, 0.5, 1]},
  "lights": [
    {"name": "sun", "type": "directional", "position": [0, 10, 0], "target": [0, 0, 0], "intensity": 4,
     "cast_shadow": true},
    {"type": "spot", "range": 12, "inner_cone": 10, "outer_cone": 30, "color": [1, 0.5, 0], "target": [0, 0, 0],
     "keyframes": [{"t": 1, "position": [0, 4, 0], "intensity": 8},
                   {"t": 3, "position": [4, 4, 0], "intensity": 16, "color": [0, 0.5, 1]}]},
    {"type": "point", "position": [1, 2, 3], "loop": false}],
  "paths": [{"name": "a", "keyframes": [{"t": 0, "eye": [0, 0, 0], "target": [0, 0, -1], "fov_y": 60}]},
            {"name": "b", "keyframes": [{"t": 0.5, "eye": [0, 0, 0], "target": [1, 0, 0], "fov_y": 45.5},
                                        {"t": 1, "eye": [1, 0, 0], "target": [2, 0, 0], "fov_y": 50}]}]})";

TEST(StageFile, ReadsEveryField) {
  const Result<Stage> stage = stageOf(kGood);
  ASSERT_TRUE(stage) << stage.error().message;
  EXPECT_FALSE(stage->sceneLights);
  EXPECT_TRUE(stage->sceneLightsCastShadows);
  EXPECT_EQ(stage->exposure, 0.5f);
  ASSERT_TRUE(stage->ambient);
  EXPECT_EQ(stage->ambient->sky, glm::vec3(0.5f, 0.25f, 0.125f));
  EXPECT_EQ(stage->ambient->ground, glm::vec3(0.0f, 0.5f, 1.0f));
  EXPECT_TRUE(stage->ambient->hemisphere());
  ASSERT_EQ(stage->lights.size(), 3u);
  EXPECT_EQ(stage->lights[0].light.name, "sun");
  EXPECT_EQ(stage->lights[0].light.type, LightType::Directional);
  EXPECT_TRUE(stage->lights[0].light.castsShadow);
  ASSERT_EQ(stage->lights[0].keys.size(), 1u);
  EXPECT_EQ(stage->lights[0].keys[0].intensity, 4.0f);
  EXPECT_EQ(stage->lights[0].keys[0].position, glm::dvec3(0, 10, 0));
  const StageLight& spot = stage->lights[1];
  EXPECT_EQ(spot.light.type, LightType::Spot);
  EXPECT_FALSE(spot.light.castsShadow);
  EXPECT_EQ(spot.light.range, 12.0f);
  EXPECT_FLOAT_EQ(spot.light.innerCone, 0.174532925f);
  EXPECT_FLOAT_EQ(spot.light.outerCone, 0.523598776f);
  ASSERT_EQ(spot.keys.size(), 2u);
  EXPECT_EQ(spot.keys[0].color, glm::vec3(1.0f, 0.5f, 0.0f));  // from the light
  EXPECT_EQ(spot.keys[1].color, glm::vec3(0.0f, 0.5f, 1.0f));  // its own
  EXPECT_EQ(spot.keys[1].target, glm::dvec3(0.0));
  EXPECT_EQ(spot.keys[1].time, 3.0);
  EXPECT_TRUE(spot.loop);
  EXPECT_EQ(stage->lights[2].light.type, LightType::Point);
  EXPECT_FALSE(stage->lights[2].loop);
  ASSERT_EQ(stage->paths.size(), 2u);
  EXPECT_EQ(stage->paths[1].name, "b");
  EXPECT_EQ(stage->paths[1].keys[0].fovY, 45.5);
  EXPECT_EQ(stage->paths[1].keys[1].target, glm::dvec3(2, 0, 0));
}

TEST(StageFile, EmptyObjectIsTheDefaultStage) {
  const Result<Stage> stage = stageOf("{}");
  ASSERT_TRUE(stage) << stage.error().message;
  EXPECT_TRUE(stage->sceneLights);
  EXPECT_FALSE(stage->ambient);
  EXPECT_EQ(stage->exposure, 1.0f);
  const Result<Stage> constant = stageOf(R"({"ambient": [0.5, 0.5, 0.5]})");
  ASSERT_TRUE(constant);
  EXPECT_FALSE(constant->ambient->hemisphere());
}

// Each bad file gives one line with the file, the place and the value.
struct Bad {
  std::string text;
  std::string place;
  std::string value;
};

TEST(StageFile, BadFilesNameFileElementAndValue) {
  const std::string light = R"({"lights": [{"type": "point", "position": [0, 1, 0]}, )";
  const std::string path = R"({"paths": [{"name": "p", "keyframes": [)";
  const std::string key = R"({"t": 1, "eye": [0, 0, 0], "target": [1, 0, 0], "fov_y": 60})";
  const std::vector<Bad> cases = {
      {"", "not valid JSON", ""},
      {"{\"exposure\": NaN}", "not valid JSON", "column 14"},
      {"{\"exposure\": 1e999}", "not valid JSON", "1e999"},
      {"{\"exposure\": 1", "not valid JSON", "end of input"},
      {"{} {}", "not valid JSON", "{"},
      {"\xff\xfe", "not valid JSON", "line 1"},
      {std::string(100000, '['), "not valid JSON", "end of input"},
      {std::string(5000000, '[') + std::string(5000000, ']'), "within each other", "32"},
      {std::string(20, '[') + std::string(20, ']'), "top level", "[[[["},
      {"[]", "top level", "[] is not an object"},
      {R"({"exposre": 1})", "top level", "\"exposre\""},
      {R"({"exposure": 1, "exposure": 2})", "exposure", "twice"},
      {R"({"exposure": "1"})", "exposure", "\"1\" is not a number"},
      {R"({"exposure": 0})", "exposure", "0 is not within"},
      {R"({"exposure": -1})", "exposure", "-1 is not within"},
      {R"({"exposure": null})", "exposure", "null"},
      {R"({"scene_lights": 1})", "scene_lights", "1 is not true or false"},
      {R"({"ambient": [1, 2]})", "ambient", "[1,2] is not a list of 3"},
      {R"({"ambient": {"sky": [1, 1, 1]}})", "ambient", "\"ground\" is missing"},
      {R"({"ambient": {"sky": [1, -1, 1], "ground": [0, 0, 0]}})", "ambient.sky[1]", "-1"},
      {R"({"ambient": 0.1})", "ambient", "0.1"},
      {R"({"lights": []})", "lights", "empty"},
      {R"({"lights": {}})", "lights", "{} is not a list"},
      {R"({"lights": [7]})", "lights[0]", "7 is not an object"},
      {light + R"({"type": "laser", "position": [0, 0, 0]}]})", "lights[1].type", "\"laser\""},
      {light + R"({"position": [0, 0, 0]}]})", "lights[1]", "\"type\" is missing"},
      {light + R"({"type": "point"}]})", "lights[1]", "\"position\" is missing"},
      {light + R"({"type": "spot", "position": [0, 0, 0]}]})", "lights[1]", "\"target\" is missing"},
      {light + R"({"type": "spot", "position": [0, 0, 0], "target": [0, 0, 0]}]})", "lights[1]",
       "the same point"},
      {light + R"({"type": "spot", "position": [0, 0, 0], "target": [0, 1, 0], "inner_cone": 50}]})",
       "lights[1]", "50 is not below outer_cone 45"},
      {light + R"({"type": "spot", "position": [0, 0, 0], "target": [0, 1, 0], "outer_cone": 91}]})",
       "lights[1].outer_cone", "91"},
      {light + R"({"type": "point", "position": [0, 0, 0], "outer_cone": 30}]})", "lights[1].outer_cone",
       "has none"},
      {light + R"({"type": "directional", "position": [0, 0, 0], "target": [0, 1, 0], "range": 3}]})",
       "lights[1].range", "has none"},
      {light + R"({"type": "point", "position": [0, 0, 0], "color": [1, 2, 1]}]})", "lights[1].color[1]",
       "2"},
      {light + R"({"type": "point", "position": [0, 1e30, 0]}]})", "lights[1].position[1]", "1e+30"},
      {light + R"({"type": "point", "position": [0, 0, 0], "intensity": 1e10}]})", "lights[1].intensity",
       "10000000000"},
      {light + R"({"type": "point", "position": [0, 0, 0], "name": ""}]})", "lights[1].name", "empty"},
      {light + R"({"type": "point", "keyframes": []}]})", "lights[1].keyframes", "empty"},
      {light + R"({"type": "point", "keyframes": [{"t": 0, "position": [0, 0, 0]}, {"t": 1}]}]})",
       "lights[1].keyframes[1]", "\"position\" is missing"},
      {light + R"({"type": "point", "position": [0, 0, 0], "keyframes": [{"t": 2}, {"t": 1}]}]})",
       "lights[1].keyframes[1].t", "1 is not after the 2"},
      {light + R"({"type": "point", "position": [0, 0, 0], "keyframes": [{"t": 2, "fov_y": 3}]}]})",
       "lights[1].keyframes[0]", "\"fov_y\""},
      {path + "]}]}", "paths[0].keyframes", "empty"},
      {path + key + ", " + key + "]}]}", "paths[0].keyframes[1].t", "1 is not after the 1"},
      {path + R"({"t": -1, "eye": [0, 0, 0], "target": [1, 0, 0], "fov_y": 60}]}]})",
       "paths[0].keyframes[0].t", "-1"},
      {path + R"({"t": 0, "eye": [0, 0, 0], "target": [0, 0, 0], "fov_y": 60}]}]})", "paths[0].keyframes[0]",
       "(0, 0, 0)"},
      {path + R"({"t": 0, "eye": [0, 0, 0], "target": [1, 0, 0], "fov_y": 180}]}]})",
       "paths[0].keyframes[0].fov_y", "180"},
      {path + R"({"t": 0, "eye": [0, 0, "0"], "target": [1, 0, 0], "fov_y": 60}]}]})",
       "paths[0].keyframes[0].eye[2]", "\"0\""},
      {path + R"({"t": 0, "target": [1, 0, 0], "fov_y": 60}]}]})", "paths[0].keyframes[0]",
       "\"eye\" is missing"},
      {path + R"({"t": 0, "fov_y": 60}]}]})", "paths[0].keyframes[0]", "\"eye\" is missing"},
      {R"({"paths": [{"keyframes": []}, {}]})", "paths[0]", "\"name\" is missing"},
      {path + key + R"(]}, {"name": "p", "keyframes": [)" + key + "]}]}", "paths[1].name", "\"p\""},
  };
  for (const Bad& bad : cases) {
    const Result<Stage> stage = stageOf(bad.text);
    ASSERT_FALSE(stage) << bad.text;
    const std::string& message = stage.error().message;
    EXPECT_NE(message.find("stage_BadFilesNameFileElementAndValue.json: "), std::string::npos) << message;
    EXPECT_NE(message.find(bad.place), std::string::npos) << message << "\nof " << bad.text.substr(0, 200);
    EXPECT_NE(message.find(bad.value), std::string::npos) << message << "\nof " << bad.text.substr(0, 200);
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), 600u);
  }
}

TEST(StageFile, MissingFileAndFolderAreErrors) {
  for (const char* name : {"no_such_stage.json", "."}) {
    const Result<Stage> stage = loadStage(std::filesystem::path(TESSERA_BINARY_DIR) / name);
    ASSERT_FALSE(stage);
    EXPECT_NE(stage.error().message.find(name), std::string::npos);
  }
}

// Every prefix of a good file, and the file with each byte changed, is read or refused, never worse.
TEST(StageFile, DamagedFilesNeverCrash) {
  const std::string good = kGood;
  for (std::size_t length = 0; length < good.size(); length += 7) {
    EXPECT_FALSE(stageOf(good.substr(0, length))) << length;
  }
  std::size_t refused = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string damaged = good;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    const Result<Stage> stage = stageOf(damaged);
    if (!stage) ++refused;
    for (const CameraPath& path : stage ? stage->paths : std::vector<CameraPath>()) {
      EXPECT_TRUE(std::isfinite(sampleCamera(path, 0.7).eye.x));
    }
  }
  EXPECT_GT(refused, good.size() / 2);
}

TEST(PathFile, ReadsABarePathAndNothingElse) {
  const Result<CameraPath> path = loadCameraPath(
      write(R"({"keyframes": [{"t": 0, "eye": [1, 2, 3], "target": [4, 5, 6], "fov_y": 70}]})"));
  ASSERT_TRUE(path) << path.error().message;
  ASSERT_EQ(path->keys.size(), 1u);
  EXPECT_EQ(path->keys[0].eye, glm::dvec3(1, 2, 3));
  const Result<CameraPath> stage = loadCameraPath(write(kGood));
  ASSERT_FALSE(stage);
  EXPECT_NE(stage.error().message.find("unknown key"), std::string::npos) << stage.error().message;
  const Result<CameraPath> empty = loadCameraPath(write("{}"));
  ASSERT_FALSE(empty);
  EXPECT_NE(empty.error().message.find("\"keyframes\" is missing"), std::string::npos)
      << empty.error().message;
}

TEST(GazeFile, IsReadAndSampledBetweenItsKeys) {
  const auto keys = loadGaze(write(
      R"([{"time": 1, "x": 0.5, "y": 0.25}, {"time": 3, "x": 0.75, "y": 1.5}, {"time": 3.5, "x": 0, "y": -1}])"));
  ASSERT_TRUE(keys) << keys.error().message;
  ASSERT_EQ(keys->size(), 3u);
  EXPECT_EQ(sampleGaze(*keys, 0.0), glm::dvec2(0.5, 0.25));
  EXPECT_EQ(sampleGaze(*keys, 1.5), glm::dvec2(0.5625, 0.5625));
  EXPECT_EQ(sampleGaze(*keys, 3.0), glm::dvec2(0.75, 1.5));
  EXPECT_EQ(sampleGaze(*keys, 3.25), glm::dvec2(0.375, 0.25));
  EXPECT_EQ(sampleGaze(*keys, 99.0), glm::dvec2(0.0, -1.0));
}

TEST(GazeFile, BadOnesAreRefusedByTheKey) {
  const auto message = [](const std::string& text) {
    const auto keys = loadGaze(write(text));
    return keys ? std::string() : keys.error().message;
  };
  const auto names = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(names(message("[]"), "empty"));
  EXPECT_TRUE(names(message("{}"), "not a list"));
  EXPECT_TRUE(names(message("[1"), "not valid JSON"));
  EXPECT_TRUE(names(message(R"([{"time": 0, "x": 0.5}])"), "\"y\" is missing"));
  EXPECT_TRUE(names(message(R"([{"time": 0, "x": "left", "y": 0}])"), "[0].x"));
  EXPECT_TRUE(names(message(R"([{"time": 0, "x": 1e9, "y": 0}])"), "[0].x"));
  EXPECT_TRUE(names(message(R"([{"time": 0, "x": 0, "y": 0, "z": 0}])"), "unknown key"));
  EXPECT_TRUE(names(message(R"([{"time": 2, "x": 0, "y": 0}, {"time": 2, "x": 0, "y": 0}])"), "[1].time"));
  EXPECT_FALSE(loadGaze("nowhere.json"));
}

CameraPath pathOf(std::vector<std::pair<double, double>> timesAndX) {
  CameraPath path;
  for (const auto& [t, x] : timesAndX) path.keys.push_back({t, {x, 0, 0}, {x + 1, 0, 0}, 50.0 + x});
  return path;
}

TEST(SampleCamera, PassesThroughItsKeysAndHoldsItsEnds) {
  const CameraPath path = pathOf({{1, 0}, {2, 4}, {5, 3}, {5.5, -2}});
  for (const CameraKey& key : path.keys) {
    EXPECT_EQ(sampleCamera(path, key.time).eye, key.eye);
    EXPECT_EQ(sampleCamera(path, key.time).target, key.target);
    EXPECT_EQ(sampleCamera(path, key.time).fovY, key.fovY);
  }
  EXPECT_EQ(sampleCamera(path, -3.0).eye.x, 0.0);
  EXPECT_EQ(sampleCamera(path, 99.0).eye.x, -2.0);
  EXPECT_EQ(sampleCamera(pathOf({{2, 7}}), 0.0).eye.x, 7.0);
}

// A parabola x = t^2 at uneven times has derivative 2t at the inner keys, which the cubic keeps exactly.
TEST(SampleCamera, InnerSegmentsReproduceAParabola) {
  const CameraPath path = pathOf({{0, 0}, {1, 1}, {3, 9}, {4, 16}});
  expectNear(sampleCamera(path, 1.5).eye, {2.25, 0, 0});
  expectNear(sampleCamera(path, 2.5).eye, {6.25, 0, 0});
}

// Keys (0, 0), (1, 1), (2, 1): slopes 1 and 0, tangents 1 (end), 1/2, 0 (end).
// First half at s = 1/2: 1/2 + 1/8 * 1 - 1/8 * 1/2 = 0.5625; second: 1 + 1/8 * 1/2 = 1.0625.
TEST(SampleCamera, HandWorkedSegments) {
  const CameraPath path = pathOf({{0, 0}, {1, 1}, {2, 1}});
  expectNear(sampleCamera(path, 0.5).eye, {0.5625, 0, 0});
  expectNear(sampleCamera(path, 1.5).eye, {1.0625, 0, 0});
}

TEST(SampleCamera, EndsDoNotBackUp) {
  const CameraPath path = pathOf({{0, 0}, {1, 1}, {2, 4}, {3, 5}});
  double last = -1e-12;
  for (int i = 0; i <= 300; ++i) {
    const double x = sampleCamera(path, i / 100.0).eye.x;
    EXPECT_GT(x, last) << i;
    last = x;
  }
}

TEST(SampleCamera, FieldOfViewStaysBetweenItsKeys) {
  CameraPath path = pathOf({{0, 0}, {1, 0}, {1.1, 0}, {2, 0}});
  path.keys[0].fovY = 10.0;
  path.keys[1].fovY = path.keys[2].fovY = 170.0;
  path.keys[3].fovY = 10.0;
  for (int i = 0; i <= 200; ++i) {
    const double fovY = sampleCamera(path, i / 100.0).fovY;
    EXPECT_GE(fovY, 10.0);
    EXPECT_LE(fovY, 170.0);
  }
}

TEST(Lights, StageLightsFollowTheirKeys) {
  const Result<Stage> stage = stageOf(kGood);
  ASSERT_TRUE(stage) << stage.error().message;
  const auto at = [&](double time) { return evaluateLights(Scene(), SceneState(), &*stage, time); };
  ASSERT_EQ(at(0.0).size(), 3u);
  const LightSample sun = at(0.0)[0];
  expectNear(sun.direction, {0, -1, 0});
  EXPECT_EQ(sun.radiance, glm::vec3(4.0f));
  EXPECT_TRUE(sun.castsShadow);
  EXPECT_FALSE(sun.moves);
  const LightSample spot = at(2.0)[1];
  expectNear(spot.position, {2, 4, 0});
  expectNear(spot.direction, {-1 / std::sqrt(5.0), -2 / std::sqrt(5.0), 0});
  EXPECT_EQ(spot.radiance, 12.0f * glm::vec3(0.5f, 0.5f, 0.5f));
  EXPECT_EQ(spot.range, 12.0f);
  EXPECT_TRUE(spot.moves);
  EXPECT_FALSE(spot.castsShadow);
  expectNear(at(0.5)[1].position, {0, 4, 0});   // before the first key
  expectNear(at(5.0)[1].position, {2, 4, 0});   // looped: 5 mod 3 = 2
  expectNear(at(-1.0)[1].position, {2, 4, 0});  // looped backwards
}

TEST(Lights, WithoutLoopTheLastKeyIsHeld) {
  const Result<Stage> stage = stageOf(
      R"({"lights": [{"type": "point", "loop": false, "keyframes": [{"t": 0, "position": [0, 0, 0]},
          {"t": 1, "position": [1, 0, 0]}]}]})");
  ASSERT_TRUE(stage) << stage.error().message;
  const auto samples = evaluateLights(Scene(), SceneState(), &*stage, 7.0);
  expectNear(samples.at(0).position, {1, 0, 0});
}

TEST(Lights, SceneLightsShineAlongMinusZOfTheirNodeWhateverItsScale) {
  Scene scene;
  scene.nodes.resize(2);
  scene.nodes[0].scale = {2, 3, 4};
  scene.nodes[0].rotation = glm::dquat(std::sqrt(0.5), -std::sqrt(0.5), 0, 0);  // -z to -y
  scene.nodes[0].translation = {5, 0, 0};
  scene.nodes[1].parent = 0;
  scene.nodes[1].light = 0;
  scene.nodes[1].translation = {0, 0, 1};
  Light light;
  light.type = LightType::Spot;
  light.color = {1.0f, 0.5f, 0.25f};
  light.intensity = 8.0f;
  scene.lights.push_back(light);
  scene.animations.push_back(
      {"lift", 1.0, {{0, AnimatedProperty::Scale, Interpolation::Linear, {0.0f}, {glm::vec4(2, 3, 4, 0)}}}});
  SceneState state;
  evaluate(scene, 0.0, state);
  const auto samples = evaluateLights(scene, state, nullptr, 0.0);
  ASSERT_EQ(samples.size(), 1u);
  expectNear(samples[0].position, {5, 4, 0});
  expectNear(samples[0].direction, {0, -1, 0});
  EXPECT_EQ(samples[0].radiance, glm::vec3(8.0f, 4.0f, 2.0f));
  EXPECT_TRUE(samples[0].moves);
  EXPECT_FALSE(samples[0].castsShadow);

  Stage stage;
  stage.sceneLightsCastShadows = true;
  EXPECT_TRUE(evaluateLights(scene, state, &stage, 0.0).at(0).castsShadow);
  stage.sceneLights = false;
  EXPECT_TRUE(evaluateLights(scene, state, &stage, 0.0).empty());
}

TEST(Lights, ANodeScaledToNothingStillHasADirection) {
  Scene scene;
  scene.nodes.resize(1);
  scene.nodes[0].scale = glm::dvec3(0.0);
  scene.nodes[0].light = 0;
  scene.lights.emplace_back();
  SceneState state;
  evaluate(scene, 0.0, state);
  EXPECT_NEAR(glm::length(evaluateLights(scene, state, nullptr, 0.0).at(0).direction), 1.0, 1e-12);
}

}  // namespace
}  // namespace tessera
