// The program as a user runs it: exit codes, one clear line for bad input, whole files or none.
#include "tests/apps/cli.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/image/image.hpp"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using test::Cli;
using test::Ran;
using test::slurp;

TEST_F(Cli, HelpIsThereForEach) {
  EXPECT_EQ(run("--help").code, 0);
  for (const char* command : {"render", "info", "compare", "atlas-bench", "stability"}) {
    const Ran ran = run(std::string(command) + " --help");
    EXPECT_EQ(ran.code, 0);
    EXPECT_NE(ran.out.find("--context"), std::string::npos) << command;
  }
}

TEST_F(Cli, StabilityIsAListOfCases) {
  const Ran ran = run("stability --json --only metrics/ --only levels/pressure");
  ASSERT_EQ(ran.code, 0) << ran.error << ran.out;
  const auto json = nlohmann::json::parse(ran.out);
  ASSERT_GE(json["cases"].size(), 8U);
  for (const auto& entry : json["cases"]) {
    for (const char* field : {"name", "why", "unit"})
      EXPECT_FALSE(entry[field].get<std::string>().empty()) << field;
    EXPECT_TRUE(entry["passed"].get<bool>()) << entry;
    EXPECT_TRUE(entry["worst"].is_number() && entry["bound"].is_number()) << entry;
  }
  const Ran list = run("stability --list");
  EXPECT_EQ(list.code, 0);
  EXPECT_GE(std::count(list.out.begin(), list.out.end(), '\n'), 60);
  expectRefused("stability --only nothing-of-that-name", "nothing-of-that-name");
  expectRefused("stability --context vulkan", "vulkan");
}

TEST_F(Cli, BadArgumentsAreNamed) {
  expectRefused("", "subcommand");
  expectRefused("paint x", "subcommand");
  expectRefused("render", "scene");
  expectRefused(fmt::format("render '{}' -o a.png --size 12", atrium()), "--size 12");
  expectRefused(fmt::format("render '{}' -o a.png --size 0x5", atrium()), "--size 0x5");
  expectRefused(fmt::format("render '{}' -o a.png --method magic", atrium()), "magic");
  expectRefused(fmt::format("render '{}' -o a.png --camera nobody", atrium()), "nobody");
  expectRefused(fmt::format("render '{}' -o a.png --eye 1,2,3", atrium()), "--target");
  expectRefused(fmt::format("render '{}' -o a.png --eye 1,2,3 --target 1,2,3", atrium()), "same point");
  expectRefused(fmt::format("render '{}' -o a.png --fov-y 200", atrium()), "200");
  expectRefused(fmt::format("render '{}' -o a.png --path nowhere.json", atrium()), "nowhere.json");
  const std::string compare = fmt::format("compare '{}' -o r ", atrium());
  // Ranges alone let NaN pass.
  for (const char* number :
       {"--atlas-mpix nan", "--bias nan", "--bias-floor nan", "--high-water nan", "--hysteresis nan",
        "--split-edges nan", "--fps nan", "--fov-y nan", "--eye-distance nan", "--eye-distance=-nan"})
    expectRefused(compare + number, "nan: not a finite number");
  expectRefused(compare + "--eye 1,nan,2 --target 0,0,0", "--eye nan: not a finite number");
  expectRefused(compare + "--eye 1,2,3 --target 0,inf,0", "--target inf: not a finite number");
  expectRefused(compare + "--fps 1e999", "fps");
  for (const auto& [method, named] : {std::pair<std::string, std::string>{"rect:blur=2", "blur=2"},
                                      {"rect:bias=17", "bias=17"},
                                      {"rect:bias=", "bias="},
                                      {"rect:bias=1x", "1x"},
                                      {"rect:mpix=0", "mpix=0"},
                                      {"rect:mpix=nan", "mpix=nan"},
                                      {"rect:floor=1", "floor=1"},
                                      {"rect:texbias=1.5", "texbias=1.5"},
                                      {"rect:", "setting ''"},
                                      {"rect:lens=2", "lens=2"},
                                      {"rect-stereo:lens+foveated", "foveated"},
                                      {"rect:lens++foveate", "setting ''"},
                                      {"forward:lens", "forward takes no settings"},
                                      {"warp-stereo:mpix=4", "warp-stereo takes no settings"},
                                      {"warp", "warp-stereo"}}) {
    expectRefused(compare + "--methods " + method, "--methods " + method);
    expectRefused(compare + "--methods " + method, named);
  }
  expectRefused(compare + "--size 161x90 --methods forward-lanczos", "161x90");
  expectRefused(compare + "--figures 4.2", "4.2");
  expectRefused(compare + "--figures 4.1 --methods rect", "--methods");
  expectRefused(compare + "--metrics ssim", "ssim");
  expectRefused(compare + "--eye-distance -1", "eye-distance");
  EXPECT_FALSE(fs::exists(folder_ / "r" / "report.json"));
  expectRefused(fmt::format("compare '{}' -o r --atlas-mpix 0", atrium()), "atlas-mpix");
  EXPECT_FALSE(fs::exists(folder_ / "a.png"));
}

