#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/tessera/report/bench_report.hpp"
#include "apps/tessera/report/report_page.hpp"
#include "apps/tessera/report/report_table.hpp"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

std::string headRow(const std::vector<std::string>& names) {
  std::string out = "<thead><tr>";
  for (const std::string& name : names) out += "<th scope=\"col\">" + name + "</th>";
  return out + "</tr></thead>\n";
}

/// `note`: a cell over all columns that are left, if there is something to say.
std::string row(const std::string& head, const std::vector<std::string>& cells, const std::string& note = {},
                std::size_t noteColumns = 0) {
  std::string out = "<tr><th scope=\"row\">" + head + "</th>";
  for (const std::string& cell : cells) out += "<td>" + cell + "</td>";
  if (!note.empty()) out += fmt::format("<td class=\"note\" colspan=\"{}\">{}</td>", noteColumns, note);
  return out + "</tr>\n";
}

const std::vector<std::string> kSummaryHead = {
    "Frames out of memory", "Blocks reduced",       "Resets", "Live, of the atlas", "Kept their place",
    "Live texels moved",    "moved outside resets", "Bias",   "ms a frame"};

std::vector<std::string> summaryCells(const BenchSummary& s) {
  return {formatCount(static_cast<double>(s.oomFrames)),
          formatCount(s.reduced),
          formatCount(static_cast<double>(s.resets)),
          formatShare(s.liveShare),
          formatShare(s.keptPlace, 2),
          formatShare(s.movedShare, 2),
          formatShare(s.movedShareOutsideResets, 2),
          formatFixed(s.bias, 2),
          timingCell(s.ms)};
}

/// Every run of a scene, the CPU's last.
std::vector<const BenchRun*> runsOf(const BenchScene& scene) {
  std::vector<const BenchRun*> runs;
  for (const BenchRun& run : scene.strategies) runs.push_back(&run);
  runs.push_back(&scene.quadtree);
  return runs;
}

std::string strategyTable(const BenchScene& scene) {
  std::vector<std::string> head = {"Strategy"};
  head.insert(head.end(), kSummaryHead.begin(), kSummaryHead.end());
  std::string out = "<table class=\"bench\">" + headRow(head) + "<tbody>\n";
  for (const BenchRun* run : runsOf(scene)) out += row(escapeHtml(run->name), summaryCells(summarize(*run)));
  return out + "</tbody></table>\n";
}

std::string sweepTable(const BenchScene& scene) {
  if (scene.sweep.empty()) return {};
  std::vector<std::string> head = {"Superblock", "Smallest side", "Largest side", "Largest aspect"};
  head.insert(head.end(), kSummaryHead.begin(), kSummaryHead.end());
  std::string out =
      "<h3>S0 with other sizes <small>texels; the default in bold</small></h3>\n"
      "<div class=\"scroll\"><table class=\"bench\">" +
      headRow(head) + "<tbody>\n";
  for (const BenchVariant& v : scene.sweep) {
    std::vector<std::string> cells = {fmt::format("{}", v.smallest), fmt::format("{}", v.largest),
                                      fmt::format("{} : 1", v.aspect)};
    const std::string size =
        v.standard ? fmt::format("<b>{}</b>", v.superblock) : fmt::format("{}", v.superblock);
    if (!v.skipped.empty()) {
      out += row(size, cells, "skipped: " + escapeHtml(v.skipped), kSummaryHead.size());
      continue;
    }
    const auto summary = summaryCells(v.summary);
    cells.insert(cells.end(), summary.begin(), summary.end());
    out += row(size, cells);
  }
  return out + "</tbody></table></div>\n";
}

