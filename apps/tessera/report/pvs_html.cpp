#include <cmath>

#include <fmt/format.h>

#include "apps/tessera/report/pvs_report.hpp"
#include "apps/tessera/report/report_page.hpp"
#include "apps/tessera/report/report_table.hpp"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

std::string runTable(const PvsScene& scene) {
  std::string out =
      "<table class=\"bench\"><thead><tr><th scope=\"col\">Prediction</th><th scope=\"col\">Coverage</th>"
      "<th scope=\"col\">worst frame</th><th scope=\"col\">Overestimation</th><th scope=\"col\">worst "
      "frame</th><th scope=\"col\">Missed pixels a view</th><th scope=\"col\">In the set</th><th "
      "scope=\"col\">needed</th><th scope=\"col\">Views</th><th scope=\"col\">ms a set</th></tr></thead>"
      "<tbody>\n";
  for (const PvsRun& run : scene.runs) {
    const PvsSummary s = summarize(run);
    out += fmt::format(
        "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
        "<td>{}</td><td>{} of {} × {}</td><td>{}</td></tr>\n",
        escapeHtml(run.name), formatShare(s.coverage, 3), formatShare(s.coverageWorst, 3),
        formatShare(s.overestimation, 2), formatShare(s.overestimationWorst, 2),
        formatFixed(s.missedPixels, 1), formatCount(s.elements), formatCount(s.neededElements), run.views,
        run.width, run.height, timingCell(s.ms));
  }
  return out + "</tbody></table>\n";
}

std::string sceneSection(const PvsScene& scene, std::size_t index) {
  return fmt::format(
      "<section class=\"scene\" id=\"scene-{0}\" data-scene=\"{0}\">\n<h2>{1}</h2>\n"
      "<p class=\"facts\">path {2} · {3} shown views of {4} × {5} pixels at {6:g} a second, {7:.1f} ms · one "
      "id pass {8} ms · elements are {9}</p>\n<div class=\"scroll\">{10}</div>\n<div "
      "class=\"charts\"></div>\n</section>\n",
      index, escapeHtml(scene.scene), escapeHtml(scene.path), scene.shownViews, scene.width, scene.height,
      scene.rate, scene.latencyMs, timingCell(scene.idMs),
      scene.element == "triangle" ? "triangles" : "patches", runTable(scene));
}

Json sceneData(const PvsScene& scene) {
  Json runs = Json::array();
  Json times = Json::array();
  for (const PvsRun& run : scene.runs) {
    Json coverage = Json::array();
    Json overestimation = Json::array();
    Json missed = Json::array();
    times = Json::array();
    for (const PvsFrame& frame : run.frames) {
      coverage.push_back(std::round(frame.coverage * 1e7) / 1e5);
      overestimation.push_back(std::isfinite(frame.overestimation)
                                   ? Json(std::round(frame.overestimation * 1e6) / 1e4)
                                   : Json(nullptr));
      // A logarithmic axis has no 0.
      missed.push_back(frame.missedPixels > 0.0 ? Json(std::round(frame.missedPixels * 1e2) / 1e2)
                                                : Json(nullptr));
      times.push_back(std::round(frame.time * 1e2) / 1e2);
    }
    runs.push_back({{"name", run.name},
                    {"coverage", std::move(coverage)},
                    {"missed", std::move(missed)},
                    {"overestimation", std::move(overestimation)}});
  }
  return {{"times", std::move(times)}, {"runs", std::move(runs)}};
}

}  // namespace

std::string toHtml(const PvsReport& report) {
  Json scenes = Json::array();
  std::string sections;
  for (std::size_t i = 0; i < report.scenes.size(); ++i) {
    scenes.push_back(sceneData(report.scenes[i]));
    sections += sceneSection(report.scenes[i], i);
  }
  const std::string context = contextList(report.context);
  const std::string data = scriptData({{"scenes", std::move(scenes)}});
  return fillPage("pvs.html", {{"title", "potentially visible sets of predicted views"},
                               {"context", context},
                               {"scenes", sections},
                               {"data", data}});
}

}  // namespace tessera
