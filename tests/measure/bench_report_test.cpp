#include "apps/tessera/report/bench_report.hpp"

#include <cmath>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using Json = nlohmann::json;

BenchFrame frame(double live, double failures, bool reset, double ms) {
  BenchFrame f;
  f.live = live;
  f.end = 100.0;
  f.stack = 50.0;
  f.inaccessible = 25.0;
  f.free = 1000.0 - 175.0 - live;
  f.made = 7.0;
  f.failures = failures;
  f.reduced = 2.0;
  f.stayed = reset ? 0.0 : 10.0;
  f.kept = reset ? 0.0 : 9.0;
  f.movedTexels = reset ? live : 0.1 * live;
  f.reset = reset;
  f.bias = 0.5;
  f.ms = ms;
  return f;
}

BenchRun run(const std::string& name, double ms) {
  // The first frame's time does not count.
  return {name,
          {frame(400.0, 0.0, false, 1000.0), frame(500.0, 3.0, false, ms), frame(600.0, 0.0, true, 3.0 * ms),
           frame(500.0, 1.0, false, 2.0 * ms)}};
}

BenchScene scene(const std::string& name, double ms) {
  BenchScene s;
  s.scene = name;
  s.width = 1920;
  s.height = 1080;
  s.fps = 99.9;
  s.patchInstances = 12345.0;
  s.visiblePatches = 678.0;
  s.atlasWidth = 50;
  s.atlasHeight = 20;
  s.strategies = {run("S0", ms), run("S3", 10.0 * ms)};
  s.quadtree = run("CPU quadtree", 40.0 * ms);
  s.frameMs = summarize(std::vector<double>{200.0});
  s.memoryMs = summarize(std::vector<double>{1.0});
  return s;
}

BenchVariant variant(int superblock, const std::string& skipped) {
  BenchVariant v;
  v.superblock = superblock;
  v.smallest = 1;
  v.largest = 32;
  v.aspect = 8;
  v.skipped = skipped;
  if (skipped.empty()) v.summary = summarize(run("S0", 5.0));
  return v;
}

