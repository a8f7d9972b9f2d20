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

  // Sizes that cannot be are passed over: 2^25 texels in superblocks of 16 x 16 are too many of them, and no
  // block is as small as 4 and at most 2.
  const Ran swept =
      run("atlas-bench --load r.trs --context osmesa --atlas-mpix 32 --strategies S3,S0 --largest-block 2 "
          "--superblock 128 --sweep -o 'third one'");
  ASSERT_EQ(swept.code, 0) << swept.error;
  const Json third = resultsIn("third one");
  std::size_t ran = 0;
  std::size_t skipped = 0;
  for (const Json& variant : third["scenes"][0]["sweep"]) {
    const auto superblock = variant["superblock"].get<int>();
    const auto smallest = variant["smallest_block"].get<int>();
    EXPECT_EQ(!variant["skipped"].is_null(), superblock == 16 || smallest > 2) << variant;
    EXPECT_EQ(variant.contains("live_share"), variant["skipped"].is_null()) << variant;
    ++(variant["skipped"].is_null() ? ran : skipped);
  }
  EXPECT_GT(ran, 10u);
  EXPECT_EQ(skipped, 2u);
  EXPECT_NE(swept.out.find("16/1-2/1024   skipped: atlas memory: 131072 superblocks"), std::string::npos)
      << swept.out;
  EXPECT_NE(swept.out.find("128/4-2/1024  skipped: atlas memory: smallestLog2 is 2"), std::string::npos)
      << swept.out;
  EXPECT_EQ(third["context"]["command"],
            "tessera atlas-bench --load r.trs --context osmesa --atlas-mpix 32 --strategies S3,S0 "
            "--largest-block 2 --superblock 128 --sweep -o 'third one'");
}

TEST_F(AtlasBench, StandsStillWhenACameraIsChosen) {
  const Ran ran = run(
      fmt::format("atlas-bench '{}' --context osmesa --size 160x90 --frames 3 --atlas-mpix 1 --strategies S0 "
                  "--eye 0,2,3 --target 0,2,-3 -o still",
                  atrium()));
  ASSERT_EQ(ran.code, 0) << ran.error;
  const Json still = resultsIn("still");
  const Json& scene = still["scenes"][0];
  EXPECT_EQ(scene["fps"], 30.0);
  const Json live = scene["cpu_quadtree"]["series"]["live"];
  ASSERT_EQ(live.size(), 3u);
  EXPECT_EQ(live[1], live[2]);
}

TEST_F(AtlasBench, SaysAtOnceWhatCannotBeRecorded) {
  namespace fs = std::filesystem;
  for (const char* folder : {"a", "b"}) {
    fs::create_directories(folder_ / folder);
    fs::copy_file(atrium(), folder_ / folder / "atrium.glb");
  }
  fs::copy_file(atrium(), folder_ / "other.glb");
  std::ofstream(folder_ / "precious") << "stays";
  fs::create_directories(folder_ / "taken" / "other.trs");
  const std::string bench = "atlas-bench --context osmesa -o x ";
  expectRefused(bench + "a/atrium.glb other.glb --record precious", "precious: is a file, 2 scenes");
  expectRefused(bench + "a/atrium.glb b/atrium.glb --record to",
                "a/atrium.glb and b/atrium.glb would both be saved as to/atrium.trs");
  expectRefused(bench + "other.glb --record precious/below.trs", "--record precious");
  expectRefused(bench + "other.glb --record ./other.glb", "./other.glb is one of the scenes");
  expectRefused(bench + "other.glb --record taken", "taken/other.trs: is a folder");
  // None of these has begun to load a scene.
  EXPECT_EQ(slurp(folder_ / "err.txt").find("geometry"), std::string::npos);
  EXPECT_EQ(slurp(folder_ / "precious"), "stays");
  EXPECT_FALSE(fs::exists(folder_ / "x"));

  const Ran recorded =
      run("atlas-bench other.glb --context osmesa --size 64x36 --frames 2 --path p.json "
          "--strategies S0 --record to/r.trs -o x");
  EXPECT_EQ(recorded.code, 2);
  EXPECT_NE(recorded.error.find("p.json"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "to" / "r.trs"));
  EXPECT_FALSE(fs::exists(folder_ / "to" / "r.trs.partial"));
  std::ofstream(folder_ / "p.json")
      << R"({"keyframes": [{"t": 0, "eye": [0, 2, 3], "target": [0, 2, -3], "fov_y": 60},
                           {"t": 4, "eye": [1, 2, 3], "target": [0, 2, -3], "fov_y": 60}]})";
  const Ran again =
      run("atlas-bench other.glb --context osmesa --size 64x36 --frames 3 --path p.json "
          "--strategies S0 --record to/r.trs -o x");
  ASSERT_EQ(again.code, 0) << again.error;
  EXPECT_EQ(resultsIn("x")["scenes"][0]["fps"], 0.5) << "three frames show all of four seconds";
  const std::string stream = slurp(folder_ / "to" / "r.trs");
  EXPECT_FALSE(stream.empty());
  expectRefused("atlas-bench --load to/r.trs --record q.trs -o x", "nothing to record");
  expectRefused("atlas-bench other.glb --load to/r.trs --record to/../to/r.trs -o x",
                "one of the files to --load");
  EXPECT_EQ(slurp(folder_ / "to" / "r.trs"), stream);
}

TEST_F(AtlasBench, RefusesWithOneLine) {
  expectRefused("atlas-bench -o x", "no scene");
  expectRefused(fmt::format("atlas-bench '{}'", atrium()), "--output");
  expectRefused("atlas-bench --load nothing.trs -o x", "nothing.trs");
  expectRefused(fmt::format("atlas-bench '{}' --load nothing.trs -o x", atrium()), "nothing.trs");
  expectRefused(fmt::format("atlas-bench --load '{}' -o x", atrium()), "not a request stream");
  expectRefused(fmt::format("atlas-bench '{}' -o x --strategies S0,S9", atrium()), "S9");
  expectRefused(fmt::format("atlas-bench '{}' -o x --path nowhere.json", atrium()), "nowhere.json");
  expectRefused(fmt::format("atlas-bench '{}' -o x --frames 1", atrium()), "--frames 1");
}

}  // namespace
}  // namespace tessera
