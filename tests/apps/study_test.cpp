// tessera stream-study from a scene to its page.
#include <nlohmann/json.hpp>

#include "tests/apps/cli.hpp"

namespace tessera {
namespace {

using test::Cli;
using test::Ran;
using test::slurp;
using Json = nlohmann::json;

class StudyCli : public Cli {};

double mssimOf(const Json& method, const char* figure, std::size_t i) { return method[figure][i]["mssim"]; }

TEST_F(StudyCli, MeasuresEveryMethod) {
  const Ran ran = run(
      fmt::format("stream-study '{}' --context osmesa --size 192x108 --samples 4 --seconds 0.2 --start 5.4 "
                  "--latencies-ms 0,100 --server-rates 30 --bitrates-mbit 1,10 --mbit 10 --atlas-mpix 1 "
                  "--no-loopback -o study",
                  atrium()));
  ASSERT_EQ(ran.code, 0) << ran.error;
  const Json json = Json::parse(slurp(folder_ / "study" / "study.json"), nullptr, false);
  ASSERT_TRUE(json.is_object());
  const Json& scene = json["scenes"][0];
  EXPECT_EQ(scene["size"], (Json{192, 108}));
  EXPECT_EQ(scene["samples"], 4);
  ASSERT_EQ(scene["methods"].size(), 5u);
  for (const Json& method : scene["methods"]) {
    SCOPED_TRACE(method["name"]);
    EXPECT_EQ(method["by_latency"].size(), 2u);
    EXPECT_EQ(method["by_server_rate"].size(), 1u);
    EXPECT_EQ(method["by_bitrate"].size(), 2u);
    EXPECT_EQ(method["by_bitrate"][1], method["by_latency"][0]) << "one stream, measured once";
    EXPECT_LE(method["by_latency"][0]["video_mbit_s"], 12.0);
    const double now = mssimOf(method, "by_latency", 0);
    const double late = mssimOf(method, "by_latency", 1);
    if (method["atlas"]) {
      EXPECT_GT(now, 0.8);
      EXPECT_GT(late, now - 0.02);
      EXPECT_LT(method["by_latency"][1]["uncovered_pixels"], 50.0);
      EXPECT_GT(method["by_latency"][1]["meta_mbit_s"], 0.0);
    }
    if (method["name"] == "time warp") {
      EXPECT_GT(now, 0.8);
      EXPECT_LT(late, now - 0.05) << "it knows nothing of depth";
    }
  }
  EXPECT_NE(ran.out.find("rect, 1 Mpix"), std::string::npos) << ran.out;
  const std::string page = slurp(folder_ / "study" / "index.html");
  std::size_t videos = 0;
  for (std::size_t at = 0; (at = page.find("src=\"data:video/mp4;base64,", at)) != std::string::npos; ++at)
    ++videos;
  EXPECT_EQ(videos, 6u) << "the truth's and one a method";
}

TEST_F(StudyCli, RefusesWithOneLine) {
  const std::string study = fmt::format("stream-study '{}' --context osmesa -o out ", atrium());
  expectRefused("stream-study", "scenes");
  expectRefused("stream-study nothing.glb --context osmesa -o out", "nothing.glb");
  expectRefused(fmt::format("stream-study '{}' --context osmesa", atrium()), "--output");
  expectRefused(study + "--size 641x360", "--size 641x360");
  expectRefused(study + "--latencies-ms 50,0", "--latencies-ms");
  expectRefused(study + "--latencies-ms 0,nan", "nan");
  expectRefused(study + "--server-rates 0", "--server-rates");
  expectRefused(study + "--bitrates-mbit 5,5", "5 after 5");
  expectRefused(study + "--atlas-mpix 65", "--atlas-mpix");
  expectRefused(study + "--methods rect,guess", "guess");
  expectRefused(study + "--warp-pose later", "later");
  expectRefused(study + "--samples 200", "--samples 200");
  expectRefused(study + "--path nowhere.json", "nowhere.json");
  expectRefused(study + "--seconds 60 --size 64x36", "shorter than");
  expectRefused(study + "--start 9.9 --size 64x36", "--start 9.9");
  std::ofstream(folder_ / "not.glb") << "not a scene";
  expectRefused("stream-study not.glb --context osmesa -o out", "not.glb");
}

}  // namespace
}  // namespace tessera