TEST_F(Cli, BadFilesAreRefusedAndNothingIsWritten) {
  expectRefused("render missing.glb -o a.png", "missing.glb");
  std::ofstream(folder_ / "text.glb") << "hello";
  expectRefused("render text.glb -o a.png", "text.glb");
  expectRefused("compare text.glb -o report", "text.glb");
  std::ofstream(folder_ / "stage.json") << R"({"lights": [{"type": "laser"}]})";
  expectRefused(fmt::format("render '{}' -o a.png --stage stage.json", atrium()), "stage.json");
  EXPECT_FALSE(fs::exists(folder_ / "a.png"));
  EXPECT_FALSE(fs::exists(folder_ / "report" / "report.json"));
  const Ran ran = run(fmt::format("render '{}' -o none/such/a.png --size 16x16", atrium()));
  EXPECT_EQ(ran.code, 2);
  EXPECT_NE(ran.error.find("none/such/a.png"), std::string::npos) << ran.error;
}

TEST_F(Cli, RendersByEveryMethodAndView) {
  const std::string scene = fmt::format("'{}' --size 160x90 --context osmesa", atrium());
  for (const char* method : {"forward", "forward-prepass", "rect", "rect-deferred", "texel"}) {
    const Ran ran =
        run(fmt::format("render {} -o {}.png --method {} --stats {}.json", scene, method, method, method));
    ASSERT_EQ(ran.code, 0) << ran.error;
    const auto image = readImage(folder_ / (std::string(method) + ".png"));
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->width, 160);
    const auto stats = nlohmann::json::parse(slurp(folder_ / (std::string(method) + ".json")));
    EXPECT_EQ(stats["schema"], 1);
    // Texel Shading has no fragments: it shades in compute.
    const char* shaded = std::string(method) == "texel" ? "samples_allocated" : "fragments";
    EXPECT_GT(stats["frames"][0][shaded].get<std::uint64_t>(), 0u);
    EXPECT_FALSE(stats["frames"][0]["passes"].empty());
  }
  for (const char* view : {"ids", "patches", "levels", "blocks", "texel-density", "atlas"}) {
    const Ran ran = run(fmt::format("render {} -o {}.png --view {} --atlas-mpix 1", scene, view, view));
    ASSERT_EQ(ran.code, 0) << ran.error;
    EXPECT_TRUE(readImage(folder_ / (std::string(view) + ".png")));
  }
}

TEST_F(Cli, FramesAlongAPathAreNumbered) {
  std::ofstream(folder_ / "path.json")
      << R"({"keyframes": [{"t": 0, "eye": [0, 2, 3], "target": [0, 2, -3], "fov_y": 60}, {"t": 1, "eye": [1, 2, 3], "target": [0, 2, -3], "fov_y": 60}]})";
  const Ran ran =
      run(fmt::format("render '{}' -o f.png --size 64x36 --path path.json --frames 3 --fps 2", atrium()));
  ASSERT_EQ(ran.code, 0) << ran.error;
  for (const char* name : {"f.0000.png", "f.0001.png", "f.0002.png"})
    EXPECT_TRUE(fs::exists(folder_ / name)) << name;
}

