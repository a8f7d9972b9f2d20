// What `tessera compare` says of methods that fill an atlas, as a user reads it in report.json.
#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "tests/apps/cli.hpp"

namespace tessera {
namespace {

using Json = nlohmann::json;

class CompareAtlas : public test::Cli {
 protected:
  /// The one scene of a report with these options; null, with a failure, where the program failed.
  Json compared(const std::string& options) {
    const test::Ran ran = run(
        fmt::format("compare '{}' -o report --size 320x180 --context osmesa --metrics mssim --warmup 1 {}",
                    atrium(), options));
    EXPECT_EQ(ran.code, 0) << ran.error;
    out_ = ran.out;
    return ran.code == 0 ? Json::parse(test::slurp(folder_ / "report" / "report.json"))["scenes"][0] : Json();
  }
  std::string out_;
};

const Json& named(const Json& methods, const std::string& name) {
  static const Json none;
  for (const Json& method : methods)
    if (method["name"] == name) return method;
  ADD_FAILURE() << "no method " << name;
  return none;
}

double samplesOf(const Json& method, const std::string& kind) {
  for (const Json& own : method["kinds"])
    if (own["name"] == kind) return own["samples"].get<double>();
  return -1.0;
}

TEST_F(CompareAtlas, NumbersOfAnAtlasAgreeWithEachOther) {
  const Json scene = compared("--frames 2 --methods forward,rect,tess,lpack,oversample");
  ASSERT_FALSE(scene.is_null());
  EXPECT_EQ(scene["atlas_reference"], "rect");
  const Json& forward = named(scene["methods"], "forward");
  EXPECT_TRUE(forward["kinds"].empty());
  EXPECT_TRUE(forward["atlas_texels_taken"].is_null());
  for (const char* name : {"rect", "tess", "lpack", "oversample"}) {
    SCOPED_TRACE(name);
    const Json& m = named(scene["methods"], name);
    const auto number = [&](const char* field) { return m.at(field).get<double>(); };
    double samples = 0.0;
    for (const Json& kind : m["kinds"]) samples += kind["samples"].get<double>();
    EXPECT_NEAR(samples, number("samples_shaded"), 1.0);
    EXPECT_GT(samples, 1000.0);
    EXPECT_EQ(number("samples_allocated"), number("samples_shaded"));
    EXPECT_GE(number("atlas_texels_taken"), number("samples_shaded"));
    EXPECT_DOUBLE_EQ(number("atlas_texels_wasted"), number("atlas_texels_taken") - number("samples_shaded"));
    EXPECT_DOUBLE_EQ(number("dssim"), (1.0 - number("mssim")) / 2.0);
    EXPECT_DOUBLE_EQ(number("per_sample_against_passed"),
                     number("ns_per_sample") / forward["ns_per_passed"].get<double>());
    EXPECT_DOUBLE_EQ(number("per_sample_against_invocation"),
                     number("ns_per_sample") / forward["ns_per_sample"].get<double>());
    EXPECT_DOUBLE_EQ(number("display_against_rect"),
                     m["display_ms"]["median"].get<double>() /
                         named(scene["methods"], "rect")["display_ms"]["median"].get<double>());
    EXPECT_LT(number("decode_bytes_per_triangle"), number("display_bytes_per_triangle"));
    ASSERT_FALSE(m["packings"].empty());
    double packed = 0.0;
    for (const Json& packing : m["packings"]) {
      packed += packing["samples"].get<double>();
      EXPECT_GT(packing["filled"].get<double>(), 0.85) << packing["name"];
      EXPECT_LE(packing["filled"].get<double>(), 1.0) << packing["name"];
    }
    EXPECT_NEAR(packed + samplesOf(m, "single"), samples, 1.0);
  }
  const Json& tess = named(scene["methods"], "tess");
  const Json& lpack = named(scene["methods"], "lpack");
  const Json& oversample = named(scene["methods"], "oversample");
  EXPECT_TRUE(named(scene["methods"], "rect")["slanted_share"].is_null());
  EXPECT_EQ(lpack["slanted_share"], 0.0);
  EXPECT_GT(oversample["slanted_share"], 0.8);
  EXPECT_GT(tess["slanted_share"], 0.1);
  EXPECT_LT(tess["slanted_share"], oversample["slanted_share"]);
  EXPECT_EQ(samplesOf(lpack, "Oversampling inside"), 0.0);
  EXPECT_EQ(samplesOf(oversample, "L"), 0.0);
  EXPECT_EQ(lpack["decode_bytes_per_triangle"], 8.0);
  EXPECT_GT(oversample["decode_bytes_per_triangle"], 16.0);
  EXPECT_LE(oversample["decode_bytes_per_triangle"], 20.0);
  // 10 to 50 %: on real scenes a quarter to a third of Oversampling's samples lie outside.
  for (const Json* m : {&tess, &oversample}) {
    const double share = samplesOf(*m, "Oversampling outside") / samplesOf(*m, "Oversampling inside");
    EXPECT_GT(share, 0.1);
    EXPECT_LT(share, 1.0);
  }
  ASSERT_FALSE(scene["crops"].empty());
  for (const Json& crop : scene["crops"]) {
    EXPECT_GT(crop["slanted_share"], 0.1);
    EXPECT_LE(crop["slanted_share"], 1.0);
    ASSERT_EQ(crop["pictures"].size(), 5u);
    EXPECT_EQ(crop["pictures"][0]["mssim"], 1.0) << "forward equals itself";
    EXPECT_EQ(crop["pictures"][2]["method"], "tess");
    EXPECT_LT(crop["pictures"][2]["mssim"], 1.0);
    EXPECT_GT(crop["pictures"][2]["mssim"], 0.3);
  }
  EXPECT_TRUE(scene["pvs"].empty());
  EXPECT_NE(out_.find("Oversampling outside"), std::string::npos);
}

TEST_F(CompareAtlas, SamplesAreMadeEqual) {
  const Json scene =
      compared("--frames 2 --equal-samples --methods rect:bias=-0.5,tess,oversample:slanted=9");
  ASSERT_FALSE(scene.is_null());
  ASSERT_EQ(scene["methods"].size(), 4u);
  const Json& rect = named(scene["methods"], "rect:bias=-0.5");
  EXPECT_TRUE(rect["equal_samples"].is_null());
  for (const std::size_t i : {std::size_t{2}, std::size_t{3}}) {
    const Json& m = scene["methods"][i];
    SCOPED_TRACE(m["name"]);
    EXPECT_NEAR(m["samples_shaded"].get<double>() / rect["samples_shaded"].get<double>(), 1.0, 0.1);
    EXPECT_NEAR(m["equal_samples"], 1.0, 0.1);
    const double bias = m["constant_bias"];
    EXPECT_GT(std::abs(bias), 0.05);
    EXPECT_EQ(m["name"], fmt::format("{}bias={:g}", i == 2 ? "tess:" : "oversample:slanted=9+", bias));
    EXPECT_NE(out_.find(fmt::format("bias {:g}", bias)), std::string::npos) << "the bias is printed";
  }
}

TEST_F(CompareAtlas, VisibleSetsOfMovingCamerasTakeMoreSamplesForTheSamePicture) {
  const Json scene =
      compared("--frames 1 --pvs all --pvs 0.05,0 --methods rect,tess,rect-stereo --atlas-mpix 16");
  ASSERT_FALSE(scene.is_null());
  ASSERT_EQ(scene["pvs"].size(), 8u) << "not for stereo, nor for forward";
  for (const char* name : {"rect", "tess"}) {
    SCOPED_TRACE(name);
    const Json& still = named(scene["methods"], name);
    double samples = still["samples_shaded"];
    std::vector<double> radii;
    for (const Json& row : scene["pvs"]) {
      if (row["of"] != name) continue;
      radii.push_back(row["radius"]);
      EXPECT_NEAR(row["dssim"].get<double>() / still["dssim"].get<double>(), 1.0, 0.05);
      EXPECT_NEAR(row["dssim_against_still"], 1.0, 0.05);
      EXPECT_EQ(row["holes"], 0.0);
      EXPECT_DOUBLE_EQ(row["samples_against_still"],
                       row["samples_shaded"].get<double>() / still["samples_shaded"].get<double>());
      // In the order of --pvs: the last one given turns nowhere.
      if (radii.size() == 4) {
        EXPECT_EQ(row["pvs_views"], 6);
        samples = still["samples_shaded"];
      }
      EXPECT_GT(row["samples_shaded"], samples);
      EXPECT_GT(row["visible_triangles"], still["visible_triangles"]);
      samples = row["samples_shaded"];
    }
    EXPECT_EQ(radii, (std::vector<double>{0.1, 0.2, 0.3, 0.05}));
  }
}

TEST_F(CompareAtlas, CurvesFallWithTheBias) {
  const Json scene = compared("--frames 1 --curve --methods rect:bias=0.5,tess");
  ASSERT_FALSE(scene.is_null());
  for (const char* name : {"rect:bias=0.5", "tess"}) {
    SCOPED_TRACE(name);
    const Json& m = named(scene["methods"], name);
    const Json& curve = m["curve"];
    ASSERT_EQ(curve.size(), 5u);
    const double own = m["constant_bias"];
    EXPECT_EQ(curve[0]["bias"], own - 1.0);
    EXPECT_EQ(curve[4]["bias"], own + 2.0);
    EXPECT_NEAR(curve[2]["samples_per_pixel"].get<double>(), m["shaded_per_target_pixel"].get<double>(),
                1e-9);
    EXPECT_NEAR(curve[2]["mssim"].get<double>(), m["mssim"].get<double>(), 1e-4) << "other places";
    for (std::size_t i = 1; i < curve.size(); ++i) {
      EXPECT_LT(curve[i]["samples_per_pixel"], curve[i - 1]["samples_per_pixel"]);
      // Much finer than the picture an atlas aliases.
      if (i > 2) {
        EXPECT_LT(curve[i]["mssim"], curve[i - 1]["mssim"]);
      }
    }
  }
  EXPECT_TRUE(named(scene["methods"], "forward")["curve"].empty());
}

TEST_F(CompareAtlas, BadOptionsAreRefusedByOneLine) {
  const std::string compare = fmt::format("compare '{}' -o r ", atrium());
  const std::pair<const char*, const char*> bad[] = {
      {"--pvs 0.1", "--pvs 0.1: not two numbers"},
      {"--pvs some", "--pvs some"},
      {"--pvs 0.1,40,2", "--pvs 0.1,40,2"},
      {"--pvs=-1,40", "radius -1 is outside"},
      {"--pvs nan,40", "radius nan is outside"},
      {"--pvs 0.1,181", "181 degrees are outside"},
      {"--pvs 0.1,nan", "nan degrees are outside"},
      {"--pvs all --methods forward", "--pvs: no method"},
      {"--pvs all --methods rect-stereo", "--pvs: no method"},
      {"--pvs all --figures 4.1", "--pvs"},
      {"--curve --methods forward", "--curve: no method"},
      {"--equal-samples --methods tess", "--equal-samples: --methods has no rect"}};
  for (const auto& [options, named] : bad) {
    expectRefused(compare + options, named);
    std::string error = test::slurp(folder_ / "err.txt");
    error.resize(std::min(error.size(), error.find("Run with --help")));
    EXPECT_EQ(std::count(error.begin(), error.end(), '\n'), 1) << error;
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "r"));
}

}  // namespace
}  // namespace tessera
