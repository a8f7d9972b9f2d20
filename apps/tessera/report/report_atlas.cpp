#include "apps/tessera/report/report_atlas.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/tessera/report/report_json.hpp"
#include "apps/tessera/report/report_table.hpp"

namespace tessera {

using Json = nlohmann::ordered_json;

std::vector<std::string> kindNames(const ReportScene& scene) {
  std::vector<std::string> names;
  for (const ReportMethod& method : scene.methods)
    for (const ReportKind& kind : method.kinds)
      if (std::find(names.begin(), names.end(), kind.name) == names.end()) names.push_back(kind.name);
  return names;
}

double samplesOfKind(const ReportMethod& method, const std::string& kind) {
  for (const ReportKind& own : method.kinds)
    if (own.name == kind) return own.samples;
  return kNotMeasured;
}

Json atlasJson(const ReportScene& scene, const ReportMethod& m) {
  Json kinds = Json::array();
  for (const ReportKind& kind : m.kinds)
    kinds.push_back({{"name", kind.name}, {"samples", number(kind.samples)}});
  Json packings = Json::array();
  for (const ReportPacking& packing : m.packings)
    packings.push_back({{"name", packing.name},
                        {"samples", number(packing.samples)},
                        {"texels", number(packing.texels)},
                        {"filled", number(packing.samples / packing.texels)}});
  Json curve = Json::array();
  for (const ReportCurvePoint& point : m.curve)
    curve.push_back({{"bias", number(point.bias)},
                     {"samples_per_pixel", number(point.samplesPerPixel)},
                     {"mssim", number(point.mssim)},
                     {"gather_ms", number(point.gatherMs)}});
  return {{"kinds", std::move(kinds)},
          {"packings", std::move(packings)},
          {"slanted_share", number(m.slantedShare)},
          {"atlas_texels_taken", number(m.takenTexels)},
          {"atlas_texels_wasted", number(wastedTexels(m))},
          {"decode_bytes_per_triangle", number(decodeBytesPerTriangle(m))},
          {"display_bytes_per_triangle", number(displayBytesPerTriangle(m))},
          {"per_sample_against_passed", number(perSampleAgainstPassed(scene, m))},
          {"per_sample_against_invocation", number(perSampleAgainstInvocation(scene, m))},
          {"display_against_rect", number(displayAgainstAtlas(scene, m))},
          {"constant_bias", number(m.constantBias)},
          {"bias_in_force", number(biasInForce(m))},
          {"equal_samples", number(m.equalSamples)},
          {"curve", std::move(curve)}};
}

Json pvsJson(const ReportScene& scene, const ReportPvsRow& row) {
  return {{"of", row.pvs.method},
          {"radius", number(row.pvs.radius)},
          {"degrees", number(row.pvs.degrees)},
          {"pvs_views", row.pvs.views},
          {"samples_against_still", number(samplesAgainstPlain(scene, row))},
          {"dssim_against_still", number(dssimAgainstPlain(scene, row))}};
}

Json cropsJson(const ReportScene& scene) {
  Json crops = Json::array();
  for (const ReportCrop& crop : scene.crops) {
    Json pictures = Json::array();
    for (const ReportCrop::Picture& picture : crop.pictures)
      pictures.push_back({{"method", picture.method}, {"mssim", number(picture.mssim)}});
    crops.push_back({{"frame", crop.frame},
                     {"at", {crop.x, crop.y}},
                     {"size", {crop.width, crop.height}},
                     {"slanted_share", number(crop.slantedShare)},
                     {"pictures", std::move(pictures)}});
  }
  return crops;
}

namespace {

using Cells = std::vector<std::string>;

std::string times(double quotient) {
  return std::isfinite(quotient) ? formatFixed(quotient, 2) + " ×" : kDash;
}

std::string median(const Statistics& ms) { return ms.count == 0 ? kDash : formatDuration(ms.median); }

/// A table with a heading; the first cell of a row is its name. Empty without rows.
std::string table(std::string_view title, std::string_view text, const Cells& head,
                  const std::vector<Cells>& rows) {
  if (rows.empty()) return {};
  std::string out = fmt::format(
      "<h3>{}</h3><p class=\"facts\">{}</p>\n<div class=\"scroll\"><table "
      "class=\"summary atlas\"><thead><tr>",
      title, text);
  for (const std::string& cell : head) out += fmt::format("<th scope=\"col\">{}</th>", cell);
  out += "</tr></thead><tbody>\n";
  for (const Cells& row : rows) {
    out += fmt::format("<tr><th scope=\"row\">{}</th>", row.front());
    for (std::size_t i = 1; i < row.size(); ++i) out += "<td>" + row[i] + "</td>";
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string workTable(const ReportScene& scene) {
  const std::vector<std::string> kinds = kindNames(scene);
  if (kinds.empty()) return {};
  Cells head = {"Method",
                "Gather, ms",
                "Shading a sample, ns",
                "of forward’s that pass depth",
                "of forward’s invocations",
                "Samples a frame"};
  for (const std::string& kind : kinds) head.push_back(escapeHtml(kind));
  for (const char* column : {"Triangles sampled as slanted", "DSSIM"}) head.emplace_back(column);
  std::vector<Cells> rows;
  for (const ReportMethod& m : scene.methods) {
    Cells row = {escapeHtml(m.name),
                 median(m.gatherMs),
                 formatDuration(std::isnan(m.nsPerPassed) ? m.nsPerSample : m.nsPerPassed),
                 times(perSampleAgainstPassed(scene, m)),
                 times(perSampleAgainstInvocation(scene, m)),
                 formatCount(shadedSamples(m))};
    for (const std::string& kind : kinds) row.push_back(formatCount(samplesOfKind(m, kind)));
    row.push_back(formatShare(m.slantedShare));
    row.push_back(formatFixed(dssimOf(m), 4));
    rows.push_back(std::move(row));
  }
  return table("What samples cost",
               "After tables 2 to 4 of Hladky et al. 2019. Times are medians, counts are means of a frame.",
               head, rows);
}

std::string placeTable(const ReportScene& scene) {
  std::vector<Cells> rows;
  for (const ReportMethod& m : scene.methods) {
    if (m.kinds.empty()) continue;
    std::string packed;
    for (const ReportPacking& packing : m.packings)
      packed += fmt::format("{}{} {}", packed.empty() ? "" : ", ", escapeHtml(packing.name),
                            formatShare(packing.samples / packing.texels));
    std::string bias = formatFixed(m.constantBias, 2);
    if (!std::isnan(m.equalSamples))
      bias += fmt::format(" <small>for {} of {}’s samples</small>", formatShare(m.equalSamples),
                          escapeHtml(scene.atlasReference));
    rows.push_back({escapeHtml(m.name), median(m.displayMs), times(displayAgainstAtlas(scene, m)),
                    formatFixed(decodeBytesPerTriangle(m), 1), formatFixed(displayBytesPerTriangle(m), 1),
                    formatCount(m.takenTexels), formatCount(wastedTexels(m)),
                    formatShare(wastedTexels(m) / m.takenTexels),
                    packed.empty() ? std::string(kDash) : packed, bias});
  }
  return table(
      "What atlases hold, and display reads",
      "Texels are taken where they are not free for places of any size; free places of one size, which the "
      "next triangle of that size gets, are taken and without a sample.",
      {"Method", "Display, ms", "of rect’s", "Bytes a triangle that say where its texels are",
       "all that display reads", "Atlas texels taken", "without a sample", "of those taken",
       "Samples in the places of what is visible", "Bias asked for"},
      rows);
}

std::string pvsTable(const ReportScene& scene) {
  std::vector<Cells> rows;
  const std::vector<std::string> kinds = kindNames(scene);
  for (const ReportPvsRow& row : scene.pvs) {
    const ReportMethod& m = row.method;
    Cells cells = {escapeHtml(row.pvs.method),   fmt::format("{:g}, {:g}°", row.pvs.radius, row.pvs.degrees),
                   formatCount(row.pvs.views),   formatCount(m.visibleTriangles),
                   formatCount(m.samplesShaded), formatShare(samplesAgainstPlain(scene, row))};
    for (const std::string& kind : kinds) cells.push_back(formatCount(samplesOfKind(m, kind)));
    for (const std::string& cell :
         {median(m.gatherMs), median(m.displayMs), formatFixed(dssimOf(m), 5),
          formatShare(dssimAgainstPlain(scene, row)), formatFixed(biasInForce(m), 2)})
      cells.push_back(cell);
    rows.push_back(std::move(cells));
  }
  Cells head = {"Method",          "Camera moves, turns",          "Views sampled", "Visible triangles",
                "Samples a frame", "of a camera that stands still"};
  for (const std::string& kind : kinds) head.push_back(escapeHtml(kind));
  for (const char* column :
       {"Gather, ms", "Display, ms", "DSSIM", "of a camera that stands still", "Bias in force"})
    head.emplace_back(column);
  return table(
      "Visible sets of a camera that moves",
      "The visible set is the union of views from a ball around the camera, turned to all sides; the picture "
      "is the camera’s own. More samples are expected, another quality is not, unless the atlas is full "
      "(a bias in force).",
      head, rows);
}

std::string curveTable(const ReportScene& scene) {
  const ReportMethod* reference = methodNamed(scene, scene.atlasReference);
  std::vector<Cells> rows;
  if (reference == nullptr) return {};
  const double samples = shadedPerTargetPixel(scene, *reference);
  for (const ReportMethod& m : scene.methods) {
    if (m.curve.empty()) continue;
    const bool own = &m == reference;
    const double cost = own ? samples : curveSamplesAt(m, reference->mssim);
    rows.push_back({escapeHtml(m.name), formatFixed(own ? m.mssim : curveMssimAt(m, samples), 4),
                    formatFixed(cost, 2), times(cost / samples)});
  }
  const std::string name = escapeHtml(reference->name);
  return table(
      "Same samples, same quality",
      fmt::format(
          "Read off the curves of samples against quality. A dash: beyond the biases that were drawn."),
      {"Method", fmt::format("MSSIM at {}’s {} samples a pixel", name, formatFixed(samples, 2)),
       fmt::format("Samples a pixel at {}’s MSSIM {}", name, formatFixed(reference->mssim, 4)),
       fmt::format("of {}’s", name)},
      rows);
}

}  // namespace

std::string atlasTables(const ReportScene& scene) {
  return workTable(scene) + placeTable(scene) + pvsTable(scene) + curveTable(scene);
}

}  // namespace tessera
