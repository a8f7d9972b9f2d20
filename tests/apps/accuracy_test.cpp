// tessera accuracy from a scene to a study, and tessera render by one.
#include <nlohmann/json.hpp>

#include "tests/apps/cli.hpp"

namespace tessera {
namespace {

using test::Cli;
using test::Ran;
using test::slurp;
using Json = nlohmann::json;

class Accuracy : public Cli {};

TEST_F(Accuracy, StudiesAndRendersByWhatItFound) {
  const Ran ran = run(fmt::format(
      "accuracy '{}' --context osmesa --size 96x54 --places 1 --repeats 2 --quick --knobs bias,patches "
      "--combinations 1 --supersampling 2 -o study",
      atrium()));
  ASSERT_EQ(ran.code, 0) << ran.error;
  const Json study = Json::parse(slurp(folder_ / "study" / "accuracy.json"), nullptr, false);
  ASSERT_TRUE(study.is_object());
  const Json& points = study["points"];
  ASSERT_GT(points.size(), 20u);
  int front = 0;
  double forward = 0.0;
  double coarse = 0.0;
  double fine = 0.0;
  for (const Json& point : points) {
    SCOPED_TRACE(point["name"]);
    EXPECT_EQ(point["scene"], "atrium.glb");
    EXPECT_GT(point["ms"], 0.0);
    EXPECT_LE(point["ms_low"], point["ms"]);
    EXPECT_GE(point["ms_high"], point["ms"]);
    EXPECT_GE(point["runs"], 2);
    EXPECT_GT(point["samples"], 0.0);
    EXPECT_GT(point["bytes"], 0.0);
    EXPECT_GT(point["dssim"], 0.0);
    EXPECT_LT(point["dssim"], 0.5);
    EXPECT_GT(point["psnr_db"], 10.0);
    EXPECT_GT(point["flip"], 0.0);
    front += point["pareto"].get<bool>() ? 1 : 0;
    if (point["name"] == "forward") forward = point["dssim"];
    if (point["name"] == "rect, bias 2") coarse = point["samples"];
    if (point["name"] == "rect, bias -2") fine = point["samples"];
  }
  EXPECT_GE(front, 1);
  EXPECT_LT(forward, 0.15) << "the reference is of the same views";
  EXPECT_GT(fine, 4.0 * coarse) << "knobs are turned";
  ASSERT_EQ(study["scenes"].size(), 1u);
  for (const Json& knob : study["scenes"][0]["knobs"])
    for (const Json& curve : knob["curves"]) {
      ASSERT_EQ(curve["values"].size(), curve["points"].size());
      for (std::size_t i = 0; i < curve["points"].size(); ++i)
        EXPECT_EQ(points[curve["points"][i].get<std::size_t>()]["config"][knob["name"].get<std::string>()],
                  curve["values"][i]);
    }
  EXPECT_NE(slurp(folder_ / "study" / "accuracy.html").find("atrium.glb"), std::string::npos);

  const Ran chosen = run(fmt::format(
      "render '{}' --context osmesa --size 96x54 --study study/accuracy.json --target-dssim 0.4 -o a.png",
      atrium()));
  ASSERT_EQ(chosen.code, 0) << chosen.error;
  EXPECT_NE(chosen.out.find("chosen: "), std::string::npos) << chosen.out;
  EXPECT_NE(chosen.out.find("why: "), std::string::npos) << chosen.out;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "a.png"));
  expectRefused(fmt::format("render '{}' -o a.png --study study/accuracy.json --budget-ms 1e-6", atrium()),
                "no configuration takes 1e-06 ms or less");
}

TEST_F(Accuracy, RefusesWhatIsNoStudy) {
  expectRefused(fmt::format("accuracy '{}' -o x --knobs speed", atrium()), "--knobs speed: not one of");
  expectRefused(fmt::format("render '{}' -o a.png --study none.json --budget-ms 5", atrium()), "none.json");
  expectRefused(fmt::format("render '{}' -o a.png --study none.json", atrium()),
                "--budget-ms or --target-dssim");
  expectRefused(fmt::format("render '{}' -o a.png --budget-ms 5", atrium()), "--study");
  std::ofstream(folder_ / "bad.json")
      << R"({"points": [{"scene": "atrium.glb", "config": {"bias": 1}, "ms": "5"}]})";
  expectRefused(fmt::format("render '{}' -o a.png --study bad.json --budget-ms 5", atrium()),
                "bad.json: points[0].ms: \"5\" is not a number");
}

}  // namespace
}  // namespace tessera
