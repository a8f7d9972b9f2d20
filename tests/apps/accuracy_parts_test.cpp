// The knobs of an accuracy study, what it plans to measure, its reference, and choosing from it.
#include <cmath>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/tessera/accuracy/choose.hpp"
#include "apps/tessera/accuracy/plan.hpp"
#include "apps/tessera/accuracy/supersample.hpp"

namespace tessera::app {
namespace {

TEST(Knobs, HoldTogether) {
  std::set<std::string> names;
  for (const Knob& knob : knobs()) {
    SCOPED_TRACE(knob.name);
    EXPECT_TRUE(names.insert(knob.name).second) << "twice";
    EXPECT_FALSE(knob.label.empty());
    EXPECT_TRUE(knob.sentence.ends_with(".")) << knob.sentence;
    const auto has = [](const std::vector<std::string>& values, const std::string& value) {
      return std::find(values.begin(), values.end(), value) != values.end();
    };
    EXPECT_TRUE(has(knob.values, knob.standard));
    for (const std::string& value : knob.quickValues) EXPECT_TRUE(has(knob.values, value)) << value;
    EXPECT_FALSE(knob.curves.empty());
    for (const Settings& curve : knob.curves)
      for (const std::string& value : knob.values) {
        const auto configuration = configurationOf(withKnob(curve, knob.name, value));
        EXPECT_TRUE(configuration) << value << ": " << configuration.error().message;
      }
    const auto refused = configurationOf(withKnob(knob.curves[0], knob.name, "no such value"));
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("'no such value'"), std::string::npos) << refused.error().message;
  }
}

TEST(Knobs, DoWhatTheySay) {
  const auto turned = configurationOf({{"method", "tess"},
                                       {"bias", "-1.5"},
                                       {"decode", "plain"},
                                       {"shadow-size", "512"},
                                       {"display", "deferred"},
                                       {"mpix", "2"}});
  ASSERT_TRUE(turned) << turned.error().message;
  EXPECT_EQ(turned->method.kind, Kind::RectDeferred);
  EXPECT_EQ(turned->method.atlas.sampling, Sampling::Tess);
  EXPECT_EQ(turned->method.atlas.bias, -1.5);
  EXPECT_EQ(turned->method.atlas.megapixels, 2.0);
  EXPECT_TRUE(turned->method.atlas.plainDecode);
  EXPECT_EQ(turned->shadowSize, 512);
}

TEST(Knobs, RefuseWhatDoesNotGoTogether) {
  const std::vector<std::pair<Settings, std::string>> cases = {
      {{{"speed", "1"}}, "speed: not one of"},
      {{{"bias", "0"}, {"bias", "1"}}, "bias: set twice"},
      {{{"method", "forward"}, {"bias", "0"}}, "bias: method forward does not heed it"},
      {{{"method", "rect"}, {"decode", "plain"}}, "decode: method rect does not heed it"},
      {{{"bias", "nan"}}, "bias: 'nan'"},
      {{{"bias", "1e300"}}, "bias: '1e300'"},
      {{{"bias", "1 "}}, "bias: '1 '"},
      {{{"superblock", "100"}}, "superblock: '100'"},
      {{{"shadow-size", "1000000"}}, "shadow-size: '1000000'"}};
  for (const auto& [settings, named] : cases) {
    const auto configuration = configurationOf(settings);
    ASSERT_FALSE(configuration) << named;
    EXPECT_EQ(configuration.error().message.rfind(named, 0), 0u) << configuration.error().message;
  }
}

TEST(Knobs, CompletedSettingsOfLikeConfigurationsAreEqual) {
  EXPECT_EQ(*completed({}), *completed({{"bias", "0"}, {"method", "rect"}}));
  EXPECT_NE(*completed({}), *completed({{"bias", "1"}}));
  EXPECT_EQ(nameOf(*completed({})), "rect");
  EXPECT_EQ(nameOf(*completed({{"bias", "-2"}, {"method", "texel"}})), "texel, bias -2");
}

TEST(Plan, TurnsEachKnobByItself) {
  for (const bool quick : {false, true}) {
    const auto plan = planSweep(quick);
    ASSERT_TRUE(plan) << plan.error().message;
    const std::set<Settings> unique(plan->configurations.begin(), plan->configurations.end());
    EXPECT_EQ(unique.size(), plan->configurations.size());
    for (const PlannedCurve& curve : plan->curves) {
      const Knob& knob = knobs()[curve.knob];
      ASSERT_EQ(curve.points.size(), curve.values.size());
      for (std::size_t i = 0; i < curve.points.size(); ++i) {
        const Settings& configuration = plan->configurations[curve.points[i]];
        EXPECT_EQ(settingOf(configuration, knob.name), curve.values[i]);
        if (knob.name == "method") continue;
        for (const auto& [name, value] : curve.with)
          EXPECT_EQ(settingOf(configuration, name), name == knob.name ? curve.values[i] : value) << knob.name;
      }
    }
  }
  const std::vector<std::string> only = {"bias"};
  const auto few = planSweep(true, only);
  ASSERT_TRUE(few);
  for (const PlannedCurve& curve : few->curves)
    EXPECT_LE(curve.knob, 1u) << "the method, and what was asked for";
}

Measured measured(const Settings& settings, double cost, double error) {
  return {*completed(settings), {exactly(cost), exactly(error)}};
}

TEST(Plan, CombinesWhatIsWorthIt) {
  const std::vector<Measured> singles = {
      measured({}, 10.0, 0.10),
      measured({{"bias", "-2"}}, 30.0, 0.05),           // better
      measured({{"shadow-size", "256"}}, 5.0, 0.101),   // much cheaper, its error within the spread
      measured({{"format", "rgba16f"}}, 12.0, 0.11),    // worse in both
      measured({{"patches", "alone"}}, 10.04, 0.1001),  // no different
      measured({{"method", "forward"}}, 100.0, 0.20)};  // beaten, and nothing to combine
  const auto combined = worthCombining(singles, 10);
  ASSERT_EQ(combined.size(), 1u);
  EXPECT_EQ(combined[0], *completed({{"bias", "-2"}, {"shadow-size", "256"}}));
  EXPECT_TRUE(worthCombining(singles, 0).empty());
  EXPECT_TRUE(worthCombining({}, 10).empty());
  auto known = singles;
  known.push_back(measured({{"bias", "-2"}, {"shadow-size", "256"}}, 15.0, 0.05));
  EXPECT_TRUE(worthCombining(known, 10).empty()) << "measured already";
}

TEST(Supersampling, AveragesLightNotCodes) {
  Image image{4, 2, std::vector<std::uint8_t>(4 * 2 * 4, 255)};
  // The left two by two: two black, two white.
  for (const auto& [x, y] : {std::pair(0, 0), std::pair(1, 1)})
    for (int c = 0; c < 3; ++c) image.at(x, y)[c] = 0;
  const Image mean = averaged(image, 2);
  ASSERT_EQ(mean.width, 2);
  ASSERT_EQ(mean.height, 1);
  EXPECT_EQ(mean.at(0, 0)[0], 188) << "half of white's light is 0.735 encoded";
  EXPECT_EQ(mean.at(1, 0)[2], 255);
  EXPECT_EQ(mean.at(0, 0)[3], 255);
  for (int code = 0; code < 256; ++code) {
    const Image flat{3, 3, std::vector<std::uint8_t>(36, static_cast<std::uint8_t>(code))};
    EXPECT_EQ(averaged(flat, 3).pixels[0], code) << "what is flat stays";
    EXPECT_EQ(averaged(flat, 1).pixels, flat.pixels);
  }
}

std::string study() {
  using Json = nlohmann::json;
  const auto point = [](const char* scene, const Json& config, double ms, double dssim) {
    return Json{{"scene", scene}, {"config", config}, {"ms", ms},    {"samples", 1},    {"texels", 1},
                {"bytes", 1},     {"dssim", dssim},   {"flip", 0.1}, {"psnr_db", 30.0}, {"pareto", true}};
  };
  return Json{{"points",
               {point("a.glb", {{"method", "rect"}, {"bias", 1}}, 5.0, 0.2),
                point("folder/a.glb", {{"method", "tess"}, {"bias", -1.5}}, 20.0, 0.05),
                point("b.glb", {{"method", "forward"}}, 1.0, 0.01)}}}
      .dump();
}

TEST(ChooseFromAStudy, TakesTheSceneAndSaysWhy) {
  const auto best = chooseIn(study(), {"s.json", 30.0, {}}, "other/a.glb");
  ASSERT_TRUE(best) << best.error().message;
  EXPECT_EQ(best->configuration.method.atlas.sampling, Sampling::Tess);
  EXPECT_EQ(best->configuration.method.atlas.bias, -1.5);
  EXPECT_NE(best->reason.find("tess, bias -1.5"), std::string::npos) << best->reason;
  EXPECT_NE(best->reason.find("30 ms"), std::string::npos) << best->reason;
  EXPECT_NE(best->reason.find("next cheaper: rect, bias 1"), std::string::npos) << best->reason;
  const auto cheapest = chooseIn(study(), {"s.json", {}, 0.5}, "a.glb");
  ASSERT_TRUE(cheapest);
  EXPECT_EQ(cheapest->configuration.method.atlas.bias, 1.0);
}

TEST(ChooseFromAStudy, RefusesOtherScenesAndUnknownSettings) {
  const auto refused = [](const std::string& text, const std::string& scene, const std::string& named) {
    const auto chosen = chooseIn(text, {"s.json", 30.0, {}}, scene);
    ASSERT_FALSE(chosen) << named;
    EXPECT_NE(chosen.error().message.find(named), std::string::npos) << chosen.error().message;
    EXPECT_EQ(chosen.error().message.rfind("s.json", 0), 0u) << chosen.error().message;
  };
  refused(study(), "c.glb", "none is of scene c.glb, they are of a.glb, folder/a.glb, b.glb");
  auto json = nlohmann::json::parse(study());
  json["points"][2]["config"]["bias"] = 1;
  refused(json.dump(), "a.glb", "points[2].config.bias: method forward does not heed it");
  json = nlohmann::json::parse(study());
  json["points"][1]["config"]["bias"] = 99;
  refused(json.dump(), "a.glb", "points[1].config.bias: '99'");
}

}  // namespace
}  // namespace tessera::app
