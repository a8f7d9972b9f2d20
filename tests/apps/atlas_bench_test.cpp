// tessera atlas-bench from recording to report.
#include <nlohmann/json.hpp>

#include "tests/apps/cli.hpp"

namespace tessera {
namespace {

using test::Cli;
using test::Ran;
using test::slurp;
using Json = nlohmann::json;

class AtlasBench : public Cli {
 protected:
  [[nodiscard]] Json resultsIn(const std::string& folder) const {
    return Json::parse(slurp(folder_ / folder / "atlas_bench.json"), nullptr, false);
  }
};

TEST_F(AtlasBench, RecordsLoadsAndReports) {
  const Ran recorded =
      run(fmt::format("atlas-bench '{}' --context osmesa --size 320x180 --frames 24 --atlas-mpix 1 "
                      "--record r.trs -o first",
                      atrium()));
  ASSERT_EQ(recorded.code, 0) << recorded.error;
  const Json first = resultsIn("first");
  ASSERT_TRUE(first.is_object());
  ASSERT_EQ(first["strategies"].size(), 5u);
  EXPECT_EQ(first["strategies"][0]["name"], "S0");
  ASSERT_EQ(first["scenes"].size(), 1u);
  const Json& scene = first["scenes"][0];
  EXPECT_EQ(scene["scene"], "atrium.glb");
  EXPECT_EQ(scene["size"], (Json{320, 180}));
  EXPECT_GT(scene["recorded_frame_ms"]["median"], 0.0);
  EXPECT_GT(scene["recorded_memory_ms"]["median"], 0.0);
  EXPECT_LT(scene["recorded_memory_ms"]["median"], scene["recorded_frame_ms"]["median"]);
  Json runs = scene["strategies"];
  runs.push_back(scene["cpu_quadtree"]);
  for (const Json& entry : runs) {
    SCOPED_TRACE(entry["name"]);
    const Json& series = entry["series"];
    ASSERT_EQ(series["live"].size(), 24u);
    for (std::size_t f = 0; f < 24; ++f) {
      double texels = 0.0;
      for (const char* part : {"live", "end", "stack", "inaccessible", "free"})
        texels += series[part][f].get<double>();
      ASSERT_EQ(texels, 1048576.0) << "frame " << f;
    }
    EXPECT_GT(series["blocks_made"][0], 0);
    EXPECT_GT(series["live"][23], 0);
    EXPECT_GT(entry["live_share"], 0.0);
    EXPECT_EQ(entry["reduced_requests"], 0) << "memory is too small for what is tested here";
    EXPECT_EQ(entry["kept_place"], 1.0) << "a patch that stays keeps its place";
    EXPECT_GT(entry["ms_per_frame"]["median"], 0.0);
  }
  EXPECT_NE(slurp(folder_ / "first" / "atlas_bench.html").find("atrium.glb"), std::string::npos);

  // The same requests again, without the scene: what does not depend on the order of threads is the same.
  const Ran loaded =
      run("atlas-bench --load r.trs --context osmesa --atlas-mpix 1 --strategies S0 -o second");
  ASSERT_EQ(loaded.code, 0) << loaded.error;
  const Json second = resultsIn("second");
  ASSERT_EQ(second["strategies"].size(), 1u);
  Json a = scene["cpu_quadtree"]["series"];
  Json b = second["scenes"][0]["cpu_quadtree"]["series"];
  a.erase("ms");
  b.erase("ms");
  EXPECT_EQ(a, b);
}

TEST_F(AtlasBench, RefusesWithOneLine) {
  expectRefused("atlas-bench -o x", "no scene");
  expectRefused(fmt::format("atlas-bench '{}'", atrium()), "--output");
  expectRefused("atlas-bench --load nothing.trs -o x", "nothing.trs");
  expectRefused(fmt::format("atlas-bench '{}' --load nothing.trs -o x", atrium()), "nothing.trs");
  expectRefused(fmt::format("atlas-bench --load '{}' -o x", atrium()), "not a request stream");
  expectRefused(fmt::format("atlas-bench '{}' -o x --strategies S0,S9", atrium()), "S9");
  expectRefused(fmt::format("atlas-bench '{}' -o x --path nowhere.json", atrium()), "nowhere.json");
  expectRefused(fmt::format("atlas-bench '{}' -o x --frames 1", atrium()), "1 frames");
}

}  // namespace
}  // namespace tessera
