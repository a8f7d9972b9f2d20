// The model behind stream-study: which frame is shown when, and what follows from its curves.
#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/tessera/report/study_report.hpp"
#include "apps/tessera/study/path.hpp"
#include "apps/tessera/study/timing.hpp"

namespace tessera {
namespace {

using app::longestUse;
using app::predictionSteps;
using app::shownFrame;
using app::StreamTiming;
using app::StudyPath;
using app::StudySettings;

TEST(StudyTiming, ShowsTheNewestFrameThatHasCome) {
  // Frames of 0, 33.3, 66.7 ms, each there 50 ms later: at 50, 83.3 and 116.7 ms.
  const StreamTiming late{30.0, 0.05};
  EXPECT_LT(shownFrame(0.0499, late), 0);
  EXPECT_EQ(shownFrame(0.05, late), 0);
  EXPECT_EQ(shownFrame(0.0833, late), 0);
  EXPECT_EQ(shownFrame(0.0834, late), 1);
  EXPECT_EQ(shownFrame(0.1167, late), 2);
  // Without latency a frame is shown from its own pose's time on, for four pictures of 120 Hz.
  const StreamTiming now{30.0, 0.0};
  for (int picture = 0; picture < 24; ++picture) EXPECT_EQ(shownFrame(picture / 120.0, now), picture / 4);
  // Whatever the fractions round to.
  for (int k = 0; k < 1000; ++k) {
    EXPECT_EQ(shownFrame(k / 7.5, {7.5, 0.0}), k);
    EXPECT_EQ(shownFrame(k / 120.0 + 0.025, {120.0, 0.025}), k);
  }
}

TEST(StudyTiming, PredictsInStepsOf33Milliseconds) {
  // The example of Mueller 2021, sec. 7.2: 33.3, 66.6, 100 and 133.3 ms.
  EXPECT_NEAR(longestUse({30.0, 0.1}), 0.13333, 1e-5);
  EXPECT_EQ(predictionSteps({30.0, 0.1}), 4);
  EXPECT_EQ(predictionSteps({30.0, 0.0}), 1);
  EXPECT_EQ(predictionSteps({120.0, 0.0}), 1);
  EXPECT_EQ(predictionSteps({30.0, 0.025}), 2);
  EXPECT_EQ(predictionSteps({7.5, 0.0}), 4);
}

TEST(StudyTiming, SamplesMeetEveryPhaseOfTheServer) {
  const app::Samples samples = app::samplesOver(1.0, 16, 120.0, 0.2333);
  EXPECT_EQ(samples.stride, 7);
  EXPECT_EQ(samples.count, 16);
  EXPECT_NEAR(samples.first, 28.0 / 120.0, 1e-12);
  EXPECT_NEAR(samples.last(), (28.0 + 15 * 7) / 120.0, 1e-12);
  // A frame of 7.5 Hz is shown for 16 pictures: each of its ages is sampled once.
  std::vector<int> ages(16);
  for (int i = 0; i < 16; ++i) ++ages[static_cast<std::size_t>(std::lround(samples.at(i) * 120.0)) % 16];
  for (const int count : ages) EXPECT_EQ(count, 1);
}

TEST(StudyTiming, PathsThatAreTooShortAreRefused) {
  std::vector<TimedView> poses(121);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].time = 5.0 + static_cast<double>(i) / 120.0;
    poses[i].view.eye.x = 2.0 * static_cast<double>(i) / 120.0;
  }
  StudySettings settings;
  settings.seconds = 0.5;
  const auto path = StudyPath::of(poses, settings);
  ASSERT_TRUE(path) << path.error().message;
  // 200 ms and a frame of 30 Hz before the first sample; the rest of the second to either side.
  EXPECT_NEAR(path->samples().first, 28.0 / 120.0, 1e-12);
  EXPECT_NEAR(path->metresPerSecond(), 2.0, 1e-9);
  EXPECT_NEAR(path->degreesPerSecond(), 0.0, 1e-9);
  EXPECT_NEAR(path->start() - 5.0, 0.5 * (1.0 - path->samples().last()), 1.0 / 120.0);
  EXPECT_EQ(path->at(0.3).time, path->start()) << "the scene stands still";
  EXPECT_NEAR(path->at(0.3).view.eye.x, 2.0 * (path->start() - 5.0 + 0.3), 1e-9);
  settings.moving = true;
  EXPECT_NEAR(StudyPath::of(poses, settings)->at(0.3).time, path->start() + 0.3, 1e-9);
  settings.start = 0.9;
  const auto late = StudyPath::of(poses, settings);
  ASSERT_FALSE(late);
  EXPECT_NE(late.error().message.find("--start 0.9"), std::string::npos) << late.error().message;
  settings.seconds = 1.0;
  settings.start = -1.0;
  const auto shortened = StudyPath::of(poses, settings);
  ASSERT_FALSE(shortened);
  EXPECT_NE(shortened.error().message.find("1.00 s is shorter"), std::string::npos)
      << shortened.error().message;
}