TEST_F(Cli, FoveationAndLensAreOptionsOfRender) {
  const std::string scene = fmt::format("'{}' --size 320x180 --context osmesa", atrium());
  const auto samples = [&](const std::string& name, const std::string& options) {
    const Ran ran = run(fmt::format("render {} -o {}.png --stats {}.json {}", scene, name, name, options));
    EXPECT_EQ(ran.code, 0) << ran.error;
    const auto stats = nlohmann::json::parse(slurp(folder_ / (name + ".json")));
    return stats["frames"].back()["samples_allocated"].get<double>();
  };
  const double plain = samples("plain", "");
  const double centre = samples("centre", "--foveate");
  EXPECT_LT(centre, 0.9 * plain);
  EXPECT_NE(samples("corner", "--foveate 0.05,0.95"), centre);
  std::ofstream(folder_ / "gaze.json")
      << R"([{"time": 0, "x": 0.05, "y": 0.95}, {"time": 1, "x": 0.5, "y": 0.5}])";
  EXPECT_EQ(samples("gaze", "--gaze gaze.json"), samples("corner", "--foveate 0.05,0.95"));
  EXPECT_LT(samples("lens", "--lens"), plain);
  EXPECT_LT(samples("both", "--lens 0.5,0.5 --foveate"), centre);
  EXPECT_NE(slurp(folder_ / "lens.png"), slurp(folder_ / "plain.png"));
  const std::string out = fmt::format("render '{}' -o a.png ", atrium());
  expectRefused(out + "--foveate 0.5", "--foveate 0.5");
  expectRefused(out + "--foveate nan,0", "nan");
  expectRefused(out + "--foveate 1e300,0.5", "1e+300");
  expectRefused(out + "--foveate 0.5,-10.5", "-10.5");
  expectRefused(out + "--lens 1x2", "--lens 1");
  expectRefused(out + "--lens=-1,0", "k1 -1");
  expectRefused(out + "--gaze none.json", "none.json");
  expectRefused(out + "--gaze gaze.json --foveate 0.1,0.1", "--gaze");
  EXPECT_FALSE(fs::exists(folder_ / "a.png"));
}

TEST_F(Cli, InfoSaysWhatTheSceneCallsFor) {
  const Ran ran = run(fmt::format("info '{}' --json --context osmesa", atrium()));
  ASSERT_EQ(ran.code, 0) << ran.error;
  const auto json = nlohmann::json::parse(ran.out);
  EXPECT_GT(json["counts"]["triangles"].get<int>(), 60000);
  EXPECT_GT(json["counts"]["instances"].get<int>(), 150);
  std::vector<std::string> effects;
  for (const auto& effect : json["effects"]) {
    effects.push_back(effect["name"]);
    EXPECT_FALSE(effect["reason"].get<std::string>().empty());
  }
  for (const char* wanted :
       {"alpha-mask", "alpha-blend", "normal-map", "punctual-lights", "shadows", "animation", "unlit"})
    EXPECT_NE(std::find(effects.begin(), effects.end(), wanted), effects.end()) << wanted;
  EXPECT_NE(std::find(json["passes"].begin(), json["passes"].end(), "shadow"), json["passes"].end());
  EXPECT_GT(json["permutations"].size(), 3u);
}

