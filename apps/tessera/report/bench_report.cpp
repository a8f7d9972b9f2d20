#include "apps/tessera/report/bench_report.hpp"

namespace tessera {

BenchSummary summarize(const BenchRun& run) {
  BenchSummary summary;
  summary.frames = run.frames.size();
  double liveShare = 0.0;
  double stayed = 0.0;
  double kept = 0.0;
  double live = 0.0;
  double moved = 0.0;
  double liveOutside = 0.0;
  double movedOutside = 0.0;
  double bias = 0.0;
  std::vector<double> times;
  for (const BenchFrame& frame : run.frames) {
    summary.oomFrames += frame.failures > 0.0 ? 1 : 0;
    summary.failures += frame.failures;
    summary.reduced += frame.reduced;
    summary.resets += frame.reset ? 1 : 0;
    liveShare += frame.live / (frame.live + frame.end + frame.stack + frame.inaccessible + frame.free);
    stayed += frame.stayed;
    kept += frame.kept;
    live += frame.live;
    moved += frame.movedTexels;
    if (!frame.reset) {
      liveOutside += frame.live;
      movedOutside += frame.movedTexels;
    }
    bias += frame.bias;
    if (&frame != &run.frames.front()) times.push_back(frame.ms);
  }
  const auto frames = static_cast<double>(run.frames.size());
  const auto share = [](double part, double whole) { return whole > 0.0 ? part / whole : kNotMeasured; };
  summary.liveShare = share(liveShare, frames);
  summary.keptPlace = share(kept, stayed);
  summary.movedShare = share(moved, live);
  summary.movedShareOutsideResets = share(movedOutside, liveOutside);
  summary.bias = frames > 0.0 ? bias / frames : kNotMeasured;
  summary.ms = summarize(times);
  return summary;
}

}  // namespace tessera
