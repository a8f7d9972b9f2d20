#include <cmath>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/tessera/report/report.hpp"
#include "apps/tessera/report/report_atlas.hpp"
#include "apps/tessera/report/report_figures.hpp"
#include "apps/tessera/report/report_page.hpp"
#include "apps/tessera/report/report_table.hpp"
#include "engine/measure/colormap.hpp"

namespace tessera {

namespace {

using Json = nlohmann::ordered_json;

// NaN becomes null when the JSON is written, which the charts show as a gap.
Json methodData(const ReportMethod& method) {
  Json passes = Json::array();
  for (const ReportPass& pass : method.passes)
    passes.push_back({{"name", pass.name}, {"median", pass.ms.median}});
  Json frames = Json::array();
  for (const ReportFrame& frame : method.frames)
    frames.push_back({{"frame", frame.frame},
                      {"image", dataUri(frame.image)},
                      {"error", dataUri(frame.error)},
                      {"atlas", dataUri(frame.atlas)}});
  Json kinds = Json::array();
  for (const ReportKind& kind : method.kinds)
    kinds.push_back({{"name", kind.name}, {"color", kind.color}, {"samples", kind.samples}});
  Json curve = Json::array();
  for (const ReportCurvePoint& point : method.curve)
    curve.push_back({{"x", point.samplesPerPixel}, {"y", point.mssim}, {"bias", point.bias}});
  const ReportSeries& s = method.series;
  return {{"name", method.name},
          {"passes", std::move(passes)},
          {"series",
           {{"frameMs", s.frameMs},
            {"mssim", s.mssim},
            {"flip", s.flip},
            {"samplesShaded", s.samplesShaded},
            {"atlasTexelsUsed", s.atlasTexelsUsed},
            {"bias", s.bias}}},
          {"frames", std::move(frames)},
          {"kinds", std::move(kinds)},
          {"kindPicture", dataUri(method.kindPicture)},
          {"curve", std::move(curve)}};
}

Json cropData(const ReportCrop& crop) {
  Json pictures = Json::array();
  for (const ReportCrop::Picture& picture : crop.pictures)
    pictures.push_back(
        {{"method", picture.method}, {"mssim", picture.mssim}, {"image", dataUri(picture.image)}});
  return {{"frame", crop.frame},
          {"x", crop.x},
          {"y", crop.y},
          {"width", crop.width},
          {"height", crop.height},
          {"slantedShare", crop.slantedShare},
          {"pictures", std::move(pictures)}};
}

/// What the page's script reads.
std::string pageData(const Report& report) {
  Json stops = Json::array();
  for (const Rgb8& stop : colormapStops())
    stops.push_back(fmt::format("rgb({},{},{})", stop[0], stop[1], stop[2]));
  Json scenes = Json::array();
  for (const ReportScene& scene : report.scenes) {
    Json methods = Json::array();
    for (const ReportMethod& method : scene.methods) methods.push_back(methodData(method));
    Json crops = Json::array();
    for (const ReportCrop& crop : scene.crops) crops.push_back(cropData(crop));
    scenes.push_back({{"file", scene.file},
                      {"width", scene.width},
                      {"height", scene.height},
                      {"errorMetric", scene.errorMetric},
                      {"errorFull", scene.errorFull},
                      {"crops", std::move(crops)},
                      {"methods", std::move(methods)}});
  }
  Json figures = Json::array();
  for (const ReportFigure& figure : report.figures) figures.push_back(figureJson(report, figure));
  const Json root = {
      {"stops", std::move(stops)}, {"scenes", std::move(scenes)}, {"figures", std::move(figures)}};
  return scriptData(root);
}

std::string sceneSection(const ReportScene& scene, std::size_t index) {
  return fmt::format(
      "<section class=\"scene\" id=\"scene-{0}\" data-scene=\"{0}\">\n<h2>{1}</h2>\n"
      "<p class=\"facts\">{2} triangles · {3} instances · {4} materials · {5} lights · {6} × {7} pixels · "
      "{8} "
      "frames</p>\n<p class=\"facts\">{9}</p>\n<div class=\"pictures\"></div>\n"
      "<div class=\"kinds\"></div>\n<div class=\"crops\"></div>\n<div class=\"charts\"></div>\n{11}<div "
      "class=\"scroll\">{10}</div>\n</section>\n",
      index, escapeHtml(scene.file), formatCount(static_cast<double>(scene.triangles)),
      formatCount(static_cast<double>(scene.instances)), formatCount(static_cast<double>(scene.materials)),
      formatCount(static_cast<double>(scene.lights)), scene.width, scene.height, scene.frames,
      escapeHtml(scene.note), methodTable(scene), atlasTables(scene));
}

}  // namespace

std::string toHtml(const Report& report) {
  std::string scenes;
  for (std::size_t i = 0; i < report.scenes.size(); ++i) scenes += sceneSection(report.scenes[i], i);
  std::string figures;
  for (std::size_t i = 0; i < report.figures.size(); ++i) figures += figureSection(report, i);
  const std::string context = contextList(report.context);
  const std::string summary = summaryTable(report);
  const std::string data = pageData(report);
  return fillPage("report.html", {{"title", "shading atlas compared with forward rendering"},
                                  {"context", context},
                                  {"summary", summary},
                                  {"figures", figures},
                                  {"scenes", scenes},
                                  {"data", data}});
}

}  // namespace tessera
