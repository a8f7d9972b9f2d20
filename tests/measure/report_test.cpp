#include "apps/tessera/report/report.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/image/image.hpp"
#include "tests/measure/report_fixture.hpp"

namespace tessera {
namespace {

using Json = nlohmann::json;

std::string readText(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The page without the chart library, which is not ours to judge.
std::string ownPart(const std::string& html) {
  const std::string chart = readText(TESSERA_CHART_JS);
  const std::size_t at = html.find(chart);
  EXPECT_GT(chart.size(), 100000U);
  EXPECT_NE(at, std::string::npos) << "the chart library is not in the page";
  return std::string(html).replace(at, chart.size(), "");
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// The cells of the row with this label in the table of scene `scene`, tags removed.
std::vector<std::string> rowOf(const std::string& html, std::size_t scene, const std::string& label) {
  const std::size_t section = html.find(fmt::format("id=\"scene-{}\"", scene));
  const std::size_t start = html.find("<table", section);
  const std::string table = html.substr(start, html.find("</table>", start) - start);
  const std::size_t row = table.find("<th scope=\"row\">" + label + " <small>");
  if (row == std::string::npos) return {};
  const std::string line = table.substr(row, table.find("</tr>", row) - row);
  std::vector<std::string> cells;
  const std::regex cell("<td>(.*?)</td>");
  for (std::sregex_iterator it(line.begin(), line.end(), cell), end; it != end; ++it)
    cells.push_back(std::regex_replace((*it)[1].str(), std::regex("<[^>]*>"), ""));
  return cells;
}

using Cells = std::vector<std::string>;

std::vector<std::uint8_t> fromBase64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> out;
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    if (c == '=') break;
    const std::size_t digit = digits.find(c);
    EXPECT_NE(digit, std::string::npos);
    bits = (bits << 6U | static_cast<std::uint32_t>(digit)) & 0xFFFFFFU;
    held += 6;
    if (held >= 8) out.push_back(static_cast<std::uint8_t>(bits >> static_cast<std::uint32_t>(held -= 8)));
  }
  return out;
}

Json dataOf(const std::string& html) {
  const std::string open = "<script type=\"application/json\" id=\"data\">";
  const std::size_t start = html.find(open) + open.size();
  return Json::parse(html.substr(start, html.find("</script>", start) - start));
}

/// One scene with one method, "forward", and nothing measured.
Report bareReport(const std::string& file) {
  Report report;
  report.scenes.emplace_back().file = file;
  report.scenes[0].methods.emplace_back().name = "forward";
  return report;
}

// ---- report.json ----

void expectTiming(const Json& json, const Statistics& expected, const std::string& where) {
  ASSERT_TRUE(json.is_object()) << where;
  const std::pair<const char*, double> fields[] = {
      {"median", expected.median}, {"p95", expected.p95}, {"min", expected.min}};
  for (const auto& [name, value] : fields) {
    ASSERT_TRUE(json.contains(name)) << where << "." << name;
    if (expected.count == 0)
      EXPECT_TRUE(json[name].is_null()) << where << "." << name;
    else
      EXPECT_EQ(json[name].get<double>(), value) << where << "." << name;
  }
}

TEST(ReportJson, EveryFieldOfTheSchema) {
  const Report report = fixtureReport();
  const Json json = Json::parse(toJson(report));
  EXPECT_EQ(json["schema"], 1);
  const std::pair<const char*, std::string> context[] = {{"backend", report.context.backend},
                                                         {"renderer", report.context.renderer},
                                                         {"gl", report.context.gl},
                                                         {"glsl", report.context.glsl},
                                                         {"timer", report.context.timer}};
  for (const auto& [name, value] : context) EXPECT_EQ(json["context"][name], value) << name;
  ASSERT_EQ(json["scenes"].size(), report.scenes.size());
  for (std::size_t s = 0; s < report.scenes.size(); ++s) {
    const ReportScene& scene = report.scenes[s];
    const Json& js = json["scenes"][s];
    EXPECT_EQ(js["file"], scene.file);
    EXPECT_EQ(js["triangles"], scene.triangles);
    EXPECT_EQ(js["instances"], scene.instances);
    EXPECT_EQ(js["materials"], scene.materials);
    EXPECT_EQ(js["lights"], scene.lights);
    EXPECT_EQ(js["size"], (Json{scene.width, scene.height}));
    EXPECT_EQ(js["frames"], scene.frames);
    ASSERT_EQ(js["methods"].size(), scene.methods.size());
    for (std::size_t i = 0; i < scene.methods.size(); ++i) {
      const ReportMethod& m = scene.methods[i];
      const Json& jm = js["methods"][i];
      EXPECT_EQ(jm["name"], m.name);
      EXPECT_EQ(jm["reference"], m.reference);
      const std::pair<const char*, double> numbers[] = {{"mssim", m.mssim},
                                                        {"dssim", (1 - m.mssim) / 2},
                                                        {"psnr_db", m.psnrDb},
                                                        {"flip", m.flip},
                                                        {"views", m.views},
                                                        {"mssim_acuity", m.mssimAcuity},
                                                        {"invocations", m.invocations},
                                                        {"samples_passed", m.samplesPassed},
                                                        {"samples_shaded", m.samplesShaded},
                                                        {"samples_allocated", m.samplesAllocated},
                                                        {"atlas_texels_used", m.atlasTexelsUsed},
                                                        {"visible_patches", m.visiblePatches},
                                                        {"visible_triangles", m.visibleTriangles},
                                                        {"out_of_memory", m.outOfMemory},
                                                        {"resets", m.resets},
                                                        {"ns_per_sample", m.nsPerSample},
                                                        {"covered_pixels", m.coveredPixels},
                                                        {"holes", m.holes},
                                                        {"non_finite_texels", m.nonFiniteTexels}};
      for (const auto& [name, value] : numbers) {
        ASSERT_TRUE(jm.contains(name)) << name;
        if (std::isfinite(value))
          EXPECT_EQ(jm[name].get<double>(), value) << m.name << "." << name;
        else
          EXPECT_TRUE(jm[name].is_null()) << m.name << "." << name;
      }
      expectTiming(jm["frame_ms"], m.frameMs, "frame_ms");
      expectTiming(jm["gather_ms"], m.gatherMs, "gather_ms");
      expectTiming(jm["display_ms"], m.displayMs, "display_ms");
      ASSERT_EQ(jm["passes"].size(), m.passes.size());
      for (std::size_t p = 0; p < m.passes.size(); ++p) {
        EXPECT_EQ(jm["passes"][p]["name"], m.passes[p].name);
        expectTiming(jm["passes"][p]["ms"], m.passes[p].ms, m.passes[p].name);
      }
    }
  }
}

/// Scenes of 100 x 50 pixels: forward, forward-stereo and an atlas method of two pictures and of one.
Report workReport() {
  Report report;
  ReportScene scene;
  scene.file = "a.glb";
  scene.width = 100;
  scene.height = 50;
  const auto add = [&](const char* name, const char* reference, int views, double shaded, double passed) {
    ReportMethod m;
    m.name = name;
    m.reference = reference;
    m.views = views;
    m.samplesShaded = shaded;
    m.samplesPassed = passed;
    m.invocations = 3.0 * shaded;
    m.mssim = 0.5 + 1e-5 * shaded;
    scene.methods.push_back(m);
  };
  add("forward", "forward", 1, 9000, 8000);
  add("forward-stereo", "forward-stereo", 2, 19000, 16000);
  add("rect-stereo:lens", "forward-stereo", 2, 6000, kNotMeasured);
  add("rect:foveate", "forward", 1, 200, kNotMeasured);
  scene.methods.back().mssimAcuity = 0.987;
  scene.methods[2].mssimViews = {0.6, 0.52};
  report.scenes = {scene, scene};
  report.scenes[1].file = "b.glb";
  report.scenes[1].methods.pop_back();
  report.figures.push_back({"4.7",
                            "Stereo & <lens>",
                            "What it shows.",
                            {{"rect-stereo:lens", "Lens"}, {"rect:foveate", "Eye"}, {"none", "Nobody"}}});
  return report;
}

TEST(ReportWork, IsGivenAgainstPixelsAndForward) {
  const ReportScene scene = workReport().scenes[0];
  const ReportMethod& twice = scene.methods[1];
  const ReportMethod& stereo = scene.methods[2];
  const ReportMethod& foveated = scene.methods[3];
  EXPECT_EQ(shadedSamples(twice), 16000.0);
  EXPECT_EQ(shadedSamples(stereo), 6000.0);
  EXPECT_DOUBLE_EQ(shadedPerTargetPixel(scene, twice), 3.2);
  EXPECT_DOUBLE_EQ(shadedPerPicturePixel(scene, twice), 1.6);
  EXPECT_DOUBLE_EQ(shadedPerTargetPixel(scene, stereo), 1.2);
  EXPECT_DOUBLE_EQ(shadedPerPicturePixel(scene, stereo), 0.6);
  EXPECT_DOUBLE_EQ(shadedAgainstReference(scene, stereo), 0.375);
  EXPECT_DOUBLE_EQ(shadedAgainstReference(scene, twice), 1.0);
  EXPECT_DOUBLE_EQ(shadedAgainstReference(scene, foveated), 0.025);
  ReportMethod alone = stereo;
  alone.reference = "nobody";
  EXPECT_TRUE(std::isnan(shadedAgainstReference(scene, alone)));
  EXPECT_EQ(referenceOf(scene, alone), nullptr);
  EXPECT_EQ(mssimOfRightEye(stereo), 0.52);
  EXPECT_TRUE(std::isnan(mssimOfRightEye(foveated)));
}

TEST(ReportWork, PassesAreSharesOfTheFrame) {
  Report report = bareReport("a.glb");
  ReportMethod& m = report.scenes[0].methods[0];
  const auto over = [](const std::vector<double>& ms) { return summarize(ms); };
  m.frameMs = over({190.0, 200.0, 500.0});
  m.passes = {{"levels", over({3.0})}, {"memory", over({1.0, 5.0, 90.0})}};
  EXPECT_DOUBLE_EQ(passShare(m, "levels"), 0.015);
  EXPECT_DOUBLE_EQ(passShare(m, "memory"), 0.025);
  EXPECT_TRUE(std::isnan(passShare(m, "emit")));
  const Json json = Json::parse(toJson(report))["scenes"][0]["methods"][0];
  EXPECT_EQ(json["levels_share"], 0.015);
  EXPECT_EQ(json["memory_share"], 0.025);
  const std::string html = toHtml(report);
  EXPECT_EQ(rowOf(html, 0, "Level selection"), Cells{"1.50 %"});
  EXPECT_EQ(rowOf(html, 0, "Memory"), Cells{"2.50 %"});
}

TEST(ReportWork, FiguresHoldTheBarsThatAreThere) {
  const Report report = workReport();
  const Json json = Json::parse(toJson(report));
  ASSERT_EQ(json["figures"].size(), 1U);
  const Json& figure = json["figures"][0];
  EXPECT_EQ(figure["figure"], "4.7");
  ASSERT_EQ(figure["scenes"].size(), 2U);
  ASSERT_EQ(figure["scenes"][0]["bars"].size(), 2U);
  ASSERT_EQ(figure["scenes"][1]["bars"].size(), 1U);
  const Json& bar = figure["scenes"][0]["bars"][0];
  EXPECT_EQ(bar["method"], "rect-stereo:lens");
  EXPECT_EQ(bar["label"], "Lens");
  EXPECT_EQ(bar["shaded_per_target_pixel"], 1.2);
  EXPECT_EQ(bar["shaded_per_picture_pixel"], 0.6);
  EXPECT_EQ(bar["shaded_against_reference"], 0.375);
  EXPECT_EQ(bar["mssim"], 0.5 + 1e-5 * 6000);
  EXPECT_EQ(bar["mssim_right_eye"], 0.52);
  EXPECT_TRUE(bar["mssim_acuity"].is_null());
  EXPECT_EQ(figure["scenes"][0]["bars"][1]["mssim_acuity"], 0.987);

  const std::string html = toHtml(report);
  EXPECT_EQ(dataOf(html)["figures"][0], figure);
  EXPECT_EQ(count(html, "<h2>Figure 4.7: Stereo &amp; &lt;lens&gt;</h2>"), 1U);
  EXPECT_EQ(count(html,
                  "Lens <small>rect-stereo:lens</small></th><td>120.0 %</td><td>60.0 %</td><td>37.5 %</td>"
                  "<td>360.0 %</td><td>0.5600</td><td>0.5200</td><td>–</td>"),
            2U)
      << "in both scenes";
  EXPECT_EQ(count(html, "Eye <small>rect:foveate</small></th><td>4.0 %</td><td>4.0 %</td><td>2.5 %</td>"),
            1U);
  EXPECT_EQ(count(html, "Nobody"), 0U);
  EXPECT_EQ(
      count(html, "<th scope=\"col\">MSSIM, mean of both eyes</th><th scope=\"col\">of the right eye</th>"),
      1U);
  EXPECT_EQ(count(html, "<th scope=\"rowgroup\" colspan=\"8\">"), 2U);
}

TEST(ReportJson, NamesThatAreNotUtf8) {
  const Report report = bareReport("caf\xe9 \"1\".glb");
  const Json json = Json::parse(toJson(report));
  EXPECT_EQ(json["scenes"][0]["file"], "caf\xEF\xBF\xBD \"1\".glb");
  EXPECT_EQ(dataOf(toHtml(report))["scenes"][0]["file"], "caf\xEF\xBF\xBD \"1\".glb");
}

// ---- the page ----

TEST(ReportHtml, AsksNothingOfTheNetwork) {
  const std::string html = ownPart(toHtml(fixtureReport()));
  EXPECT_EQ(count(html, "http://"), 0U);
  EXPECT_EQ(count(html, "https://"), 0U);
  EXPECT_EQ(count(html, "=\"//"), 0U);
  EXPECT_EQ(count(html, "@import"), 0U);
  EXPECT_EQ(count(html, "{{"), 0U) << "a part of the template was left unfilled";
  // The browser is told to refuse whatever the page might ask for all the same.
  EXPECT_EQ(count(html, "default-src 'none'; img-src data:;"), 1U);
}

TEST(ReportHtml, TablesSayWhatTheStructSays) {
  Report report = fixtureReport();
  ReportMethod& forward = report.scenes[0].methods[0];
  ReportMethod& rect = report.scenes[0].methods[1];
  ReportMethod& third = report.scenes[0].methods[2];
  const auto timing = [](double median, double p95) {
    Statistics s;
    s.count = 3;
    s.median = median;
    s.p95 = p95;
    return s;
  };
  rect.mssim = 0.91237;
  rect.psnrDb = 27.456;
  rect.flip = 0.04567;
  rect.samplesShaded = 2345678.6;
  rect.samplesAllocated = 999;
  rect.coveredPixels = 1000000;
  rect.visiblePatches = 1000;
  rect.visibleTriangles = 12345;
  rect.atlasTexelsUsed = 4194304;
  rect.outOfMemory = 17;
  rect.resets = 3;
  rect.holes = 5;
  rect.nonFiniteTexels = 2;
  rect.frameMs = timing(123.4, 234.5);
  rect.gatherMs = timing(45.67, 56.78);
  rect.displayMs = timing(0.0123, 3.456);
  rect.nsPerSample = 98.76;
  forward.frameMs = timing(100, 101);
  forward.nsPerSample = 50;
  third.nsPerSample = kNotMeasured;
  const std::string html = toHtml(report);
  const auto second = [&](const char* label) {
    const Cells cells = rowOf(html, 0, label);
    return cells.size() == 3 ? cells[1] : fmt::format("{} cells", cells.size());
  };
  EXPECT_EQ(second("MSSIM"), "0.9124");
  EXPECT_EQ(second("DSSIM"), "0.0438");
  EXPECT_EQ(second("PSNR"), "27.46");
  EXPECT_EQ(second("FLIP"), "0.0457");
  EXPECT_EQ(second("Samples shaded"), "2,345,679");
  EXPECT_EQ(second("Samples allocated"), "999");
  EXPECT_EQ(second("Samples shaded per covered pixel"), "2.35");
  EXPECT_EQ(second("Covered pixels"), "1,000,000");
  EXPECT_EQ(second("Visible patches"), "1,000");
  EXPECT_EQ(second("Visible triangles"), "12,345");
  EXPECT_EQ(second("Texels used"), "4,194,304");
  EXPECT_EQ(second("Out of memory"), "17");
  EXPECT_EQ(second("Resets"), "3");
  EXPECT_EQ(second("Holes"), "5");
  EXPECT_EQ(second("Non-finite texels"), "2");
  EXPECT_EQ(second("Frame"), "123 p95 234");  // half to even, as IEEE rounds 234.5
  EXPECT_EQ(second("Frame against forward"), "1.23 ×");
  EXPECT_EQ(second("Gather and shade"), "45.7 p95 56.8");
  EXPECT_EQ(second("Display"), "0.012 p95 3.46");
  EXPECT_EQ(second("Shading per sample"), "98.8");
  EXPECT_EQ(rowOf(html, 0, "Shading per sample against forward"), (Cells{"1.00 ×", "1.98 ×", "–"}));
  // Forward equals itself, and has no atlas; a pass belongs to the methods that ran it.
  EXPECT_EQ(rowOf(html, 0, "PSNR")[0], "∞");
  EXPECT_EQ(rowOf(html, 0, "Texels used")[0], "–");
  EXPECT_EQ(rowOf(html, 0, "shade")[0], "–");
  EXPECT_EQ(rowOf(html, 0, "forward")[1], "–");
  // The other scene has its own numbers, and facts stand above the pictures.
  EXPECT_EQ(rowOf(html, 1, "MSSIM"), (Cells{"1.0000", "0.9213"}));
  EXPECT_EQ(
      count(html,
            "81,234 triangles · 157 instances · 23 materials · 5 lights · 320 × 180 pixels · 60 frames"),
      2U);
  // The summary at the top.
  EXPECT_EQ(count(html,
                  "<td>0.9124</td><td>0.0457</td><td>2.35</td><td>123</td><td>1.23 ×</td><td>98.8</td>"
                  "<td>1.98 ×</td>"),
            1U);
}

TEST(ReportHtml, RowsThatNoMethodHasAreLeftOut) {
  Report report = bareReport("a.glb");
  report.scenes[0].methods[0].mssim = 1.0;
  const std::string html = toHtml(report);
  EXPECT_EQ(rowOf(html, 0, "MSSIM"), Cells{"1.0000"});
  EXPECT_TRUE(rowOf(html, 0, "Holes").empty());
  EXPECT_EQ(count(html, "Time of each pass"), 0U);
}

TEST(ReportHtml, PicturesComeBackAsTheyWere) {
  const Report report = fixtureReport();
  const Json data = dataOf(toHtml(report));
  std::set<std::string> kinds;
  std::size_t compared = 0;
  for (std::size_t s = 0; s < report.scenes.size(); ++s)
    for (std::size_t m = 0; m < report.scenes[s].methods.size(); ++m)
      for (std::size_t f = 0; f < report.scenes[s].methods[m].frames.size(); ++f) {
        const ReportFrame& frame = report.scenes[s].methods[m].frames[f];
        const Json& json = data["scenes"][s]["methods"][m]["frames"][f];
        EXPECT_EQ(json["frame"], frame.frame);
        const std::pair<const char*, const std::vector<std::uint8_t>*> pictures[] = {
            {"image", &frame.image}, {"error", &frame.error}, {"atlas", &frame.atlas}};
        for (const auto& [name, bytes] : pictures) {
          if (bytes->empty()) {
            EXPECT_TRUE(json[name].is_null()) << name;
            continue;
          }
          const auto uri = json[name].get<std::string>();
          const std::size_t comma = uri.find(',');
          kinds.insert(uri.substr(0, comma));
          EXPECT_EQ(fromBase64(uri.substr(comma + 1)), *bytes);
          ++compared;
        }
      }
  EXPECT_EQ(compared, 3U * (1 + 3 + 3) + 2U * (1 + 3));  // forward has no error map and no atlas
  EXPECT_EQ(kinds, (std::set<std::string>{"data:image/png;base64", "data:image/jpeg;base64"}));
}

TEST(ReportHtml, Base64OfEveryRemainder) {
  Report report = bareReport("a.glb");
  for (int length = 1; length <= 6; ++length) {
    ReportFrame frame;
    for (int i = 0; i < length; ++i) frame.image.push_back(static_cast<std::uint8_t>(0xFF - 37 * i));
    report.scenes[0].methods[0].frames.push_back(frame);
  }
  const Json data = dataOf(toHtml(report));
  for (std::size_t i = 0; i < 6; ++i) {
    const auto uri = data["scenes"][0]["methods"][0]["frames"][i]["image"].get<std::string>();
    const std::string text = uri.substr(uri.find(',') + 1);
    EXPECT_EQ(text.size() % 4, 0U);
    EXPECT_EQ(fromBase64(text), report.scenes[0].methods[0].frames[i].image);
  }
}

TEST(ReportHtml, HostileStringsStayText) {
  const std::string evil =
      "</script><script>alert('1')</script><img src=x onerror=\"alert(2)\">&{{data}}.glb";
  Report report = fixtureReport();
  const std::string plain = toHtml(report);
  ReportContext& c = report.context;
  for (std::string* text : {&c.backend, &c.renderer, &c.gl, &c.glsl, &c.timer, &c.commit, &c.command,
                            &report.scenes[0].file, &report.scenes[0].note, &report.scenes[0].errorMetric,
                            &report.scenes[0].methods[1].name, &report.scenes[0].methods[1].passes[0].name})
    *text = evil;
  const std::string html = toHtml(report);
  EXPECT_EQ(count(html, "<script"), count(plain, "<script"));
  EXPECT_EQ(count(html, "</script"), count(plain, "</script"));
  EXPECT_EQ(count(html, "<img"), count(plain, "<img"));
  EXPECT_GE(count(html,
                  "&lt;/script&gt;&lt;script&gt;alert(&#39;1&#39;)&lt;/script&gt;&lt;img src=x "
                  "onerror=&quot;alert(2)&quot;&gt;&amp;{{data}}.glb"),
            11U);
  EXPECT_EQ(dataOf(html)["scenes"][0]["file"], evil);
  EXPECT_EQ(Json::parse(toJson(report))["scenes"][0]["file"], evil);
}

TEST(ReportHtml, EmptyReport) {
  EXPECT_EQ(Json::parse(toJson({}))["scenes"], Json::array());
  EXPECT_EQ(dataOf(toHtml({}))["scenes"], Json::array());
}

/// Leaves pages in the build folder, to be looked at.
TEST(ReportHtml, WritesPagesToLookAt) {
  const std::filesystem::path folder = std::filesystem::path(TESSERA_BINARY_DIR) / "report_fixture";
  std::filesystem::create_directories(folder);
  const Report report = fixtureReport();
  std::ofstream(folder / "report.html", std::ios::binary) << toHtml(report);
  std::ofstream(folder / "report.json", std::ios::binary) << toJson(report);
  EXPECT_EQ(readText(folder / "report.html"), toHtml(report));
}

}  // namespace
}  // namespace tessera
