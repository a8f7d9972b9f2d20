#include "apps/tessera/report/report_figures.hpp"

#include <cmath>

#include <fmt/format.h>

#include "apps/tessera/report/report_json.hpp"
#include "apps/tessera/report/report_table.hpp"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

const ReportMethod* methodOf(const ReportScene& scene, const ReportBar& bar) {
  return methodNamed(scene, bar.method);
}

/// Columns that only some figures need: those for which a bar has a number.
struct Extra {
  bool pairs = false;
  bool foveated = false;
};

Extra extraOf(const Report& report, const ReportFigure& figure) {
  Extra extra;
  for (const ReportScene& scene : report.scenes)
    for (const ReportBar& bar : figure.bars)
      if (const ReportMethod* method = methodOf(scene, bar)) {
        extra.pairs = extra.pairs || !std::isnan(mssimOfRightEye(*method));
        extra.foveated = extra.foveated || !std::isnan(method->mssimAcuity);
      }
  return extra;
}

std::string row(const ReportScene& scene, const ReportBar& bar, const ReportMethod& method, Extra extra) {
  std::string cells = fmt::format(
      "<th scope=\"row\">{} <small>{}</small></th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
      escapeHtml(bar.label), escapeHtml(bar.method), formatShare(shadedPerTargetPixel(scene, method)),
      formatShare(shadedPerPicturePixel(scene, method)), formatShare(shadedAgainstReference(scene, method)),
      formatShare(method.invocations / (static_cast<double>(scene.width) * scene.height)),
      formatFixed(method.mssim, 4));
  if (extra.pairs) cells += fmt::format("<td>{}</td>", formatFixed(mssimOfRightEye(method), 4));
  if (extra.foveated) cells += fmt::format("<td>{}</td>", formatFixed(method.mssimAcuity, 4));
  return "<tr>" + cells + "</tr>\n";
}

}  // namespace

Json figureJson(const Report& report, const ReportFigure& figure) {
  Json scenes = Json::array();
  for (const ReportScene& scene : report.scenes) {
    Json bars = Json::array();
    for (const ReportBar& bar : figure.bars) {
      const ReportMethod* method = methodOf(scene, bar);
      if (method == nullptr) continue;
      bars.push_back({{"method", bar.method},
                      {"label", bar.label},
                      {"shaded_per_target_pixel", number(shadedPerTargetPixel(scene, *method))},
                      {"shaded_per_picture_pixel", number(shadedPerPicturePixel(scene, *method))},
                      {"shaded_against_reference", number(shadedAgainstReference(scene, *method))},
                      {"mssim", number(method->mssim)},
                      {"mssim_right_eye", number(mssimOfRightEye(*method))},
                      {"mssim_acuity", number(method->mssimAcuity)}});
    }
    scenes.push_back({{"file", scene.file}, {"bars", std::move(bars)}});
  }
  return {
      {"figure", figure.id}, {"title", figure.title}, {"text", figure.text}, {"scenes", std::move(scenes)}};
}

std::string figureSection(const Report& report, std::size_t index) {
  const ReportFigure& figure = report.figures[index];
  const Extra extra = extraOf(report, figure);
  std::string out = fmt::format(
      "<section class=\"figure\" id=\"figure-{0}\" data-figure=\"{0}\">\n<h2>Figure {1}: {2}</h2>\n"
      "<p class=\"facts\">{3}</p>\n<div class=\"charts\"></div>\n<div class=\"scroll\"><table "
      "class=\"summary\"><thead><tr><th scope=\"col\">Scene and method</th><th scope=\"col\">Samples shaded, "
      "of a "
      "picture's pixels</th><th scope=\"col\">of all pictures' pixels</th><th scope=\"col\">of forward's "
      "samples</th><th scope=\"col\">Invocations as GL counts them, of a picture's pixels</th><th "
      "scope=\"col\">{4}</th>{5}</tr></thead>\n",
      index, escapeHtml(figure.id), escapeHtml(figure.title), escapeHtml(figure.text),
      extra.pairs ? "MSSIM, mean of both eyes</th><th scope=\"col\">of the right eye" : "MSSIM",
      extra.foveated ? "<th scope=\"col\">MSSIM by acuity</th>" : "");
  for (std::size_t s = 0; s < report.scenes.size(); ++s) {
    const ReportScene& scene = report.scenes[s];
    out += fmt::format(
        "<tbody><tr class=\"group\"><th scope=\"rowgroup\" colspan=\"{}\"><a "
        "href=\"#scene-{}\">{}</a></th></tr>\n",
        6 + static_cast<int>(extra.pairs) + static_cast<int>(extra.foveated), s, escapeHtml(scene.file));
    for (const ReportBar& bar : figure.bars)
      if (const ReportMethod* method = methodOf(scene, bar)) out += row(scene, bar, *method, extra);
    out += "</tbody>\n";
  }
  return out + "</table></div>\n</section>\n";
}

}  // namespace tessera
