#include "apps/tessera/study/print.hpp"

#include <fmt/core.h>

namespace tessera::app {

namespace {

void printFigure(const StudyScene& scene, const char* title, std::vector<StudyPoint> StudyMethod::*figure,
                 double StudyPoint::*axis) {
  if (scene.methods.empty() || (scene.methods.front().*figure).empty()) return;
  fmt::print("  {:<28}", title);
  for (const StudyPoint& point : scene.methods.front().*figure) fmt::print(" {:>8.4g}", point.*axis);
  fmt::print("\n");
  for (const StudyMethod& method : scene.methods) {
    fmt::print("    {:<26}", method.name);
    for (const StudyPoint& point : method.*figure) fmt::print(" {:>8.4f}", point.mssim);
    fmt::print("\n");
  }
}

void printTimeline(const StudyTimeline& timeline) {
  if (!timeline.failed.empty()) {
    fmt::print("  no time line: {}\n", timeline.failed);
    return;
  }
  if (timeline.viewer.empty()) return;
  fmt::print("  two processes, {}: {:.1f} ms from pose to picture (median):", timeline.method,
             timeline.totalMs);
  for (const StudyStage& stage : timeline.viewer) fmt::print(" {} {:.1f}", stage.name, stage.ms);
  fmt::print("\n    of the server:");
  for (const StudyStage& stage : timeline.server) fmt::print(" {} {:.1f}", stage.name, stage.ms);
  fmt::print("\n");
}

}  // namespace

void printStudy(const StudyScene& scene) {
  fmt::print("{}: {} x {}, {}, {} samples over {:.2f} s, camera {:.2f} m/s and {:.1f} degrees/s\n",
             scene.file, scene.width, scene.height, scene.note, scene.samples, scene.seconds,
             scene.metresPerSecond, scene.degreesPerSecond);
  printFigure(scene, "MSSIM by latency, ms", &StudyMethod::byLatency, &StudyPoint::latencyMs);
  printFigure(scene, "MSSIM by server rate, Hz", &StudyMethod::byRate, &StudyPoint::serverHz);
  printFigure(scene, "MSSIM by bitrate, Mbit/s", &StudyMethod::byBitrate, &StudyPoint::mbit);
  printTimeline(scene.timeline);
  for (const StudyFinding& finding : findingsOf(scene))
    fmt::print("  {}{}\n", finding.goal ? (finding.reached ? "[reached] " : "[MISSED] ") : "", finding.text);
  std::fflush(stdout);
}

}  // namespace tessera::app