std::string speedTable(const BenchReport& report) {
  std::string out = "<table class=\"bench\">" +
                    headRow({"Scene", "CPU quadtree, ms", "GPU S0, ms", "Speed-up",
                             "Frame rendered whole, ms", "of that, memory phases"}) +
                    "<tbody>\n";
  for (const BenchScene& scene : report.scenes) {
    const double cpu = summarize(scene.quadtree).ms.median;
    const auto s0 = std::find_if(scene.strategies.begin(), scene.strategies.end(),
                                 [](const BenchRun& run) { return run.name == "S0"; });
    const bool ran = s0 != scene.strategies.end();
    const double gpu = ran ? summarize(*s0).ms.median : kNotMeasured;
    const double speedUp = cpu / gpu;
    out += row(
        escapeHtml(scene.scene),
        {formatDuration(cpu), ran ? formatDuration(gpu) : "not run",
         std::isfinite(speedUp) ? formatFixed(speedUp, speedUp < 10 ? 2 : 0) + " ×" : kDash,
         formatDuration(scene.frameMs.median), formatShare(scene.memoryMs.median / scene.frameMs.median, 2)});
  }
  return out + "</tbody></table>\n";
}

std::string sceneSection(const BenchScene& scene, std::size_t index) {
  return fmt::format(
      "<section class=\"scene\" id=\"scene-{0}\" data-scene=\"{0}\">\n<h2>{1}</h2>\n"
      "<p class=\"facts\">{2} frames of {3} × {4} pixels, {5:.1f} a second · {6} patch instances, {7} "
      "visible "
      "on average · atlas of {8} × {9} texels</p>\n"
      "<div class=\"scroll\">{10}</div>\n<div class=\"charts\"></div>\n{11}</section>\n",
      index, escapeHtml(scene.scene), scene.quadtree.frames.size(), scene.width, scene.height, scene.fps,
      formatCount(scene.patchInstances), formatCount(scene.visiblePatches), scene.atlasWidth,
      scene.atlasHeight, strategyTable(scene), sweepTable(scene));
}

Json runData(const BenchRun& run) {
  constexpr double kMega = 1048576.0;
  const BenchSummary summary = summarize(run);
  Json areas = Json::array();
  for (const auto field : {&BenchFrame::live, &BenchFrame::end, &BenchFrame::stack, &BenchFrame::inaccessible,
                           &BenchFrame::free}) {
    Json values = Json::array();
    for (const BenchFrame& frame : run.frames) values.push_back(std::round(frame.*field / kMega * 1e4) / 1e4);
    areas.push_back(std::move(values));
  }
  Json bias = Json::array();
  Json ms = Json::array();
  for (const BenchFrame& frame : run.frames) {
    bias.push_back(std::round(frame.bias * 1e3) / 1e3);
    ms.push_back(std::round(frame.ms * 1e3) / 1e3);
  }
  if (!ms.empty()) ms.front() = nullptr;  // see BenchSummary::ms
  return {{"name", run.name},
          {"oomFrames", summary.oomFrames},
          {"resets", summary.resets},
          {"areas", areas},
          {"bias", bias},
          {"ms", ms}};
}

}  // namespace

std::string toHtml(const BenchReport& report) {
  Json scenes = Json::array();
  std::string sections;
  for (std::size_t i = 0; i < report.scenes.size(); ++i) {
    const BenchScene& scene = report.scenes[i];
    Json runs = Json::array();
    for (const BenchRun* run : runsOf(scene)) runs.push_back(runData(*run));
    const double texels = static_cast<double>(scene.atlasWidth) * scene.atlasHeight;
    scenes.push_back({{"megapixels", texels / 1048576.0}, {"runs", std::move(runs)}});
    sections += sceneSection(scene, i);
  }
  const std::string context = contextList(report.context);
  const std::string settings = escapeHtml(report.settings);
  const std::string speed = speedTable(report);
  const std::string data = scriptData({{"scenes", std::move(scenes)}});
  return fillPage("bench.html", {{"title", "memory of the shading atlas under pressure"},
                                 {"context", context},
                                 {"settings", settings},
                                 {"speed", speed},
                                 {"scenes", sections},
                                 {"data", data}});
}

}  // namespace tessera
