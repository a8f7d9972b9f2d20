// Everything measured of one method, and what the report says of it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "apps/tessera/compare/method.hpp"
#include "apps/tessera/report/report.hpp"
#include "engine/frame/engine.hpp"

namespace tessera::app {

/// Everything measured of one method, frame by frame.
struct Series {
  std::map<std::string, std::vector<double>> passes;
  std::vector<std::string> passOrder;
  std::vector<double> frameMs, gatherMs, displayMs, nsPerSample;
  std::vector<double> nsPerPassed, passed, partly;
  std::vector<double> invocations, mssimAcuity;
  std::vector<std::vector<double>> mssimViews;  // by eye, then frame
  std::vector<GatherStatistics> gathered;
  std::vector<double> mssim, psnr, flip, samples, triangles, covered, bias;
  double outOfMemory = 0.0;
  double resets = 0.0;
  double holes = 0.0;
  double nonFinite = kNotMeasured;
  std::vector<ReportFrame> pictures;
  std::vector<std::uint8_t> kindPicture;
};

/// Median over the repeats of each pass, in the order of the first run. By name: a repeat of the same moment
/// keeps the shadow map, and so has one pass less.
std::vector<PassTime> medianTimes(const std::vector<std::vector<PassTime>>& runs);
/// Adds a frame's times and the samples that it shaded.
void record(Series& series, const std::vector<PassTime>& times, std::uint64_t shaded);
ReportMethod reportOf(const Method& method, Series series);

}  // namespace tessera::app
