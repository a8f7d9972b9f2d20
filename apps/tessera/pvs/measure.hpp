// Potentially visible sets along a recorded path, against what the path's views then show.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "apps/tessera/report/pvs_report.hpp"
#include "engine/frame/engine.hpp"

namespace tessera::app {

/// When and what is measured.
struct PvsSampling {
  int frames = 60;         // sets, evenly along the path
  double rate = 120.0;     // poses, and shown views, a second
  double latency = 0.033;  // seconds; views are shown from the present to the multiple of 1/rate next to it
  /// Shown views of a set, the present one first.
  [[nodiscard]] std::size_t shownViews() const;
};

/// Which of a path's poses a set is made at: evenly from the second pose, since motion takes two, to the last
/// that `shownViews` begin at; at most `frames`. Empty where the path is too short.
std::vector<std::size_t> presentPoses(std::size_t poses, std::size_t shownViews, std::size_t frames);

/// "linear, margin 1°, 4 steps".
std::string nameOf(const PvsOptions& options);
/// "none", "linear", "reference".
std::string nameOf(Prediction prediction);

/// Measures every way to predict on one path of poses at the sampling's rate. The sets are of the engine's
/// elements: patches, or triangles with the tessellation gatherer; its scene must have been updated once.
/// `step` is called after each of the frames. Fails where a view cannot be widened or the path is too short.
Result<PvsScene> measurePvs(Engine& engine, std::span<const TimedView> path, const PvsSampling& sampling,
                            std::span<const PvsOptions> ways, const std::function<void()>& step);

}  // namespace tessera::app
