#include "apps/tessera/report/pvs_report.hpp"

#include <algorithm>

namespace tessera {

PvsSummary summarize(const PvsRun& run) {
  PvsSummary summary;
  const auto valuesOf = [&](double PvsFrame::*field) {
    std::vector<double> values;
    for (const PvsFrame& frame : run.frames) values.push_back(frame.*field);
    return summarize(values);
  };
  const Statistics coverage = valuesOf(&PvsFrame::coverage);
  const Statistics overestimation = valuesOf(&PvsFrame::overestimation);
  summary.coverage = coverage.mean;
  summary.coverageWorst = coverage.min;
  summary.overestimation = overestimation.mean;
  summary.overestimationWorst = overestimation.max;
  summary.missedPixels = valuesOf(&PvsFrame::missedPixels).mean;
  summary.elements = valuesOf(&PvsFrame::elements).mean;
  summary.neededElements = valuesOf(&PvsFrame::neededElements).mean;
  summary.ms = valuesOf(&PvsFrame::ms);
  return summary;
}

}  // namespace tessera
