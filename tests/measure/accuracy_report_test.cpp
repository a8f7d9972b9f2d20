// What accuracy costs: the front, what can be told apart, choosing, and reading a study that may hold
// anything.
#include "apps/tessera/report/accuracy_report.hpp"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using Json = nlohmann::json;

Tradeoff trade(double cost, double error) { return {exactly(cost), exactly(error)}; }

TEST(ParetoFront, IsWhatNothingBeatsInBoth) {
  const std::vector<Tradeoff> points = {trade(5.0, 1.0), trade(1.0, 9.0), trade(3.0, 4.0), trade(4.0, 4.0),
                                        trade(3.0, 5.0), trade(2.0, 9.0), trade(6.0, 1.0)};
  EXPECT_EQ(paretoFront(points), (std::vector<std::size_t>{1, 2, 0}));
  EXPECT_TRUE(paretoFront({}).empty());
}

TEST(ParetoFront, HasOneOfEqualPointsAndNoneThatIsNotMeasured) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Tradeoff> points = {trade(nan, 0.0), trade(2.0, 3.0), trade(2.0, 3.0), trade(0.0, nan),
                                        trade(std::numeric_limits<double>::infinity(), 0.0)};
  EXPECT_EQ(paretoFront(points), (std::vector<std::size_t>{1}));
}

TEST(ParetoFront, HoldsAgainstEveryPointOfManyByTheDefinition) {
  std::vector<Tradeoff> points;
  std::uint32_t state = 1;
  const auto next = [&] { return static_cast<double>((state = state * 1664525u + 1013904223u) >> 27U); };
  for (int i = 0; i < 300; ++i) {
    const double cost = next();
    points.push_back(trade(cost, next()));
  }
  const auto front = paretoFront(points);
  const auto beats = [](const Tradeoff& a, const Tradeoff& b) {
    return a.cost.median <= b.cost.median && a.error.median <= b.error.median &&
           (a.cost.median < b.cost.median || a.error.median < b.error.median);
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool on = std::find(front.begin(), front.end(), i) != front.end();
    bool beaten = false;
    bool equalOnFront = false;
    for (std::size_t j = 0; j < points.size(); ++j) beaten = beaten || beats(points[j], points[i]);
    for (const std::size_t j : front)
      equalOnFront = equalOnFront || (points[j].cost.median == points[i].cost.median &&
                                      points[j].error.median == points[i].error.median);
    EXPECT_EQ(on, !beaten && (on || !equalOnFront)) << i;
  }
}

TEST(Distinguishable, NeedsSpreadsApartInCostAndInError) {
  const Tradeoff first{{10.0, 9.0, 11.0}, exactly(0.30)};
  EXPECT_TRUE(apart(first, {{12.0, 11.5, 13.0}, exactly(0.20)}));
  EXPECT_FALSE(apart(first, {{12.0, 10.9, 13.0}, exactly(0.20)})) << "costs overlap";
  EXPECT_FALSE(apart(first, {{12.0, 11.5, 13.0}, {0.20, 0.10, 0.31}})) << "errors overlap";
  EXPECT_FALSE(apart(trade(10.0, 0.3), trade(10.05, 0.2))) << "a spread of nothing counts as one percent";
  EXPECT_TRUE(apart(trade(10.0, 0.3), trade(10.2, 0.2)));
}

TEST(Distinguishable, ComparesWithTheLastThatCouldBeTold) {
  // Each overlaps the one before it; the fourth no longer overlaps the first.
  const std::vector<Tradeoff> points = {{{10.0, 9.0, 11.0}, exactly(0.5)},
                                        {{11.0, 10.5, 12.0}, exactly(0.4)},
                                        {{12.0, 11.0, 13.0}, exactly(0.3)},
                                        {{13.0, 12.5, 14.0}, exactly(0.2)}};
  const auto front = paretoFront(points);
  ASSERT_EQ(front.size(), 4u);
  EXPECT_EQ(distinguishable(points, front), (std::vector<bool>{true, false, false, true}));
}

AccuracyPoint point(const std::string& name, double ms, double dssim) {
  AccuracyPoint p;
  p.scene = "a.glb";
  p.name = name;
  p.config = {{"method", "rect"}, {"bias", "-0.5"}};
  p.ms = {ms, 0.9 * ms, 1.1 * ms};
  p.dssim = exactly(dssim);
  p.runs = 3;
  return p;
}

std::vector<AccuracyPoint> somePoints() {
  return {point("cheap", 1.0, 0.5), point("middle", 4.0, 0.2), point("worse", 5.0, 0.3),
          point("like", 4.2, 0.2), point("best", 9.0, 0.1)};
}

std::string nameOf(const Result<AccuracyChoice>& choice) {
  return choice ? choice->point->name : choice.error().message;
}

TEST(Choosing, TakesTheBestWithinABudget) {
  const auto points = somePoints();
  EXPECT_EQ(nameOf(bestWithin(points, 1.0)), "cheap") << "the budget itself is within it";
  EXPECT_EQ(nameOf(bestWithin(points, 3.9)), "cheap");
  const auto middle = bestWithin(points, 8.0);
  ASSERT_TRUE(middle);
  EXPECT_EQ(middle->point->name, "middle") << "of equal ones the cheaper";
  EXPECT_EQ(middle->alike, 1u);
  EXPECT_EQ(nameOf(bestWithin(points, 1e9)), "best");
  const auto none = bestWithin(points, 0.5);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("0.5"), std::string::npos) << none.error().message;
  EXPECT_NE(none.error().message.find("cheap"), std::string::npos) << none.error().message;
  EXPECT_FALSE(bestWithin({}, 1.0));
}

