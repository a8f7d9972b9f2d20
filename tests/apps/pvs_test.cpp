// tessera pvs from a scene to its report.
#include <nlohmann/json.hpp>

#include "tests/apps/cli.hpp"

namespace tessera {
namespace {

using test::Cli;
using test::Ran;
using test::slurp;
using Json = nlohmann::json;

class PvsCli : public Cli {};

TEST_F(PvsCli, MeasuresEveryWayToPredict) {
  const Ran ran =
      run(fmt::format("pvs '{}' --context osmesa --size 160x90 --frames 3 --margin-deg 0,5 --steps 2,4 "
                      "--latency-ms 33.33333333 "
                      "--speed 3 -o report --json other.json",
                      atrium()));
  ASSERT_EQ(ran.code, 0) << ran.error;
  const Json json = Json::parse(slurp(folder_ / "report" / "pvs.json"), nullptr, false);
  ASSERT_TRUE(json.is_object());
  EXPECT_EQ(json, Json::parse(slurp(folder_ / "other.json"), nullptr, false));
  const Json& scene = json["scenes"][0];
  EXPECT_EQ(scene["scene"], "atrium.glb");
  EXPECT_EQ(scene["path"], "tour, 3 times as fast");
  EXPECT_EQ(scene["size"], (Json{160, 90}));
  EXPECT_EQ(scene["shown_views"], 5);
  EXPECT_EQ(scene["element"], "patch");
  ASSERT_EQ(scene["runs"].size(), 10u) << "none has no steps";
  double noneCovers = 1.0;
  double noMargin = 0.0;
  for (const Json& way : scene["runs"]) {
    SCOPED_TRACE(way["name"]);
    EXPECT_EQ(way["series"]["coverage"].size(), 3u);
    // Ten seconds, three times as fast, but for the four views that are shown after the last set.
    EXPECT_NEAR(way["series"]["time_s"][2].get<double>(), 10.0 / 3.0 - 4.0 / 120.0, 1e-2);
    EXPECT_GT(way["ms"]["median"], 0.0);
    EXPECT_GT(way["elements"], 100.0);
    EXPECT_EQ(way["views"], 1 + way["steps"].get<int>());
    if (way["name"] == "none, margin 0°") noneCovers = way["coverage"];
    if (way["name"] == "linear, margin 0°, 4 steps") noMargin = way["overestimation"];
    if (way["name"] == "reference, margin 0°, 4 steps") {
      EXPECT_EQ(way["coverage"], 1.0) << "the set's views are those that are shown";
      EXPECT_EQ(way["overestimation"], 0.0);
    }
    if (way["name"] == "linear, margin 5°, 4 steps") {
      EXPECT_GT(way["coverage"], noneCovers);
      EXPECT_GT(way["overestimation"], noMargin);
      EXPECT_GT(way["view_size"][0], 160);
      EXPECT_GT(way["view_size"][1], 90);
    }
  }
  EXPECT_LT(noneCovers, 0.999);
  EXPECT_NE(ran.out.find("linear, margin 5°, 4 steps"), std::string::npos) << ran.out;
  EXPECT_NE(slurp(folder_ / "report" / "pvs.html").find("atrium.glb"), std::string::npos);
}

TEST_F(PvsCli, StandsStillWithoutAPathAndCountsTriangles) {
  const Ran ran =
      run(fmt::format("pvs '{}' --context osmesa --size 96x54 --frames 2 --camera auto --element triangle "
                      "--prediction none --margin-deg 0 --json out.json",
                      atrium()));
  ASSERT_EQ(ran.code, 0) << ran.error;
  const Json json = Json::parse(slurp(folder_ / "out.json"), nullptr, false);
  ASSERT_TRUE(json.is_object());
  const Json& scene = json["scenes"][0];
  EXPECT_EQ(scene["element"], "triangle");
  ASSERT_EQ(scene["runs"].size(), 1u);
  EXPECT_EQ(scene["runs"][0]["coverage"], 1.0) << "nothing moves";
  EXPECT_EQ(scene["runs"][0]["overestimation"], 0.0);
  // A head that turns sees what the present view does not.
  const Ran turning =
      run(fmt::format("pvs '{}' --context osmesa --size 96x54 --frames 2 --camera auto --head-turn 90,5 "
                      "--prediction none --margin-deg 0 --json out.json",
                      atrium()));
  ASSERT_EQ(turning.code, 0) << turning.error;
  const Json turned = Json::parse(slurp(folder_ / "out.json"), nullptr, false);
  EXPECT_LT(turned["scenes"][0]["runs"][0]["coverage"], 0.99);
}

TEST_F(PvsCli, RendersWhatIsPredicted) {
  const std::string render = fmt::format(
      "render '{}' --context osmesa --size 160x90 --stage '{}/assets/stages/atrium.json' --path tour "
      "--fps 10 --frames 3 --stats s.json -o p.png ",
      atrium(), TESSERA_SOURCE_DIR);
  const auto visible = [&](const std::string& arguments) {
    const Ran ran = run(render + arguments);
    EXPECT_EQ(ran.code, 0) << ran.error;
    return Json::parse(slurp(folder_ / "s.json"), nullptr, false)["frames"][2]["visible_patches"].get<int>();
  };
  const int one = visible("");
  EXPECT_EQ(visible("--prediction none --margin-deg 0"), one);
  EXPECT_GT(visible("--prediction none --margin-deg 5"), one);
  const int linear = visible("--prediction linear --margin-deg 0 --latency-ms 300");
  EXPECT_GT(linear, one);
  EXPECT_EQ(visible("--prediction linear --margin-deg 0 --latency-ms 0"), one);
  EXPECT_NE(visible("--prediction reference --margin-deg 0 --latency-ms 300"), linear);
  expectRefused(render + "--prediction guess", "guess");
  expectRefused(render + "--margin-deg 2", "--prediction");
  expectRefused(render + "--prediction linear --steps 65", "--steps");
  expectRefused(render + "--prediction linear --method forward", "method forward has no visible set");
  expectRefused(render + "--prediction linear --method rect-deferred", "ids of one view");
  expectRefused(render + "--prediction linear --view levels", "--view levels");
}

TEST_F(PvsCli, RefusesWithOneLine) {
  const std::string pvs = fmt::format("pvs '{}' --context osmesa ", atrium());
  expectRefused("pvs", "scenes");
  expectRefused("pvs nothing.glb --context osmesa", "nothing.glb");
  expectRefused(pvs + "--prediction guess", "guess");
  expectRefused(pvs + "--margin-deg 46", "46");
  expectRefused(pvs + "--margin-deg 1,nan", "nan");
  expectRefused(pvs + "--steps 0", "--steps");
  expectRefused(pvs + "--steps 2,x", "x");
  expectRefused(pvs + "--latency-ms -1", "--latency-ms");
  expectRefused(pvs + "--rate 0", "--rate");
  expectRefused(pvs + "--head-turn 20", "--head-turn 20");
  expectRefused(pvs + "--head-turn 91,1", "91 degrees");
  expectRefused(pvs + "--head-turn 20,11", "11 turns");
  expectRefused(pvs + "--head-turn nan,1", "--head-turn nan,1");
  expectRefused(pvs + "--path nowhere.json", "nowhere.json");
  expectRefused(pvs + "--json /dev/null/x.json", "--json");
  expectRefused(pvs + "--fov-y 120 --margin-deg 20 --size 320x180 --frames 1", "past 85");
  std::ofstream(folder_ / "short.json")
      << R"({"keyframes": [{"t": 0, "eye": [0, 2, 3], "target": [0, 2, -3], "fov_y": 60},
                           {"t": 0.02, "eye": [1, 2, 3], "target": [0, 2, -3], "fov_y": 60}]})";
  expectRefused(pvs + "--path short.json --size 64x36", "3 poses at 120 Hz");
}

}  // namespace
}  // namespace tessera
