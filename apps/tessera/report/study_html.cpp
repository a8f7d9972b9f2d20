#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/tessera/report/report_json.hpp"
#include "apps/tessera/report/report_page.hpp"
#include "apps/tessera/report/report_table.hpp"
#include "apps/tessera/report/study_report.hpp"

namespace tessera {

namespace {

using Json = nlohmann::ordered_json;
using Figure = std::vector<StudyPoint> StudyMethod::*;
using Axis = double StudyPoint::*;

Json pointsData(const std::vector<StudyPoint>& points, Axis axis) {
  Json list = Json::array();
  for (const StudyPoint& point : points)
    list.push_back({{"x", number(point.*axis)}, {"y", number(std::round(point.mssim * 1e5) / 1e5)}});
  return list;
}

Json stagesData(const std::vector<StudyStage>& stages) {
  Json list = Json::array();
  for (const StudyStage& stage : stages)
    list.push_back({{"name", stage.name}, {"ms", std::round(stage.ms * 1e2) / 1e2}});
  return list;
}

Json sceneData(const StudyScene& scene) {
  Json methods = Json::array();
  for (const StudyMethod& m : scene.methods)
    methods.push_back({{"name", m.name},
                       {"atlas", m.atlas},
                       {"latency", pointsData(m.byLatency, &StudyPoint::latencyMs)},
                       {"rate", pointsData(m.byRate, &StudyPoint::serverHz)},
                       {"bitrate", pointsData(m.byBitrate, &StudyPoint::mbit)}});
  return {{"methods", std::move(methods)},
          {"server", stagesData(scene.timeline.server)},
          {"viewer", stagesData(scene.timeline.viewer)}};
}

/// A row of heads: the values of the axis; then a row a method.
std::string figureTable(const StudyScene& scene, const char* title, Figure figure, Axis axis) {
  if (scene.methods.empty() || (scene.methods.front().*figure).empty()) return {};
  const auto& heads = scene.methods.front().*figure;
  std::string out = fmt::format("<table class=\"bench\"><thead><tr><th scope=\"col\">{}</th>", title);
  for (const StudyPoint& point : heads) out += fmt::format("<th scope=\"col\">{:g}</th>", point.*axis);
  out += "</tr></thead><tbody>\n";
  std::vector<double> best(heads.size(), -1.0);
  for (const StudyMethod& method : scene.methods)
    for (std::size_t i = 0; i < (method.*figure).size(); ++i)
      best[i] = std::max(best[i], (method.*figure)[i].mssim);
  for (const StudyMethod& method : scene.methods) {
    out += fmt::format("<tr><th scope=\"row\">{}</th>", escapeHtml(method.name));
    for (std::size_t i = 0; i < (method.*figure).size(); ++i) {
      const double value = (method.*figure)[i].mssim;
      out += fmt::format("<td{}>{}</td>", value == best[i] ? " class=\"best\"" : "", formatFixed(value, 4));
    }
    out += "</tr>\n";
  }
  return out + "</tbody></table>\n";
}

/// What streams are made of, at the latency that the videos have.
std::string streamTable(const StudyScene& scene, double latencyMs) {
  std::string out =
      "<table class=\"bench\"><thead><tr><th scope=\"col\">Method</th><th scope=\"col\">Coded picture</th>"
      "<th scope=\"col\">MSSIM</th><th scope=\"col\">worst</th><th scope=\"col\">PSNR, dB</th>"
      "<th scope=\"col\">Video, Mbit/s</th><th scope=\"col\">Geometry, Mbit/s</th><th "
      "scope=\"col\">Uncovered pixels</th><th scope=\"col\">Atlas used</th><th scope=\"col\">Level "
      "bias</th></tr></thead><tbody>\n";
  bool any = false;
  for (const StudyMethod& m : scene.methods)
    for (const StudyPoint& p : m.byLatency) {
      if (std::abs(p.latencyMs - latencyMs) > 1e-6) continue;
      any = true;
      out += fmt::format(
          "<tr><th scope=\"row\">{}</th><td>{} × {}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
          "<td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
          escapeHtml(m.name), m.width, m.height, formatFixed(p.mssim, 4), formatFixed(p.mssimWorst, 4),
          formatFixed(p.psnrDb, 2), formatFixed(p.videoMbit, 2), formatFixed(p.metaMbit, 2),
          formatFixed(p.uncoveredPixels, 1), formatShare(p.atlasUsed), formatFixed(p.bias, 2));
    }
  return any ? fmt::format(
                   "<h3>The streams at {:g} ms of latency</h3><div "
                   "class=\"scroll\">{}</tbody></table></div>\n",
                   latencyMs, out)
             : std::string();
}

std::string findingsList(const StudyScene& scene) {
  std::string out;
  for (const StudyFinding& f : findingsOf(scene))
    out += fmt::format(
        "<li{}>{}{}</li>\n", f.goal ? (f.reached ? " class=\"reached\"" : " class=\"missed\"") : "",
        f.goal ? (f.reached ? "<b>Goal reached.</b> " : "<b>Goal missed.</b> ") : "", escapeHtml(f.text));
  return out.empty() ? out : "<ul class=\"findings\">\n" + out + "</ul>\n";
}

std::string video(const std::string& name, double mssim, const std::vector<std::uint8_t>& file) {
  if (file.empty()) return {};
  const std::string quality = std::isnan(mssim) ? "" : fmt::format(" <small>MSSIM {:.4f}</small>", mssim);
  return fmt::format(
      "<figure><video muted loop playsinline preload=\"auto\" "
      "src=\"{}\"></video><figcaption>{}{}</figcaption>"
      "</figure>\n",
      dataUri(file).get<std::string>(), escapeHtml(name), quality);
}

std::string videos(const StudyScene& scene, double latencyMs) {
  std::string out = video("Truth: forward, no latency", kNotMeasured, scene.truth);
  if (out.empty()) return out;
  for (const StudyMethod& m : scene.methods) {
    double mssim = kNotMeasured;
    for (const StudyPoint& p : m.byLatency)
      if (std::abs(p.latencyMs - latencyMs) < 1e-6) mssim = p.mssim;
    out += video(m.name, mssim, m.video);
  }
  return fmt::format(
      "<h3>In motion at {:g} ms of latency <small>what the viewer shows, all methods at once</small></h3>\n"
      "<div class=\"bar\"><button type=\"button\" class=\"play\">Play</button><label>Speed <select "
      "class=\"speed\"><option value=\"1\">1</option><option value=\"0.5\">1/2</option><option "
      "value=\"0.25\" selected>1/4</option><option value=\"0.1\">1/10</option></select></label></div>\n"
      "<div class=\"videos\">\n{}</div>\n",
      latencyMs, out);
}

std::string timeline(const StudyTimeline& t) {
  if (!t.failed.empty())
    return fmt::format("<p class=\"facts\">No time line of the two programs: {}</p>\n", escapeHtml(t.failed));
  if (t.viewer.empty()) return {};
  return fmt::format(
      "<h3>From a pose to its picture <small>tessera serve and tessera view, two processes over loopback, "
      "{}; "
      "medians</small></h3>\n<div class=\"charts timeline\"></div>\n"
      "<p class=\"facts\">End to end {} ms (the median of sums; the stages above are medians of their own) · "
      "first picture after {} s · video {} Mbit/s · geometry {} Mbit/s · the server's own work, all but "
      "shading "
      "and coding, is {} of its frame. Both programs share this machine's processor with the renderer.</p>\n",
      escapeHtml(t.method), formatDuration(t.totalMs), formatFixed(t.firstPictureSeconds, 2),
      formatFixed(t.videoMbit, 2), formatFixed(t.metaMbit, 2), formatShare(t.ownShare));
}

std::string sceneSection(const StudyReport& report, std::size_t index) {
  const StudyScene& scene = report.scenes[index];
  return fmt::format(
      "<section class=\"scene\" id=\"scene-{0}\" data-scene=\"{0}\">\n<h2>{1}</h2>\n"
      "<p class=\"facts\">{2} triangles · {3} · {4} samples of {5} × {6} pixels over {7:.2f} s, after "
      "{8:.2f} s of "
      "stream, from second {9:.2f} of the path on · camera {10:.2f} m/s, {11:.1f}°/s</p>\n"
      "{12}<div class=\"charts figures\"></div>\n{13}{14}"
      "<details><summary>The numbers</summary><div "
      "class=\"scroll\">{15}{16}{17}</div>{18}</details>\n</section>\n",
      index, escapeHtml(scene.file), formatCount(static_cast<double>(scene.triangles)),
      escapeHtml(scene.note), scene.samples, scene.width, scene.height, scene.seconds, scene.leadSeconds,
      scene.start, scene.metresPerSecond, scene.degreesPerSecond, findingsList(scene),
      videos(scene, report.videoLatencyMs), timeline(scene.timeline),
      figureTable(scene, "MSSIM by latency, ms", &StudyMethod::byLatency, &StudyPoint::latencyMs),
      figureTable(scene, "MSSIM by server rate, Hz", &StudyMethod::byRate, &StudyPoint::serverHz),
      figureTable(scene, "MSSIM by bitrate, Mbit/s", &StudyMethod::byBitrate, &StudyPoint::mbit),
      streamTable(scene, report.videoLatencyMs));
}

}  // namespace

std::string toHtml(const StudyReport& report) {
  Json scenes = Json::array();
  std::string sections;
  for (std::size_t i = 0; i < report.scenes.size(); ++i) {
    scenes.push_back(sceneData(report.scenes[i]));
    sections += sceneSection(report, i);
  }
  std::string settings;
  for (const auto& [name, value] : report.settings)
    settings += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", escapeHtml(name), escapeHtml(value));
  const std::string context = contextList(report.context);
  const std::string data =
      scriptData({{"serverHz", report.serverHz}, {"mbit", report.mbit}, {"scenes", std::move(scenes)}});
  return fillPage("study.html", {{"title", "streamed atlases against warped pictures"},
                                 {"context", context},
                                 {"settings", settings},
                                 {"scenes", sections},
                                 {"data", data}});
}

}  // namespace tessera
