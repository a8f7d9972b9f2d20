#include "apps/tessera/report/study_report.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace tessera {

namespace {

constexpr double kLatencyFrom = 50.0;  // ms: from here on the atlas is to win
constexpr double kLatencyAt = 100.0;   // ms: what this may cost
constexpr double kMostLoss = 0.01;     // of MSSIM

std::vector<double> valuesOf(const std::vector<StudyPoint>& points, double StudyPoint::*field) {
  std::vector<double> values;
  for (const StudyPoint& point : points) values.push_back(point.*field);
  return values;
}

const StudyPoint* at(const std::vector<StudyPoint>& points, double latencyMs) {
  const auto found = std::find_if(points.begin(), points.end(), [&](const StudyPoint& point) {
    return std::abs(point.latencyMs - latencyMs) < 1e-6;
  });
  return found == points.end() ? nullptr : &*found;
}

/// The best of the warps at each point of a figure.
std::vector<double> bestWarp(const StudyScene& scene, std::vector<StudyPoint> StudyMethod::*figure) {
  std::vector<double> best;
  for (const StudyMethod& method : scene.methods) {
    if (method.atlas) continue;
    const std::vector<double> values = valuesOf(method.*figure, &StudyPoint::mssim);
    best.resize(values.size(), 0.0);
    for (std::size_t i = 0; i < values.size(); ++i) best[i] = std::max(best[i], values[i]);
  }
  return best;
}

void addCrossing(std::vector<StudyFinding>& findings, const StudyScene& scene, const StudyMethod& method,
                 std::vector<StudyPoint> StudyMethod::*figure, double StudyPoint::*axis, const char* what,
                 const char* unit) {
  const std::vector<double> best = bestWarp(scene, figure);
  const std::vector<double> x = valuesOf(method.*figure, axis);
  if (best.size() < 2 || x.size() != best.size()) return;
  const double from = crossing(x, valuesOf(method.*figure, &StudyPoint::mssim), best);
  findings.push_back(
      {std::isnan(from) ? fmt::format("{}: at {:g} {} of {} the best warp is still ahead.", method.name,
                                      x.back(), unit, what)
       : from <= x.front()
           ? fmt::format("{} beats every warp at all of {:g} to {:g} {} of {}.", method.name, x.front(),
                         x.back(), unit, what)
           : fmt::format("{} beats every warp from {:.3g} {} of {} on.", method.name, from, unit, what)});
}

void addGoals(std::vector<StudyFinding>& findings, const StudyScene& scene, const StudyMethod& method) {
  const std::vector<double> best = bestWarp(scene, &StudyMethod::byLatency);
  if (best.size() == method.byLatency.size()) {
    double least = 2.0;
    for (std::size_t i = 0; i < best.size(); ++i)
      if (method.byLatency[i].latencyMs >= kLatencyFrom - 1e-6)
        least = std::min(least, method.byLatency[i].mssim - best[i]);
    if (least < 2.0)
      findings.push_back(
          {fmt::format("{} against the best warp at {:g} ms and above: MSSIM {:+.4f} at least.", method.name,
                       kLatencyFrom, least),
           true, least > 0.0});
  }
  const StudyPoint* now = at(method.byLatency, 0.0);
  const StudyPoint* late = at(method.byLatency, kLatencyAt);
  if (now != nullptr && late != nullptr)
    findings.push_back(
        {fmt::format("{}: MSSIM {:.4f} at 0 ms, {:.4f} at {:g} ms: {:+.4f}, {:g} allowed.", method.name,
                     now->mssim, late->mssim, kLatencyAt, late->mssim - now->mssim, -kMostLoss),
         true, now->mssim - late->mssim <= kMostLoss});
}

}  // namespace

double crossing(const std::vector<double>& x, const std::vector<double>& a, const std::vector<double>& b) {
  std::size_t from = x.size();
  while (from > 0 && a[from - 1] > b[from - 1]) --from;
  if (from == x.size()) return kNotMeasured;
  if (from == 0) return x.front();
  const double below = a[from - 1] - b[from - 1];
  const double above = a[from] - b[from];
  return x[from - 1] + (x[from] - x[from - 1]) * below / (below - above);
}

std::vector<StudyFinding> findingsOf(const StudyScene& scene) {
  std::vector<StudyFinding> findings;
  for (const StudyMethod& method : scene.methods)
    if (method.atlas) addGoals(findings, scene, method);
  for (const StudyMethod& method : scene.methods) {
    if (!method.atlas) continue;
    addCrossing(findings, scene, method, &StudyMethod::byLatency, &StudyPoint::latencyMs, "latency", "ms");
    addCrossing(findings, scene, method, &StudyMethod::byBitrate, &StudyPoint::mbit, "video", "Mbit/s");
  }
  return findings;
}

}  // namespace tessera