TEST(StudyFindings, CrossingsAreWhereOneCurveStaysAbove) {
  const std::vector<double> x = {0.0, 50.0, 100.0};
  EXPECT_EQ(crossing(x, {0.9, 0.9, 0.9}, {0.8, 0.8, 0.8}), 0.0);
  EXPECT_TRUE(std::isnan(crossing(x, {0.9, 0.9, 0.9}, {0.8, 0.8, 0.9}))) << "equal is not above";
  // From 0.1 below to 0.1 above between 0 and 50.
  EXPECT_NEAR(crossing(x, {0.8, 0.8, 0.8}, {0.9, 0.7, 0.6}), 25.0, 1e-9);
  // It was above before, but not for good: 0.01 below to 0.03 above.
  EXPECT_NEAR(crossing(x, {0.9, 0.80, 0.9}, {0.8, 0.81, 0.87}), 62.5, 1e-9);
}

StudyReport report() {
  StudyReport made;
  made.settings = {{"Display", "64 × 36"}};
  StudyScene scene;
  scene.file = "a <b>.glb";
  const auto method = [&](const char* name, bool atlas, std::vector<double> values) {
    StudyMethod one;
    one.name = name;
    one.atlas = atlas;
    const double latencies[] = {0.0, 50.0, 100.0};
    for (std::size_t i = 0; i < values.size(); ++i) {
      StudyPoint point;
      point.latencyMs = latencies[i];
      point.mssim = values[i];
      one.byLatency.push_back(point);
    }
    scene.methods.push_back(std::move(one));
  };
  method("rect", true, {0.95, 0.949, 0.945});
  method("tess", true, {0.95, 0.9, 0.93});
  method("time warp", false, {0.97, 0.80, 0.75});
  method("mesh warp", false, {0.96, 0.91, 0.85});
  scene.timeline.failed = "no reason";
  made.scenes.push_back(std::move(scene));
  return made;
}

TEST(StudyFindings, GoalsAreJudgedByTheNumbers) {
  const auto findings = findingsOf(report().scenes[0]);
  const auto find = [&](const char* text) {
    for (const StudyFinding& finding : findings)
      if (finding.text.find(text) != std::string::npos) return finding;
    ADD_FAILURE() << "none says " << text;
    return StudyFinding();
  };
  EXPECT_TRUE(find("rect against the best warp at 50 ms and above: MSSIM +0.0390").reached);
  EXPECT_FALSE(find("tess against the best warp at 50 ms and above: MSSIM -0.0100").reached);
  EXPECT_TRUE(find("rect: MSSIM 0.9500 at 0 ms, 0.9450 at 100 ms").reached);
  EXPECT_FALSE(find("tess: MSSIM 0.9500 at 0 ms, 0.9300 at 100 ms").reached);
  // 0.02 below to 0.039 above.
  EXPECT_FALSE(find("rect beats every warp from 16.9 ms of latency on").goal);
  EXPECT_FALSE(find("tess beats every warp from 55.6 ms of latency on").goal);
}

TEST(StudyReportFiles, JsonAndPageHoldWhatWasMeasured) {
  const StudyReport made = report();
  const auto json = nlohmann::json::parse(toJson(made), nullptr, false);
  ASSERT_TRUE(json.is_object());
  const auto& scene = json["scenes"][0];
  EXPECT_EQ(scene["methods"][0]["by_latency"][2]["mssim"], 0.945);
  EXPECT_TRUE(scene["methods"][2]["by_latency"][0]["meta_mbit_s"].is_null());
  EXPECT_EQ(scene["timeline"]["failed"], "no reason");
  EXPECT_EQ(scene["findings"][0]["reached"], true);
  EXPECT_EQ(json["settings"]["Display"], "64 × 36");
  const std::string page = toHtml(made);
  EXPECT_NE(page.find("a &lt;b&gt;.glb"), std::string::npos);
  EXPECT_NE(page.find("no reason"), std::string::npos);
  EXPECT_EQ(page.find("http://"), page.find("http://www.w3.org")) << "no request leaves the page";
}

}  // namespace
}  // namespace tessera
