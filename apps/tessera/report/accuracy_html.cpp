#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/tessera/report/accuracy_report.hpp"
#include "apps/tessera/report/report_json.hpp"
#include "apps/tessera/report/report_page.hpp"
#include "apps/tessera/report/report_table.hpp"
#include "engine/measure/colormap.hpp"

namespace tessera {

namespace {

using Json = nlohmann::ordered_json;

Json pointData(const AccuracyPoint& point) {
  Json config = Json::array();
  for (const auto& [knob, value] : point.config) config.push_back(Json::array({knob, value}));
  return {{"name", point.name},
          {"config", std::move(config)},
          {"ms", number(point.ms.median)},
          {"ms_low", number(point.ms.low)},
          {"ms_high", number(point.ms.high)},
          {"dssim", number(point.dssim.median)},
          {"dssim_low", number(point.dssim.low)},
          {"dssim_high", number(point.dssim.high)},
          {"psnr", number(point.psnrDb)},
          {"flip", number(point.flip)},
          {"samples", number(point.samples)},
          {"texels", number(point.texels)},
          {"bytes", number(point.bytes)},
          {"runs", point.runs},
          {"image", dataUri(point.pareto || point.smallImage.empty() ? point.image : point.smallImage)},
          {"error", dataUri(point.pareto || point.smallError.empty() ? point.error : point.smallError)}};
}

/// Of a curve, whether each point can be told from the one before it, in cost or in error.
Json toldOf(const AccuracyScene& scene, const AccuracyCurve& curve) {
  Json told = Json::array();
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    // The first is told from the second.
    const AccuracyPoint& point = scene.points[curve.points[i]];
    const AccuracyPoint& other =
        scene.points[curve.points[i > 0 ? i - 1 : std::min<std::size_t>(1, curve.points.size() - 1)]];
    told.push_back(!(touch(point.ms, other.ms) && touch(point.dssim, other.dssim)));
  }
  return told;
}

Json knobData(const AccuracyScene& scene, const AccuracyKnob& knob) {
  Json curves = Json::array();
  for (const AccuracyCurve& curve : knob.curves)
    curves.push_back({{"with", curve.with},
                      {"values", curve.values},
                      {"points", curve.points},
                      {"told", toldOf(scene, curve)},
                      {"standard", curve.standard}});
  return {{"label", knob.label}, {"sentence", knob.sentence}, {"curves", std::move(curves)}};
}

Spread positive(double value) { return exactly(value > 0.0 ? value : kNotMeasured); }

/// The front of each cost with each error: points by index, rising in cost, and which of them can be told
/// apart.
Json frontsData(const AccuracyScene& scene) {
  using Of = Spread (*)(const AccuracyPoint&);
  const std::pair<const char*, Of> costs[] = {
      {"ms", [](const AccuracyPoint& p) { return p.ms; }},
      {"samples", [](const AccuracyPoint& p) { return positive(p.samples); }},
      {"texels", [](const AccuracyPoint& p) { return positive(p.texels); }},
      {"bytes", [](const AccuracyPoint& p) { return positive(p.bytes); }}};
  const std::pair<const char*, Of> errors[] = {
      {"dssim", [](const AccuracyPoint& p) { return p.dssim; }},
      {"psnr", [](const AccuracyPoint& p) { return exactly(-p.psnrDb); }},
      {"flip", [](const AccuracyPoint& p) { return exactly(p.flip); }}};
  Json fronts = Json::object();
  for (const auto& [cost, costOf] : costs)
    for (const auto& [error, errorOf] : errors) {
      std::vector<Tradeoff> trades;
      for (const AccuracyPoint& point : scene.points) trades.push_back({costOf(point), errorOf(point)});
      const auto front = paretoFront(trades);
      const auto told = distinguishable(trades, front);
      Json list = Json::array();
      for (std::size_t i = 0; i < front.size(); ++i) {
        Json entry = Json::array();
        entry.push_back(front[i]);
        entry.push_back(static_cast<bool>(told[i]));
        list.push_back(std::move(entry));
      }
      fronts[std::string(cost) + "/" + error] = std::move(list);
    }
  return fronts;
}

/// The colours of error maps, as CSS has them.
Json stopsData() {
  Json stops = Json::array();
  for (const Rgb8& stop : colormapStops())
    stops.push_back(fmt::format("rgb({},{},{})", stop[0], stop[1], stop[2]));
  return stops;
}

std::vector<const AccuracyPoint*> frontOf(const AccuracyScene& scene) {
  std::vector<const AccuracyPoint*> front;
  for (const AccuracyPoint& point : scene.points)
    if (point.pareto) front.push_back(&point);
  std::sort(front.begin(), front.end(),
            [](const AccuracyPoint* a, const AccuracyPoint* b) { return a->ms.median < b->ms.median; });
  return front;
}

std::string cells(const AccuracyPoint& point) {
  const double half = 0.5 * (point.ms.high - point.ms.low);
  return fmt::format("<td>{} ± {}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
                     formatDuration(point.ms.median), formatDuration(half),
                     formatFixed(point.dssim.median, 5), formatFixed(point.psnrDb, 2),
                     formatFixed(point.flip, 4), formatCount(point.samples), formatCount(point.texels),
                     formatFixed(point.bytes / 1048576.0, 1));
}

constexpr const char* kHead =
    "<th scope=\"col\">ms</th><th scope=\"col\">DSSIM</th><th scope=\"col\">PSNR, dB</th><th "
    "scope=\"col\">FLIP</th><th scope=\"col\">Samples</th><th scope=\"col\">Texels</th><th "
    "scope=\"col\">MiB</th>";

std::string pointsTable(const AccuracyScene& scene) {
  std::vector<std::size_t> order(scene.points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return scene.points[a].ms.median < scene.points[b].ms.median;
  });
  std::string out = fmt::format(
      "<table class=\"bench points\"><thead><tr><th scope=\"col\">Configuration</th>{}<th "
      "scope=\"col\">Front</th></tr></thead><tbody>\n",
      kHead);
  for (const std::size_t i : order) {
    const AccuracyPoint& point = scene.points[i];
    out += fmt::format("<tr data-point=\"{}\" tabindex=\"0\"><th scope=\"row\">{}</th>{}<td>{}</td></tr>\n",
                       i, escapeHtml(point.name), cells(point),
                       !point.pareto           ? ""
                       : point.distinguishable ? "yes"
                                               : "within its neighbour's spread");
  }
  return out + "</tbody></table>\n";
}

