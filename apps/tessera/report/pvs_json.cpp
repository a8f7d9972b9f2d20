#include <cmath>
#include <utility>

#include "apps/tessera/report/pvs_report.hpp"
#include "apps/tessera/report/report_json.hpp"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

Json seriesJson(const PvsRun& run) {
  Json series = Json::object();
  const auto add = [&](const char* name, double PvsFrame::*field, double scale) {
    Json values = Json::array();
    for (const PvsFrame& frame : run.frames)
      values.push_back(number(std::round(frame.*field * scale) / scale));
    series[name] = std::move(values);
  };
  add("time_s", &PvsFrame::time, 1e6);
  add("coverage", &PvsFrame::coverage, 1e7);
  add("overestimation", &PvsFrame::overestimation, 1e7);
  add("missed_pixels", &PvsFrame::missedPixels, 1e2);
  add("elements", &PvsFrame::elements, 1.0);
  add("needed_elements", &PvsFrame::neededElements, 1.0);
  add("ms", &PvsFrame::ms, 1e3);
  return series;
}

Json runJson(const PvsRun& run) {
  const PvsSummary s = summarize(run);
  return {{"name", run.name},
          {"prediction", run.prediction},
          {"margin_deg", run.marginDegrees},
          {"steps", run.steps},
          {"views", run.views},
          {"view_size", {run.width, run.height}},
          {"coverage", number(s.coverage)},
          {"coverage_worst", number(s.coverageWorst)},
          {"overestimation", number(s.overestimation)},
          {"overestimation_worst", number(s.overestimationWorst)},
          {"missed_pixels_per_view", number(s.missedPixels)},
          {"elements", number(s.elements)},
          {"needed_elements", number(s.neededElements)},
          {"ms", timingJson(s.ms)},
          {"series", seriesJson(run)}};
}

}  // namespace

std::string toJson(const PvsReport& report) {
  Json scenes = Json::array();
  for (const PvsScene& scene : report.scenes) {
    Json runs = Json::array();
    for (const PvsRun& run : scene.runs) runs.push_back(runJson(run));
    scenes.push_back({{"scene", scene.scene},
                      {"path", scene.path},
                      {"element", scene.element},
                      {"size", {scene.width, scene.height}},
                      {"rate_hz", scene.rate},
                      {"latency_ms", scene.latencyMs},
                      {"shown_views", scene.shownViews},
                      {"id_pass_ms", timingJson(scene.idMs)},
                      {"runs", std::move(runs)}});
  }
  const Json root = {{"schema", 1}, {"context", contextJson(report.context)}, {"scenes", std::move(scenes)}};
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tessera
