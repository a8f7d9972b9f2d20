#include "apps/tessera/report/pvs_report.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using Json = nlohmann::json;

PvsReport report() {
  PvsRun run;
  run.name = "linear, <b>";
  run.prediction = "linear";
  run.marginDegrees = 2.0;
  run.steps = 4;
  run.views = 5;
  run.width = 110;
  run.height = 60;
  run.frames = {{0.5, 1.0, 0.1, 0.0, 20.0, 10.0, 3.0}, {1.0, 0.9, 0.3, 40.0, 30.0, 12.0, 5.0}};
  PvsScene scene;
  scene.scene = "a&b.glb";
  scene.path = "tour";
  scene.element = "patch";
  scene.width = 100;
  scene.height = 50;
  scene.rate = 120.0;
  scene.latencyMs = 33.0;
  scene.shownViews = 5;
  scene.idMs = summarize(std::vector<double>{1.0});
  scene.runs = {run};
  PvsReport whole;
  whole.scenes = {scene};
  return whole;
}

TEST(PvsReport, SummaryAsWorkedByHand) {
  const PvsSummary s = summarize(report().scenes[0].runs[0]);
  EXPECT_DOUBLE_EQ(s.coverage, 0.95);
  EXPECT_DOUBLE_EQ(s.coverageWorst, 0.9);
  EXPECT_DOUBLE_EQ(s.overestimation, 0.2);
  EXPECT_DOUBLE_EQ(s.overestimationWorst, 0.3);
  EXPECT_DOUBLE_EQ(s.missedPixels, 20.0);
  EXPECT_DOUBLE_EQ(s.elements, 25.0);
  EXPECT_DOUBLE_EQ(s.neededElements, 11.0);
  EXPECT_DOUBLE_EQ(s.ms.median, 4.0);
  EXPECT_TRUE(std::isnan(summarize(PvsRun{}).coverage));
}

TEST(PvsReport, JsonHasRunsAndSeries) {
  const Json json = Json::parse(toJson(report()));
  const Json& scene = json["scenes"][0];
  EXPECT_EQ(scene["scene"], "a&b.glb");
  EXPECT_EQ(scene["size"], (Json{100, 50}));
  EXPECT_EQ(scene["shown_views"], 5);
  EXPECT_EQ(scene["id_pass_ms"]["median"], 1.0);
  const Json& run = scene["runs"][0];
  EXPECT_EQ(run["prediction"], "linear");
  EXPECT_EQ(run["margin_deg"], 2.0);
  EXPECT_EQ(run["view_size"], (Json{110, 60}));
  EXPECT_DOUBLE_EQ(run["coverage"], 0.95);
  EXPECT_DOUBLE_EQ(run["overestimation_worst"], 0.3);
  EXPECT_EQ(run["series"]["coverage"], (Json{1.0, 0.9}));
  EXPECT_EQ(run["series"]["missed_pixels"], (Json{0.0, 40.0}));
}

TEST(PvsReport, WhatIsInfiniteIsNotANumber) {
  PvsReport infinite = report();
  infinite.scenes[0].runs[0].frames[0].overestimation = std::numeric_limits<double>::infinity();
  const Json json = Json::parse(toJson(infinite));
  EXPECT_TRUE(json["scenes"][0]["runs"][0]["series"]["overestimation"][0].is_null());
  const std::string html = toHtml(infinite);
  EXPECT_NE(html.find("\"overestimation\":[null,30.0]"), std::string::npos);
}

TEST(PvsReport, PageStandsAloneAndEscapes) {
  const std::string html = toHtml(report());
  EXPECT_NE(html.find("<th scope=\"row\">linear, &lt;b&gt;</th><td>95.000 %</td><td>90.000 %</td>"
                      "<td>20.00 %</td><td>30.00 %</td><td>20.0</td><td>25</td><td>11</td>"
                      "<td>5 of 110 × 60</td>"),
            std::string::npos);
  EXPECT_NE(html.find("a&amp;b.glb"), std::string::npos);
  EXPECT_EQ(html.find("linear, <b>"), std::string::npos);
  const std::string open = "<script type=\"application/json\" id=\"data\">";
  const std::size_t start = html.find(open) + open.size();
  const Json data = Json::parse(html.substr(start, html.find("</script>", start) - start));
  EXPECT_EQ(data["scenes"][0]["times"], (Json{0.5, 1.0}));
  EXPECT_EQ(data["scenes"][0]["runs"][0]["coverage"], (Json{100.0, 90.0}));
}

}  // namespace
}  // namespace tessera