std::string readText(const char* path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(BenchReport, SummaryAsWorkedByHand) {
  const BenchSummary s = summarize(run("S0", 2.0));
  EXPECT_EQ(s.frames, 4u);
  EXPECT_EQ(s.oomFrames, 2u);
  EXPECT_EQ(s.failures, 4.0);
  EXPECT_EQ(s.reduced, 8.0);
  EXPECT_EQ(s.resets, 1u);
  EXPECT_DOUBLE_EQ(s.liveShare, 0.5);
  EXPECT_DOUBLE_EQ(s.keptPlace, 0.9);
  EXPECT_DOUBLE_EQ(s.movedShare, (40.0 + 50.0 + 600.0 + 50.0) / 2000.0);
  EXPECT_DOUBLE_EQ(s.movedShareOutsideResets, 0.1);
  EXPECT_DOUBLE_EQ(s.bias, 0.5);
  EXPECT_EQ(s.ms.count, 3u);
  EXPECT_DOUBLE_EQ(s.ms.median, 4.0);
  const BenchSummary none = summarize(BenchRun{"S0", {}});
  EXPECT_TRUE(std::isnan(none.liveShare) && std::isnan(none.keptPlace) && std::isnan(none.ms.median));
}

TEST(BenchReport, JsonHasTheShapeThatIsPromised) {
  BenchReport report;
  report.scenes = {scene("one.glb", 1.0), scene("two.glb", 3.0)};
  report.scenes[1].strategies[0].frames.resize(2);
  report.scenes[0].sweep = {variant(64, ""), variant(16, "too many")};
  report.scenes[0].sweep[0].standard = true;
  const Json json = Json::parse(toJson(report));
  ASSERT_EQ(json["strategies"].size(), 2u);
  EXPECT_EQ(json["strategies"][1]["name"], "S3");
  const auto check = [](const Json& entry) {
    for (const char* key : {"name", "oom_frames", "resets", "live_share", "kept_place", "texels_moved_share"})
      EXPECT_TRUE(entry.contains(key)) << key;
    EXPECT_TRUE(entry["ms_per_frame"].contains("median"));
    EXPECT_TRUE(entry["ms_per_frame"].contains("p95"));
  };
  for (const Json& entry : json["strategies"]) check(entry);
  check(json["cpu_quadtree"]);
  // Counts are sums over the scenes, the rest means.
  EXPECT_EQ(json["strategies"][0]["oom_frames"], 3);
  EXPECT_EQ(json["strategies"][0]["resets"], 1);
  EXPECT_DOUBLE_EQ(json["strategies"][0]["live_share"], (0.5 + 0.45) / 2.0);
  EXPECT_DOUBLE_EQ(json["cpu_quadtree"]["ms_per_frame"]["median"], (80.0 + 240.0) / 2.0);
  ASSERT_EQ(json["scenes"].size(), 2u);
  const Json& first = json["scenes"][0];
  EXPECT_EQ(first["scene"], "one.glb");
  check(first["strategies"][0]);
  check(first["cpu_quadtree"]);
  EXPECT_EQ(first["strategies"][0]["series"]["live"], (Json{400, 500, 600, 500}));
  EXPECT_EQ(first["strategies"][0]["series"]["reset"], (Json{0, 0, 1, 0}));
  EXPECT_EQ(first["recorded_frame_ms"]["median"], 200.0);
  EXPECT_EQ(first["sweep"][0]["superblock"], 64);
  EXPECT_EQ(first["sweep"][0]["largest_aspect"], 8);
  EXPECT_EQ(first["sweep"][0]["default"], true);
  EXPECT_TRUE(first["sweep"][0]["skipped"].is_null());
  check(first["sweep"][0]);
  EXPECT_EQ(first["sweep"][1]["superblock"], 16);
  EXPECT_EQ(first["sweep"][1]["skipped"], "too many");
  EXPECT_FALSE(first["sweep"][1].contains("live_share")) << "what did not run has no results";
  const Json empty = Json::parse(toJson(BenchReport{}));
  EXPECT_TRUE(empty["strategies"].empty());
  EXPECT_TRUE(empty["cpu_quadtree"].is_null());
}

TEST(BenchReport, SpeedIsThatOfS0WhereverItStands) {
  BenchReport report;
  report.scenes = {scene("one.glb", 1.0), scene("two.glb", 1.0)};
  std::swap(report.scenes[0].strategies[0], report.scenes[0].strategies[1]);
  report.scenes[1].strategies.erase(report.scenes[1].strategies.begin());
  const std::string html = toHtml(report);
  EXPECT_NE(html.find("one.glb</th><td>80.0</td><td>2.00</td><td>40 ×</td>"), std::string::npos);
  EXPECT_NE(html.find("two.glb</th><td>80.0</td><td>not run</td><td>–</td>"), std::string::npos);
}

TEST(BenchReport, PageSaysWhichSizesWereSkipped) {
  BenchReport report;
  report.scenes = {scene("one.glb", 1.0)};
  report.scenes[0].sweep = {variant(64, "<too many>"), variant(128, "")};
  const std::string html = toHtml(report);
  EXPECT_NE(html.find("<th scope=\"row\">64</th><td>1</td><td>32</td><td>8 : 1</td>"
                      "<td class=\"note\" colspan=\"9\">skipped: &lt;too many&gt;</td></tr>"),
            std::string::npos);
  EXPECT_NE(html.find("<th scope=\"row\">128</th><td>1</td><td>32</td><td>8 : 1</td><td>2</td>"),
            std::string::npos);
}

TEST(BenchReport, PageStandsAloneAndEscapes) {
  BenchReport report;
  report.scenes = {scene("<b>&one.glb", 1.0)};
  report.context.renderer = "a <script> b";
  const std::string html = toHtml(report);
  const std::string chart = readText(TESSERA_CHART_JS);
  ASSERT_GT(chart.size(), 100000u);
  const std::size_t at = html.find(chart);
  ASSERT_NE(at, std::string::npos) << "the chart library is not in the page";
  const std::string own = std::string(html).replace(at, chart.size(), "");
  EXPECT_EQ(own.find("{{"), std::string::npos);
  EXPECT_EQ(own.find("http://"), std::string::npos);
  EXPECT_EQ(own.find("https://"), std::string::npos);
  EXPECT_EQ(own.find("<b>&one"), std::string::npos);
  EXPECT_NE(own.find("&lt;b&gt;&amp;one.glb"), std::string::npos);
  EXPECT_NE(own.find("a &lt;script&gt; b"), std::string::npos);
  // The table of speed: CPU, GPU, speed-up, frame, share.
  EXPECT_NE(own.find("<td>80.0</td><td>2.00</td><td>40 ×</td><td>200</td><td>0.50 %</td>"),
            std::string::npos);
  // S0's row.
  EXPECT_NE(own.find("<th scope=\"row\">S0</th><td>2</td><td>8</td><td>1</td><td>50.0 %</td><td>90.00 %</td>"
                     "<td>37.00 %</td><td>10.00 %</td><td>0.50</td>"),
            std::string::npos);
  const std::string open = "<script type=\"application/json\" id=\"data\">";
  const std::size_t start = own.find(open) + open.size();
  const Json data = Json::parse(own.substr(start, own.find("</script>", start) - start));
  const Json& runs = data["scenes"][0]["runs"];
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_EQ(runs[0]["oomFrames"], 2);
  EXPECT_EQ(runs[0]["resets"], 1);
  ASSERT_EQ(runs[2]["areas"].size(), 5u);
  EXPECT_TRUE(runs[0]["ms"][0].is_null());
}

}  // namespace
}  // namespace tessera
