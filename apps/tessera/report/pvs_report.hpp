// The report of pvs: how well predicted visible sets fit what is shown, as pvs.json and as one self-contained
// page.
#pragma once

#include <string>
#include <vector>

#include "apps/tessera/report/report.hpp"

namespace tessera {

/// One frame's potentially visible set. Pixels are means over the views that are shown while it holds.
struct PvsFrame {
  double time = 0.0;            // of the path, seconds
  double coverage = 1.0;        // share of the shown pixels whose element is in the set
  double overestimation = 0.0;  // pixels of elements that no shown view has, of the shown pixels
  double missedPixels = 0.0;    // of elements that are not in the set
  double elements = 0.0;        // in the set
  double neededElements = 0.0;  // that the shown views show
  double ms = 0.0;              // id passes and marking of all views of the set
};

/// One way to predict, over all frames.
struct PvsRun {
  std::string name;  // "linear, margin 1°, 4 steps"
  std::string prediction;
  double marginDegrees = 0.0;
  int steps = 0;
  int views = 0;   // of a set
  int width = 0;   // of the first frame's, pixels, margin included
  int height = 0;  // pixels
  std::vector<PvsFrame> frames;
};

/// What a run comes to: means over the frames, and the worst of them.
struct PvsSummary {
  double coverage = kNotMeasured;
  double coverageWorst = kNotMeasured;
  double overestimation = kNotMeasured;
  double overestimationWorst = kNotMeasured;
  double missedPixels = kNotMeasured;
  double elements = kNotMeasured;
  double neededElements = kNotMeasured;
  Statistics ms;
};
PvsSummary summarize(const PvsRun& run);

struct PvsScene {
  std::string scene;
  std::string path;     // the camera path's name, or "none", and how it was changed
  std::string element;  // "patch" or "triangle"
  int width = 0;        // of the shown views, pixels
  int height = 0;
  double rate = 0.0;       // shown views a second
  double latencyMs = 0.0;  // from the first to the last view that a set is for
  int shownViews = 0;
  Statistics idMs;  // of one shown view's id pass and marking
  std::vector<PvsRun> runs;
};

struct PvsReport {
  ReportContext context;
  std::vector<PvsScene> scenes;
};

/// pvs.json: a scene has its runs, a run its summary and its series frame by frame.
std::string toJson(const PvsReport& report);
/// The page: no request leaves it, opens from a file.
std::string toHtml(const PvsReport& report);

}  // namespace tessera
