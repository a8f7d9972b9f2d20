#include "apps/tessera/compare/print.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/tessera/report/report_atlas.hpp"

namespace tessera::app {

namespace {

std::string cell(double value, int decimals) {
  return std::isnan(value) ? std::string("-") : fmt::format("{:.{}f}", value, decimals);
}

std::string share(double value, int decimals = 1) { return cell(100.0 * value, decimals); }

/// Columns as wide as what stands in them, the first aligned to the left.
void printTable(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const auto& row : rows) {
    std::string line = " ";
    for (std::size_t i = 0; i < row.size(); ++i)
      line += i == 0 ? fmt::format(" {:<{}}", row[i], widths[i]) : fmt::format("  {:>{}}", row[i], widths[i]);
    fmt::print("{}\n", line);
  }
}

void printMethods(const ReportScene& scene) {
  std::vector<std::vector<std::string>> rows = {{"method", "MSSIM", "right eye", "by acuity", "PSNR dB",
                                                 "FLIP", "samples", "of a pic. %", "of forward %", "frame ms",
                                                 "levels %", "memory %", "holes"}};
  for (const ReportMethod& m : scene.methods)
    rows.push_back({m.name, cell(m.mssim, 4), cell(mssimOfRightEye(m), 4), cell(m.mssimAcuity, 4),
                    cell(m.psnrDb, 2), cell(m.flip, 4), cell(shadedSamples(m), 0),
                    share(shadedPerTargetPixel(scene, m)), share(shadedAgainstReference(scene, m)),
                    cell(m.frameMs.median, 1), share(passShare(m, "levels"), 2),
                    share(passShare(m, "memory"), 2), cell(m.holes, 0)});
  printTable(rows);
}

void printAtlases(const ReportScene& scene) {
  const std::vector<std::string> kinds = kindNames(scene);
  if (kinds.empty()) return;
  std::vector<std::string> head = {"method",         "gather ms", "ns/sample", "of forward's passed",
                                   "of invocations", "samples"};
  head.insert(head.end(), kinds.begin(), kinds.end());
  for (const char* column : {"slanted %", "DSSIM", "display ms", "of rect's", "texels taken", "wasted %",
                             "decode B/tri", "display B/tri", "bias"})
    head.emplace_back(column);
  std::vector<std::vector<std::string>> rows = {head};
  for (const ReportMethod& m : scene.methods) {
    std::vector<std::string> row = {m.name,
                                    cell(m.gatherMs.median, 1),
                                    cell(m.nsPerSample, 1),
                                    cell(perSampleAgainstPassed(scene, m), 2),
                                    cell(perSampleAgainstInvocation(scene, m), 2),
                                    cell(m.samplesShaded, 0)};
    for (const std::string& kind : kinds) row.push_back(cell(samplesOfKind(m, kind), 0));
    for (const std::string& last :
         {share(m.slantedShare), cell(dssimOf(m), 4),
          m.displayMs.count == 0 ? std::string("-") : cell(m.displayMs.median, 1),
          cell(displayAgainstAtlas(scene, m), 2), cell(m.takenTexels, 0),
          share(wastedTexels(m) / m.takenTexels), cell(decodeBytesPerTriangle(m), 1),
          cell(displayBytesPerTriangle(m), 1), cell(m.constantBias, 2)})
      row.push_back(last);
    rows.push_back(std::move(row));
  }
  printTable(rows);
  for (const ReportMethod& m : scene.methods)
    for (const ReportPacking& packing : m.packings)
      fmt::print("  {}: {} fill {} % of their places\n", m.name, packing.name,
                 share(packing.samples / packing.texels));
}

void printPvs(const ReportScene& scene) {
  if (scene.pvs.empty()) return;
  std::vector<std::vector<std::string>> rows = {{"moving camera", "radius", "degrees", "views", "triangles",
                                                 "samples", "of still %", "DSSIM", "of still %",
                                                 "bias in force", "gather ms", "display ms"}};
  for (const ReportPvsRow& row : scene.pvs) {
    const ReportMethod& m = row.method;
    rows.push_back({row.pvs.method, cell(row.pvs.radius, 2), cell(row.pvs.degrees, 0),
                    fmt::format("{}", row.pvs.views), cell(m.visibleTriangles, 0), cell(m.samplesShaded, 0),
                    share(samplesAgainstPlain(scene, row)), cell(dssimOf(m), 5),
                    share(dssimAgainstPlain(scene, row)), cell(biasInForce(m), 2), cell(m.gatherMs.median, 1),
                    cell(m.displayMs.median, 1)});
  }
  printTable(rows);
}

void printCurves(const ReportScene& scene) {
  for (const ReportMethod& m : scene.methods)
    for (const ReportCurvePoint& point : m.curve)
      fmt::print("  {}, bias {:g}: {:.2f} samples a pixel, MSSIM {:.4f}, gather {:.1f} ms\n", m.name,
                 point.bias, point.samplesPerPixel, point.mssim, point.gatherMs);
  const ReportMethod* reference = methodNamed(scene, scene.atlasReference);
  if (reference == nullptr || reference->curve.empty()) return;
  const double samples = shadedPerTargetPixel(scene, *reference);
  for (const ReportMethod& m : scene.methods) {
    if (m.curve.empty() || &m == reference) continue;
    fmt::print("  {}: MSSIM {} at {}'s {:.2f} samples a pixel ({:.4f}); {} samples a pixel at its MSSIM\n",
               m.name, cell(curveMssimAt(m, samples), 4), reference->name, samples, reference->mssim,
               cell(curveSamplesAt(m, reference->mssim), 2));
  }
}

void printCrops(const ReportScene& scene) {
  for (const ReportCrop& crop : scene.crops) {
    std::string line = fmt::format("  crop of frame {}, {} x {} at ({}, {}), {} % slanted: MSSIM", crop.frame,
                                   crop.width, crop.height, crop.x, crop.y, share(crop.slantedShare));
    for (const ReportCrop::Picture& picture : crop.pictures)
      if (picture.method != scene.methods.front().name)
        line += fmt::format(" {} {:.4f}", picture.method, picture.mssim);
    fmt::print("{}\n", line);
  }
}

}  // namespace

void printSummary(const ReportScene& scene) {
  fmt::print("{} ({} triangles, {} frames of {} x {})\n", scene.file, scene.triangles, scene.frames,
             scene.width, scene.height);
  printMethods(scene);
  printAtlases(scene);
  printPvs(scene);
  printCurves(scene);
  printCrops(scene);
}

}  // namespace tessera::app