TEST_F(Cli, CompareWritesTheReport) {
  const Ran ran =
      run(fmt::format("compare '{}' -o report --size 160x90 --frames 2 --methods rect,forward,rect:bias=-2 "
                      "--atlas-mpix 2 --context osmesa --atlas-format rgba16f",
                      atrium()));
  ASSERT_EQ(ran.code, 0) << ran.error;
  const auto json = nlohmann::json::parse(slurp(folder_ / "report" / "report.json"));
  const auto& scene = json["scenes"][0];
  EXPECT_EQ(scene["frames"], 2);
  EXPECT_EQ(scene["size"], (nlohmann::json{160, 90}));
  ASSERT_EQ(scene["methods"].size(), 3u);
  EXPECT_EQ(scene["methods"][0]["name"], "forward");
  EXPECT_EQ(scene["methods"][0]["mssim"], 1.0);
  for (const std::size_t i : {std::size_t{1}, std::size_t{2}}) {
    const auto& method = scene["methods"][i];
    EXPECT_GT(method["mssim"].get<double>(), 0.85);
    EXPECT_EQ(method["holes"], 0.0);
    EXPECT_EQ(method["non_finite_texels"], 0.0);
    EXPECT_GT(method["samples_shaded"].get<double>(), 1000.0);
    EXPECT_GT(method["ns_per_sample"].get<double>(), 0.0);
  }
  EXPECT_GT(scene["methods"][2]["samples_shaded"].get<double>(),
            2.5 * scene["methods"][1]["samples_shaded"].get<double>());
  const std::string page = slurp(folder_ / "report" / "report.html");
  EXPECT_NE(page.find("atrium.glb"), std::string::npos);
}

TEST_F(Cli, CompareMeasuresStereoLensAndFoveation) {
  const Ran ran = run(fmt::format(
      "compare '{}' -o report --size 320x180 --frames 2 --context osmesa --methods "
      "rect-stereo:bias=off,rect-stereo:bias=off+lens,warp-stereo,forward-lanczos,rect:foveate+bias=off,"
      "rect:bias=off+mpix=2,rect:bias=off+mpix=2+texbias=0,rect:floor=-2+mpix=2 --metrics mssim",
      atrium()));
  ASSERT_EQ(ran.code, 0) << ran.error;
  const auto json = nlohmann::json::parse(slurp(folder_ / "report" / "report.json"));
  std::map<std::string, nlohmann::json> methods;
  std::vector<std::string> order;
  for (const auto& method : json["scenes"][0]["methods"]) {
    order.push_back(method["name"]);
    methods[order.back()] = method;
    EXPECT_TRUE(method["flip"].is_null());
    EXPECT_TRUE(method["psnr_db"].is_null());
    EXPECT_EQ(method["holes"], 0.0) << order.back();
  }
  // References come first, asked for or not.
  ASSERT_EQ(order.size(), 10u);
  EXPECT_EQ(order[0], "forward");
  EXPECT_EQ(order[1], "forward-stereo");
  const auto number = [&](const char* method, const char* field) {
    const auto& value = methods.at(method).at(field);
    EXPECT_TRUE(value.is_number()) << method << " " << field;
    return value.is_number() ? value.get<double>() : 0.0;
  };
  const double pixels = 320.0 * 180.0;
  EXPECT_EQ(number("forward-stereo", "mssim"), 1.0);
  EXPECT_EQ(number("forward-stereo", "views"), 2.0);
  EXPECT_EQ(methods["warp-stereo"]["reference"], "forward-stereo");
  EXPECT_EQ(methods["forward-lanczos"]["reference"], "forward");
  // Two eyes see about the same: twice the work, half of it for the one that is warped, a quarter of one
  // small.
  const double once = number("forward", "samples_passed");
  EXPECT_NEAR(number("forward-stereo", "samples_passed"), 2.0 * once, 0.1 * once);
  EXPECT_NEAR(number("warp-stereo", "shaded_against_reference"), 0.5, 0.03);
  EXPECT_NEAR(number("forward-lanczos", "shaded_against_reference"), 0.25, 0.03);
  EXPECT_DOUBLE_EQ(number("warp-stereo", "shaded_per_target_pixel"),
                   number("warp-stereo", "samples_passed") / pixels);
  EXPECT_DOUBLE_EQ(number("rect-stereo:bias=off", "shaded_per_target_pixel"),
                   number("rect-stereo:bias=off", "samples_allocated") / pixels);
  EXPECT_DOUBLE_EQ(number("rect-stereo:bias=off", "shaded_per_picture_pixel"),
                   number("rect-stereo:bias=off", "samples_allocated") / (2.0 * pixels));
  // Both eyes share what they see.
  EXPECT_LT(number("rect-stereo:bias=off", "samples_shaded"),
            1.3 * number("rect:bias=off+mpix=2", "samples_shaded"));
  EXPECT_GT(number("rect-stereo:bias=off", "mssim"), 0.85);
  EXPECT_LT(number("rect-stereo:bias=off+lens", "samples_shaded"),
            0.95 * number("rect-stereo:bias=off", "samples_shaded"));
  EXPECT_GT(number("rect-stereo:bias=off+lens", "mssim"), 0.85);
  // The warped eye is the right one; the left is forward's own.
  const auto& eyes = methods["warp-stereo"]["mssim_views"];
  ASSERT_EQ(eyes.size(), 2u);
  EXPECT_EQ(eyes[0], 1.0);
  EXPECT_LT(eyes[1].get<double>(), 1.0);
  EXPECT_GT(eyes[1].get<double>(), 0.8);
  EXPECT_DOUBLE_EQ(number("warp-stereo", "mssim"), 0.5 * (1.0 + eyes[1].get<double>()));
  EXPECT_GT(number("forward-lanczos", "mssim"), 0.5);
  EXPECT_EQ(number("rect:bias=off+mpix=2+texbias=0", "samples_shaded"),
            number("rect:bias=off+mpix=2", "samples_shaded"));
  EXPECT_LT(number("rect:bias=off+mpix=2+texbias=0", "mssim"), number("rect:bias=off+mpix=2", "mssim"));
  EXPECT_LT(number("rect:foveate+bias=off", "samples_shaded"),
            number("rect:bias=off+mpix=2", "samples_shaded"));
  EXPECT_GT(number("rect:foveate+bias=off", "mssim_acuity"), number("rect:foveate+bias=off", "mssim"));
  EXPECT_TRUE(methods["rect:bias=off+mpix=2"]["mssim_acuity"].is_null());
  // Room to spare, and a floor below 0: up to four times the texels, and better for it.
  EXPECT_GT(number("rect:floor=-2+mpix=2", "samples_shaded"),
            2.5 * number("rect:bias=off+mpix=2", "samples_shaded"));
  EXPECT_GT(number("rect:floor=-2+mpix=2", "mssim"), number("rect:bias=off+mpix=2", "mssim"));
}