/// About six budgets of round numbers over the front, and what each buys.
std::string answersTable(const AccuracyScene& scene, bool budgets) {
  const auto front = frontOf(scene);
  if (front.empty()) return {};
  const auto value = [&](const AccuracyPoint& point) {
    return budgets ? point.ms.median : point.dssim.median;
  };
  std::vector<double> asked;
  constexpr int kRows = 10;
  const double first = value(budgets ? *front.front() : *front.back());
  const double end = value(budgets ? *front.back() : *front.front());
  for (int i = 0; i < kRows; ++i) {
    const double exact = first * std::pow(end / first, i / (kRows - 1.0));
    // Two digits, upwards: the first and the last configuration are among the answers.
    const double unit = std::pow(10.0, std::floor(std::log10(exact)) - 1.0);
    const double round = std::ceil(exact / unit - 1e-9) * unit;
    if (std::isfinite(round) && (asked.empty() || round > asked.back() * 1.001)) asked.push_back(round);
  }
  std::string out = fmt::format(
      "<table class=\"bench answers\"><thead><tr><th scope=\"col\">{}</th><th "
      "scope=\"col\">Configuration</th><th "
      "scope=\"col\">ms</th><th scope=\"col\">DSSIM</th><th scope=\"col\">PSNR, "
      "dB</th></tr></thead><tbody>\n",
      budgets ? "I have, ms" : "I need, DSSIM");
  const AccuracyPoint* last = nullptr;
  for (const double limit : asked) {
    const auto choice = budgets ? bestWithin(scene.points, limit) : cheapestFor(scene.points, limit);
    if (!choice || choice->point == last) continue;
    const AccuracyPoint& point = *choice->point;
    last = choice->point;
    out += fmt::format(
        "<tr data-point=\"{}\" tabindex=\"0\"><td>{:.4g}</td><th "
        "scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td>"
        "</tr>\n",
        choice->point - scene.points.data(), limit, escapeHtml(point.name), formatDuration(point.ms.median),
        formatFixed(point.dssim.median, 5), formatFixed(point.psnrDb, 2));
  }
  return out + "</tbody></table>\n";
}

std::string sceneSection(const AccuracyScene& scene, std::size_t index) {
  std::string skipped;
  for (const std::string& one : scene.skipped) skipped += "<li>" + escapeHtml(one) + "</li>";
  if (!skipped.empty()) skipped = "<h3>Not measured</h3><ul class=\"facts\">" + skipped + "</ul>\n";
  return fmt::format(
      "<section class=\"scene\" id=\"scene-{0}\" data-scene=\"{0}\">\n<h2>{1}</h2>\n"
      "<p class=\"facts\">{2} triangles · {3} frames of {4} × {5} pixels · {6} · reference: forward, {7} × "
      "{7} samples a "
      "pixel, averaged in linear light</p>\n"
      "<div class=\"front\"></div>\n<div class=\"ask\"></div>\n"
      "<div class=\"answersPair\"><div class=\"scroll\">{8}</div>\n<div class=\"scroll\">{9}</div></div>\n"
      "<h3>Each knob by itself <small>cost and error as chosen above; the large dot is the standard "
      "value</small></h3>\n"
      "<div class=\"charts knobs\"></div>\n"
      "{10}<details><summary>All {11} configurations</summary><div "
      "class=\"scroll\">{12}</div></details>\n</section>\n",
      index, escapeHtml(scene.file), formatCount(static_cast<double>(scene.triangles)), scene.frames,
      scene.width, scene.height, escapeHtml(scene.note), scene.supersampling, answersTable(scene, true),
      answersTable(scene, false), skipped, scene.points.size(), pointsTable(scene));
}

}  // namespace

std::string toHtml(const AccuracyReport& report) {
  Json scenes = Json::array();
  std::string sections;
  for (std::size_t i = 0; i < report.scenes.size(); ++i) {
    const AccuracyScene& scene = report.scenes[i];
    Json points = Json::array();
    for (const AccuracyPoint& point : scene.points) points.push_back(pointData(point));
    Json knobs = Json::array();
    for (const AccuracyKnob& knob : scene.knobs) knobs.push_back(knobData(scene, knob));
    scenes.push_back({{"file", scene.file},
                      {"width", scene.width},
                      {"height", scene.height},
                      {"errorFull", number(scene.errorFull)},
                      {"reference", dataUri(scene.reference)},
                      {"fronts", frontsData(scene)},
                      {"points", std::move(points)},
                      {"knobs", std::move(knobs)}});
    sections += sceneSection(scene, i);
  }
  const std::string context = contextList(report.context);
  const std::string settings = escapeHtml(report.settings);
  const std::string data = scriptData({{"stops", stopsData()}, {"scenes", std::move(scenes)}});
  return fillPage("accuracy.html", {{"title", "what accuracy costs in time"},
                                    {"context", context},
                                    {"settings", settings},
                                    {"scenes", sections},
                                    {"data", data}});
}

}  // namespace tessera
