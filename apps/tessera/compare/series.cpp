#include "apps/tessera/compare/series.hpp"

#include <fmt/format.h>

#include "apps/tessera/compare/quality.hpp"

namespace tessera::app {

namespace {

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? kNotMeasured : sum / static_cast<double>(values.size());
}

double mean(const std::vector<GatherStatistics>& frames, std::uint64_t GatherStatistics::*count) {
  std::vector<double> values;
  for (const GatherStatistics& frame : frames) values.push_back(static_cast<double>(frame.*count));
  return mean(values);
}

/// Means over the frames. What a frame has none of may be absent from it.
void describeSamples(const std::vector<GatherStatistics>& frames, ReportMethod& report) {
  const auto add = [](auto& list, const std::string& name) -> auto& {
    for (auto& item : list)
      if (item.name == name) return item;
    list.emplace_back().name = name;
    return list.back();
  };
  const auto count = static_cast<double>(frames.size());
  for (const GatherStatistics& frame : frames) {
    for (const GatherKind& kind : frame.kinds) {
      ReportKind& mean = add(report.kinds, kind.name);
      mean.color = fmt::format("#{:02x}{:02x}{:02x}", kind.color[0], kind.color[1], kind.color[2]);
      mean.samples += static_cast<double>(kind.samples) / count;
    }
    for (const GatherPacking& packing : frame.packings) {
      ReportPacking& mean = add(report.packings, packing.name);
      mean.samples += static_cast<double>(packing.samples) / count;
      mean.texels += static_cast<double>(packing.texels) / count;
    }
  }
  std::vector<double> shares;
  for (const GatherStatistics& frame : frames)
    if (frame.slanted && frame.visible > 0)
      shares.push_back(static_cast<double>(*frame.slanted) / static_cast<double>(frame.visible));
  report.slantedShare = mean(shares);
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
    report.samplesAllocated = mean(series.gathered, &GatherStatistics::samples);
    report.samplesPartlyInView = mean(series.partly);
    report.atlasTexelsUsed = mean(series.gathered, &GatherStatistics::liveTexels);
    report.takenTexels = mean(series.gathered, &GatherStatistics::usedTexels);
    report.displayBytes = mean(series.gathered, &GatherStatistics::displayBytes);
    report.decodeBytes = mean(series.gathered, &GatherStatistics::decodeBytes);
    report.constantBias = method.atlas.bias;
    report.equalSamples = method.equalSamples;
    describeSamples(series.gathered, report);
    report.kindPicture = std::move(series.kindPicture);
    report.visiblePatches = mean(series.gathered, &GatherStatistics::visible);
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
  std::vector<double> live;
  for (const GatherStatistics& frame : series.gathered) live.push_back(static_cast<double>(frame.liveTexels));
  report.series = {series.frameMs, series.mssim, series.flip, series.samples, live, series.bias};
  report.frames = std::move(series.pictures);
  return report;
}

}  // namespace tessera::app
