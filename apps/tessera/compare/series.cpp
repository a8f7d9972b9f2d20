#include "apps/tessera/compare/series.hpp"

#include "apps/tessera/compare/quality.hpp"

namespace tessera::app {

namespace {

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? kNotMeasured : sum / static_cast<double>(values.size());
}

bool isShading(const std::string& pass) { return pass == "gather" || pass == "forward"; }
bool isDisplay(const std::string& pass) {
  return pass.rfind("display", 0) == 0 || pass.rfind("upsample", 0) == 0 || pass == "rect-transparent" ||
         pass == "warp" || pass == "distort";
}

}  // namespace

std::vector<PassTime> medianTimes(const std::vector<std::vector<PassTime>>& runs) {
  std::vector<PassTime> medians = runs.front();
  for (PassTime& median : medians) {
    std::vector<double> samples;
    for (const auto& run : runs)
      for (const PassTime& time : run)
        if (time.name == median.name) samples.push_back(time.milliseconds);
    median.milliseconds = summarize(samples).median;
  }
  return medians;
}

void record(Series& series, const std::vector<PassTime>& times, std::uint64_t shaded) {
  double total = 0.0;
  double shading = 0.0;
  double display = 0.0;
  for (const PassTime& time : times) {
    if (series.passes.find(time.name) == series.passes.end()) series.passOrder.push_back(time.name);
    series.passes[time.name].push_back(time.milliseconds);
    total += time.milliseconds;
    if (isShading(time.name)) shading += time.milliseconds;
    if (isDisplay(time.name)) display += time.milliseconds;
  }
  series.frameMs.push_back(total);
  series.gatherMs.push_back(shading);
  if (display > 0.0) series.displayMs.push_back(display);
  series.samples.push_back(static_cast<double>(shaded));
  if (shaded > 0) series.nsPerSample.push_back(shading * 1e6 / static_cast<double>(shaded));
}

ReportMethod reportOf(const Method& method, Series series) {
  ReportMethod report;
  report.name = method.name;
  report.reference = referenceOf(method);
  report.views = method.isStereo() ? 2 : 1;
  report.mssim = mean(series.mssim);
  for (const auto& view : series.mssimViews) report.mssimViews.push_back(mean(view));
  report.mssimAcuity = mean(series.mssimAcuity);
  report.psnrDb = pooledPsnr(series.psnr);
  report.flip = mean(series.flip);
  report.samplesShaded = mean(series.samples);
  report.invocations = mean(series.invocations);
  report.samplesPassed = mean(series.passed);
  report.nsPerPassed = summarize(series.nsPerPassed).median;
  report.coveredPixels = mean(series.covered);
  report.holes = series.holes;
  if (method.usesAtlas()) {
    report.samplesAllocated = mean(series.allocated);
    report.samplesPartlyInView = mean(series.partly);
    report.atlasTexelsUsed = mean(series.live);
    report.visiblePatches = mean(series.patches);
    report.visibleTriangles = mean(series.triangles);
    report.outOfMemory = series.outOfMemory;
    report.resets = series.resets;
    report.nonFiniteTexels = series.nonFinite;
  }
  for (const std::string& name : series.passOrder)
    report.passes.push_back({name, summarize(series.passes[name])});
  report.frameMs = summarize(series.frameMs);
  report.gatherMs = summarize(series.gatherMs);
  report.displayMs = summarize(series.displayMs);
  report.nsPerSample = summarize(series.nsPerSample).median;
  report.series = {series.frameMs, series.mssim, series.flip, series.samples, series.live, series.bias};
  report.frames = std::move(series.pictures);
  return report;
}

}  // namespace tessera::app
