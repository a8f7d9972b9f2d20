#include "apps/tessera/report/report_table.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "engine/measure/metrics.hpp"

namespace tessera {

std::string formatFixed(double value, int decimals) {
  if (std::isnan(value)) return kDash;
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  return fmt::format("{:.{}f}", value, decimals);
}

std::string formatDuration(double value) {
  const double size = std::abs(value);
  return formatFixed(value, size >= 100 ? 0 : size >= 10 ? 1 : size >= 0.1 ? 2 : 3);
}

std::string timingCell(const Statistics& ms) {
  if (ms.count == 0) return kDash;
  return fmt::format("{} <small>p95 {}</small>", formatDuration(ms.median), formatDuration(ms.p95));
}

namespace {

std::string ratio(double value, double reference) {
  const double quotient = value / reference;
  return std::isfinite(quotient) ? formatFixed(quotient, 2) + " ×" : kDash;
}

struct Row {
  std::string label;  // HTML
  std::string hint;   // HTML, shown small beside the label
  std::function<std::string(const ReportMethod&)> cell;
};

/// Rows of one group; those in which no method has a value are left out, and so is a group without rows.
std::string group(const ReportScene& scene, std::string_view title, const std::vector<Row>& rows) {
  std::string body;
  for (const Row& row : rows) {
    std::string line = fmt::format("<tr><th scope=\"row\">{} <small>{}</small></th>", row.label, row.hint);
    bool any = false;
    for (const ReportMethod& method : scene.methods) {
      const std::string cell = row.cell(method);
      any = any || cell != kDash;
      line += "<td>" + cell + "</td>";
    }
    if (any) body += line + "</tr>\n";
  }
  if (body.empty()) return {};
  return fmt::format(
      "<tbody><tr class=\"group\"><th scope=\"rowgroup\" colspan=\"{}\">{}</th></tr>\n{}</tbody>\n",
      scene.methods.size() + 1, title, body);
}

Row countRow(std::string label, std::string hint, double ReportMethod::*value) {
  return {std::move(label), std::move(hint),
          [value](const ReportMethod& m) { return formatCount(m.*value); }};
}

Row fixedRow(std::string label, std::string hint, double ReportMethod::*value, int decimals) {
  return {std::move(label), std::move(hint),
          [value, decimals](const ReportMethod& m) { return formatFixed(m.*value, decimals); }};
}

Row timingRow(std::string label, std::string hint, Statistics ReportMethod::*value) {
  return {std::move(label), std::move(hint), [value](const ReportMethod& m) { return timingCell(m.*value); }};
}

double samplesPerPixel(const ReportMethod& m) { return m.samplesShaded / m.coveredPixels; }

/// One row per pass that any method ran, in the order of first appearance.
std::vector<Row> passRows(const ReportScene& scene) {
  std::vector<std::string> names;
  for (const ReportMethod& method : scene.methods)
    for (const ReportPass& pass : method.passes)
      if (std::find(names.begin(), names.end(), pass.name) == names.end()) names.push_back(pass.name);
  std::vector<Row> rows;
  rows.reserve(names.size());
  for (const std::string& name : names)
    rows.push_back({escapeHtml(name), "", [name](const ReportMethod& m) -> std::string {
                      for (const ReportPass& pass : m.passes)
                        if (pass.name == name) return timingCell(pass.ms);
                      return kDash;
                    }});
  return rows;
}

}  // namespace

std::string escapeHtml(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string formatShare(double value, int decimals) {
  return std::isfinite(value) ? formatFixed(100.0 * value, decimals) + " %" : kDash;
}

std::string formatCount(double value) {
  std::string digits = formatFixed(value, 0);
  if (!std::isfinite(value)) return digits;
  const auto first = static_cast<std::ptrdiff_t>(digits.front() == '-');
  for (auto place = static_cast<std::ptrdiff_t>(digits.size()) - 3; place > first; place -= 3)
    digits.insert(digits.begin() + place, ',');
  return digits;
}

std::string methodTable(const ReportScene& scene) {
  std::string out = "<table class=\"methods\"><thead><tr><td></td>";
  for (const ReportMethod& method : scene.methods)
    out += fmt::format("<th scope=\"col\"><i class=\"swatch\" data-method=\"{}\"></i>{}</th>",
                       &method - scene.methods.data(), escapeHtml(method.name));
  out += "</tr></thead>\n";
  out += group(scene, "Pictures against forward",
               {fixedRow("MSSIM", "1 is equal", &ReportMethod::mssim, 4),
                {"MSSIM", "left and right eye",
                 [](const ReportMethod& m) {
                   return m.mssimViews.size() < 2
                              ? std::string(kDash)
                              : formatFixed(m.mssimViews[0], 4) + " · " + formatFixed(m.mssimViews[1], 4);
                 }},
                fixedRow("MSSIM by acuity", "foveated", &ReportMethod::mssimAcuity, 4),
                {"DSSIM", "0 is equal", [](const ReportMethod& m) { return formatFixed(dssim(m.mssim), 4); }},
                fixedRow("PSNR", "dB", &ReportMethod::psnrDb, 2),
                fixedRow("FLIP", "0 is equal", &ReportMethod::flip, 4),
                countRow("Holes", "pixels, all frames", &ReportMethod::holes)});
  out += group(scene, "Work per frame",
               {countRow("Samples shaded", "", &ReportMethod::samplesShaded),
                countRow("Samples allocated", "", &ReportMethod::samplesAllocated),
                {"Samples shaded", "of a picture's pixels",
                 [&](const ReportMethod& m) { return formatShare(shadedPerTargetPixel(scene, m)); }},
                {"Samples shaded", "of all pictures' pixels",
                 [&](const ReportMethod& m) { return formatShare(shadedPerPicturePixel(scene, m)); }},
                {"Samples shaded", "of forward's",
                 [&](const ReportMethod& m) { return formatShare(shadedAgainstReference(scene, m)); }},
                countRow("Fragment-shader invocations", "as GL counts them", &ReportMethod::invocations),
                {"Samples shaded per covered pixel", "",
                 [](const ReportMethod& m) { return formatFixed(samplesPerPixel(m), 2); }},
                countRow("Covered pixels", "", &ReportMethod::coveredPixels),
                countRow("Visible patches", "", &ReportMethod::visiblePatches),
                countRow("Visible triangles", "", &ReportMethod::visibleTriangles)});
  out += group(scene, "Atlas",
               {countRow("Texels used", "per frame", &ReportMethod::atlasTexelsUsed),
                {"Level selection", "of the frame",
                 [](const ReportMethod& m) { return formatShare(passShare(m, "levels"), 2); }},
                {"Memory", "request, provision, assign, plan, merge; of the frame",
                 [](const ReportMethod& m) { return formatShare(passShare(m, "memory"), 2); }},
                countRow("Out of memory", "patches, all frames", &ReportMethod::outOfMemory),
                countRow("Resets", "all frames", &ReportMethod::resets),
                countRow("Non-finite texels", "all frames", &ReportMethod::nonFiniteTexels)});
  const auto against = [&](const ReportMethod& m, const auto& number) {
    const ReportMethod* reference = referenceOf(scene, m);
    return reference == nullptr ? std::string(kDash) : ratio(number(m), number(*reference));
  };
  const auto frameMs = [](const ReportMethod& m) { return m.frameMs.median; };
  const auto perSample = [](const ReportMethod& m) { return m.nsPerSample; };
  out += group(
      scene, "Time, median",
      {timingRow("Frame", "ms", &ReportMethod::frameMs),
       {"Frame against forward", "", [=](const ReportMethod& m) { return against(m, frameMs); }},
       timingRow("Gather and shade", "ms", &ReportMethod::gatherMs),
       timingRow("Display", "ms", &ReportMethod::displayMs),
       {"Shading per sample", "ns", [](const ReportMethod& m) { return formatDuration(m.nsPerSample); }},
       {"Shading per sample that passed depth", "ns",
        [](const ReportMethod& m) { return formatDuration(m.nsPerPassed); }},
       {"Shading per sample against forward", "",
        [=](const ReportMethod& m) { return against(m, perSample); }}});
  out += group(scene, "Time of each pass, median, ms", passRows(scene));
  return out + "</table>\n";
}

std::string summaryTable(const Report& report) {
  std::string out =
      "<table class=\"summary\"><thead><tr><th scope=\"col\">Scene</th><th scope=\"col\">Method</th>"
      "<th scope=\"col\">MSSIM</th><th scope=\"col\">FLIP</th><th scope=\"col\">Samples per covered "
      "pixel</th>"
      "<th scope=\"col\">Frame, ms</th><th scope=\"col\">against forward</th>"
      "<th scope=\"col\">Shading per sample, ns</th><th scope=\"col\">against forward</th></tr></thead>\n";
  for (std::size_t s = 0; s < report.scenes.size(); ++s) {
    const ReportScene& scene = report.scenes[s];
    out += "<tbody>\n";
    for (const ReportMethod& m : scene.methods) {
      const ReportMethod* forward = referenceOf(scene, m);
      out += "<tr>";
      if (&m == scene.methods.data())
        out += fmt::format(
            "<th scope=\"rowgroup\" rowspan=\"{0}\" title=\"{2}\"><a href=\"#scene-{1}\">{2}</a></th>",
            scene.methods.size(), s, escapeHtml(scene.file));
      out += fmt::format(
          "<th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
          "<td>{}</td></tr>\n",
          escapeHtml(m.name), formatFixed(m.mssim, 4), formatFixed(m.flip, 4),
          formatFixed(samplesPerPixel(m), 2), formatDuration(m.frameMs.median),
          ratio(m.frameMs.median, forward != nullptr ? forward->frameMs.median : kNotMeasured),
          formatDuration(m.nsPerSample),
          ratio(m.nsPerSample, forward != nullptr ? forward->nsPerSample : kNotMeasured));
    }
    out += "</tbody>\n";
  }
  return out + "</table>\n";
}

}  // namespace tessera