TEST_F(Cli, CompareMakesFigures) {
  const Ran ran = run(fmt::format(
      "compare '{}' -o report --figures 4.6 --size 96x54 --frames 1 --warmup 0 --context osmesa", atrium()));
  ASSERT_EQ(ran.code, 0) << ran.error;
  const auto json = nlohmann::json::parse(slurp(folder_ / "report" / "report.json"));
  ASSERT_EQ(json["figures"].size(), 1u);
  EXPECT_EQ(json["figures"][0]["figure"], "4.6");
  const auto& bars = json["figures"][0]["scenes"][0]["bars"];
  ASSERT_EQ(bars.size(), 3u);
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const auto& method = json["scenes"][0]["methods"][i + 1];
    EXPECT_EQ(bars[i]["method"], method["name"]);
    EXPECT_EQ(bars[i]["shaded_per_target_pixel"], method["shaded_per_target_pixel"]);
    EXPECT_EQ(bars[i]["mssim_acuity"], method["mssim_acuity"]);
    EXPECT_GT(bars[i]["mssim_acuity"].get<double>(), 0.5);
    EXPECT_TRUE(method["flip"].is_null()) << "figures take MSSIM alone";
  }
  EXPECT_NE(slurp(folder_ / "report" / "report.html").find("Figure 4.6"), std::string::npos);
}

}  // namespace
}  // namespace tessera
