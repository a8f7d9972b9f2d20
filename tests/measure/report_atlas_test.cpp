// What a report derives of atlases.
#include "apps/tessera/report/report_atlas.hpp"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

/// Forward, rect and another method of 100 x 50 pixels.
Report atlasReport() {
  Report report;
  ReportScene& scene = report.scenes.emplace_back();
  scene.file = "a.glb";
  scene.width = 100;
  scene.height = 50;
  scene.atlasReference = "rect";
  const auto display = [](double ms) { return summarize(std::vector<double>{ms}); };
  scene.methods.reserve(3);  // the references below outlive what comes after them
  ReportMethod& forward = scene.methods.emplace_back();
  forward.name = "forward";
  forward.mssim = 1.0;
  forward.nsPerSample = 20.0;
  forward.nsPerPassed = 80.0;
  ReportMethod& rect = scene.methods.emplace_back();
  rect.name = "rect";
  rect.mssim = 0.9;
  rect.samplesShaded = 5000.0;
  rect.takenTexels = 8000.0;
  rect.visibleTriangles = 200.0;
  rect.decodeBytes = 1600.0;
  rect.displayBytes = 6400.0;
  rect.nsPerSample = 60.0;
  rect.displayMs = display(8.0);
  rect.kinds = {{"block <b>", "#010203", 4900.0}, {"single", "#040506", 100.0}};
  rect.curve = {{-1.0, 2.0, 0.95, 1.0}, {0.0, 1.0, 0.9, 1.0}, {2.0, 0.25, 0.7, 1.0}};
  ReportMethod& other = scene.methods.emplace_back(rect);
  other.name = "texels";
  other.displayMs = display(12.0);
  other.kinds = {{"tile", "#070809", 5000.0}};
  other.curve = {{-1.0, 4.0, 0.98, 1.0}, {0.0, 2.0, 0.92, 1.0}, {2.0, 0.5, 0.8, 1.0}};
  ReportMethod moving = rect;
  moving.mssim = 0.896;
  moving.samplesShaded = 7500.0;
  scene.pvs.push_back({{"rect", 0.1, 40.0, 21}, moving});
  return report;
}

TEST(ReportAtlas, RatiosAreAgainstForwardAndRect) {
  const Report report = atlasReport();
  const ReportScene& scene = report.scenes[0];
  const ReportMethod& rect = scene.methods[1];
  EXPECT_DOUBLE_EQ(perSampleAgainstPassed(scene, rect), 0.75);
  EXPECT_DOUBLE_EQ(perSampleAgainstInvocation(scene, rect), 3.0);
  EXPECT_DOUBLE_EQ(perSampleAgainstPassed(scene, scene.methods[0]), 1.0);
  EXPECT_DOUBLE_EQ(displayAgainstAtlas(scene, rect), 1.0);
  EXPECT_DOUBLE_EQ(displayAgainstAtlas(scene, scene.methods[2]), 1.5);
  EXPECT_TRUE(std::isnan(displayAgainstAtlas(scene, scene.methods[0])));
  EXPECT_DOUBLE_EQ(wastedTexels(rect), 3000.0);
  EXPECT_DOUBLE_EQ(decodeBytesPerTriangle(rect), 8.0);
  EXPECT_DOUBLE_EQ(displayBytesPerTriangle(rect), 32.0);
  EXPECT_DOUBLE_EQ(samplesAgainstPlain(scene, scene.pvs[0]), 1.5);
  EXPECT_NEAR(dssimAgainstPlain(scene, scene.pvs[0]), 1.04, 1e-12);
}

TEST(ReportAtlas, CurvesAreReadBetweenTheirPoints) {
  const ReportScene scene = atlasReport().scenes[0];
  const ReportMethod& other = scene.methods[2];
  EXPECT_DOUBLE_EQ(curveMssimAt(other, 2.0), 0.92);
  EXPECT_NEAR(curveMssimAt(other, 1.0), 0.86, 1e-12) << "halfway in the logarithm";
  EXPECT_NEAR(curveSamplesAt(other, 0.86), 1.0, 1e-12);
  EXPECT_NEAR(curveSamplesAt(other, 0.95), std::sqrt(8.0), 1e-9);
  for (const double beyond : {0.4, 4.1}) EXPECT_TRUE(std::isnan(curveMssimAt(other, beyond)));
  for (const double beyond : {0.79, 0.99}) EXPECT_TRUE(std::isnan(curveSamplesAt(other, beyond)));
  EXPECT_TRUE(std::isnan(curveMssimAt(scene.methods[0], 1.0))) << "no curve";
}

TEST(ReportAtlas, AnyKindOfSampleIsShownByItsName) {
  const Report report = atlasReport();
  EXPECT_EQ(kindNames(report.scenes[0]), (std::vector<std::string>{"block <b>", "single", "tile"}));
  const Json json = Json::parse(toJson(report))["scenes"][0];
  EXPECT_EQ(json["methods"][2]["kinds"][0]["name"], "tile");
  EXPECT_EQ(json["methods"][1]["kinds"][1]["samples"], 100.0);
  EXPECT_EQ(json["pvs"][0]["of"], "rect");
  EXPECT_EQ(json["pvs"][0]["samples_against_still"], 1.5);
  const std::string tables = atlasTables(report.scenes[0]);
  EXPECT_NE(tables.find("<th scope=\"col\">block &lt;b&gt;</th>"), std::string::npos);
  EXPECT_NE(tables.find("<th scope=\"row\">rect</th><td>–</td><td>60.0</td><td>0.75 ×</td><td>3.00 ×</td>"
                        "<td>5,000</td><td>4,900</td><td>100</td><td>–</td>"),
            std::string::npos)
      << tables;
  EXPECT_NE(tables.find("0.1, 40°</td><td>21</td><td>200</td><td>7,500</td><td>150.0 %</td>"),
            std::string::npos);
  EXPECT_NE(tables.find("<th scope=\"row\">texels</th><td>0.8600</td><td>1.59</td><td>1.59 ×</td>"),
            std::string::npos)
      << tables;
  Report bare;
  bare.scenes.emplace_back().methods.emplace_back().name = "forward";
  EXPECT_EQ(atlasTables(bare.scenes[0]), "") << "nothing of atlases without one";
}

}  // namespace
}  // namespace tessera