TEST(Choosing, TakesTheCheapestWithinATarget) {
  const auto points = somePoints();
  EXPECT_EQ(nameOf(cheapestFor(points, 1.0)), "cheap");
  EXPECT_EQ(nameOf(cheapestFor(points, 0.3)), "middle");
  EXPECT_EQ(nameOf(cheapestFor(points, 0.1)), "best");
  const auto none = cheapestFor(points, 0.05);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("best"), std::string::npos) << none.error().message;
}

AccuracyReport someReport() {
  AccuracyReport report;
  report.context.renderer = "test";
  AccuracyScene scene;
  scene.file = "a<b>.glb";
  scene.points = somePoints();
  findFront(scene.points);
  scene.knobs.push_back({"bias", "Bias", "A sentence.", {{"rect", {"0", "1"}, {0, 1}, "0"}}});
  report.scenes.push_back(std::move(scene));
  return report;
}

TEST(AccuracyJson, HasTheShapeAndReadsBack) {
  const AccuracyReport report = someReport();
  const std::string text = toJson(report);
  const Json json = Json::parse(text);
  ASSERT_EQ(json["points"].size(), 5u);
  const Json& first = json["points"][0];
  for (const char* member :
       {"scene", "config", "ms", "samples", "texels", "bytes", "dssim", "psnr_db", "flip", "pareto"})
    EXPECT_TRUE(first.contains(member)) << member;
  EXPECT_EQ(first["config"]["bias"], -0.5) << "a number is a number";
  EXPECT_EQ(first["config"]["method"], "rect");
  EXPECT_TRUE(first["psnr_db"].is_null()) << "what was not measured";
  const auto points = parseAccuracy(text, "study");
  ASSERT_TRUE(points) << points.error().message;
  ASSERT_EQ(points->size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    const AccuracyPoint& read = (*points)[i];
    const AccuracyPoint& wrote = report.scenes[0].points[i];
    EXPECT_EQ(read.config, wrote.config);
    EXPECT_EQ(read.name, wrote.name);
    EXPECT_EQ(read.ms.low, wrote.ms.low);
    EXPECT_EQ(read.ms.high, wrote.ms.high);
    EXPECT_EQ(read.dssim.median, wrote.dssim.median);
    EXPECT_EQ(read.pareto, wrote.pareto);
  }
}

TEST(AccuracyJson, OfAnythingElseIsRefusedInOneLineThatNamesWhatAndWhere) {
  const Json good = Json::parse(toJson(someReport()));
  const auto broken = [&](const char* pointer, const Json& value) {
    Json json = good;
    json[Json::json_pointer(pointer)] = value;
    return json.dump();
  };
  const auto without = [&](const char* member) {
    Json json = good;
    json["points"][1].erase(member);
    return json.dump();
  };
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "not JSON"},
      {"{\"points\":[", "not JSON"},
      {"\xff\xfe", "not JSON"},
      {"[]", "[] is not an object"},
      {"{}", "points is missing"},
      {"{\"points\":3}", "points: 3 is not an array"},
      {"{\"points\":[]}", "no configuration"},
      {"{\"points\":[7]}", "points[0]: 7 is not an object"},
      {broken("/schema", 2), "schema: 2"},
      {broken("/points/2/ms", "fast"), "points[2].ms: \"fast\""},
      {broken("/points/2/ms", -1.0), "points[2].ms: -1.0"},
      {broken("/points/2/ms", nullptr), "points[2].ms: null"},
      {broken("/points/2/ms_low", 1e9), "points[2].ms_low"},
      {broken("/points/2/dssim", Json::array()), "points[2].dssim: []"},
      {broken("/points/2/pareto", 1), "points[2].pareto: 1"},
      {broken("/points/2/scene", 5), "points[2].scene: 5"},
      {broken("/points/2/config", "rect"), "points[2].config: \"rect\""},
      {broken("/points/2/config/bias", Json::array({1})), "points[2].config.bias: [1]"},
      {without("scene"), "points[1].scene is missing"},
      {without("config"), "points[1].config is missing"},
      {without("ms"), "points[1].ms is missing"},
      {without("dssim"), "points[1].dssim is missing"},
      {"{\"points\":[{\"ms\":1e999}]}", "study: "},
      {std::string(100000, '['), "nested deeper"},
      {broken("/points/2/ms", std::string(100000, 'x')), "points[2].ms"},
  };
  for (const auto& [text, named] : cases) {
    const auto points = parseAccuracy(text, "study");
    const std::string start = text.substr(0, 60);
    ASSERT_FALSE(points) << start;
    const std::string& message = points.error().message;
    EXPECT_EQ(message.rfind("study", 0), 0u) << message;
    EXPECT_NE(message.find(named), std::string::npos) << start << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), 200u) << start;
  }
}

TEST(AccuracyJson, CutShortAnywhereIsRefused) {
  const std::string text = toJson(someReport());
  // Behind the last brace there is a line end.
  for (std::size_t length = 0; length + 2 < text.size(); length += 7)
    EXPECT_FALSE(parseAccuracy(std::string_view(text).substr(0, length), "study")) << length;
}

TEST(AccuracyPage, IsWholeAndEscaped) {
  const std::string page = toHtml(someReport());
  EXPECT_EQ(page.find("{{"), std::string::npos);
  EXPECT_EQ(page.find("a<b>.glb"), std::string::npos);
  EXPECT_NE(page.find("a&lt;b&gt;.glb"), std::string::npos);
  EXPECT_EQ(page.find("https://"), page.find("https://www.chartjs.org")) << "nothing is fetched";
  EXPECT_NE(page.find("\"ms/dssim\""), std::string::npos);
}

}  // namespace
}  // namespace tessera
