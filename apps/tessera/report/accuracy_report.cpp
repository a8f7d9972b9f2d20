#include "apps/tessera/report/accuracy_report.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tessera {

namespace {

constexpr double kLeastSpread = 0.01;  // of the median

Tradeoff tradeoffOf(const AccuracyPoint& point) { return {point.ms, point.dssim}; }

std::size_t alike(std::span<const AccuracyPoint> points, const AccuracyPoint& chosen) {
  return static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(), [&](const AccuracyPoint& other) {
        return &other != &chosen && touch(other.ms, chosen.ms) && touch(other.dssim, chosen.dssim);
      }));
}

}  // namespace

bool touch(const Spread& a, const Spread& b) {
  const auto low = [](const Spread& s) {
    return std::min(s.low, s.median - 0.5 * kLeastSpread * std::abs(s.median));
  };
  const auto high = [](const Spread& s) {
    return std::max(s.high, s.median + 0.5 * kLeastSpread * std::abs(s.median));
  };
  return low(a) <= high(b) && low(b) <= high(a);
}

Spread spreadOf(std::span<const double> samples) {
  std::vector<double> sorted;
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(sorted),
               [](double sample) { return std::isfinite(sample); });
  std::sort(sorted.begin(), sorted.end());
  return {quantileOfSorted(sorted, 0.5), quantileOfSorted(sorted, 0.25), quantileOfSorted(sorted, 0.75)};
}

std::vector<std::size_t> paretoFront(std::span<const Tradeoff> points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::isfinite(points[i].cost.median) && std::isfinite(points[i].error.median)) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(points[a].cost.median, points[a].error.median) <
           std::pair(points[b].cost.median, points[b].error.median);
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order)
    if (front.empty() || points[i].error.median < points[front.back()].error.median) front.push_back(i);
  return front;
}

bool apart(const Tradeoff& a, const Tradeoff& b) {
  return !touch(a.cost, b.cost) && !touch(a.error, b.error);
}

std::vector<bool> distinguishable(std::span<const Tradeoff> points, std::span<const std::size_t> front) {
  std::vector<bool> told;
  std::size_t last = 0;
  for (std::size_t i = 0; i < front.size(); ++i) {
    told.push_back(i == 0 || apart(points[front[last]], points[front[i]]));
    if (told.back()) last = i;
  }
  return told;
}

void findFront(std::vector<AccuracyPoint>& points) {
  std::vector<Tradeoff> trades;
  for (AccuracyPoint& point : points) {
    point.pareto = point.distinguishable = false;
    trades.push_back(tradeoffOf(point));
  }
  const auto front = paretoFront(trades);
  const auto told = distinguishable(trades, front);
  for (std::size_t i = 0; i < front.size(); ++i) {
    points[front[i]].pareto = true;
    points[front[i]].distinguishable = told[i];
  }
}

Result<AccuracyChoice> bestWithin(std::span<const AccuracyPoint> points, double ms) {
  const AccuracyPoint* best = nullptr;
  const AccuracyPoint* cheapest = nullptr;
  for (const AccuracyPoint& point : points) {
    if (cheapest == nullptr || point.ms.median < cheapest->ms.median) cheapest = &point;
    if (point.ms.median > ms) continue;
    if (best == nullptr ||
        std::pair(point.dssim.median, point.ms.median) < std::pair(best->dssim.median, best->ms.median))
      best = &point;
  }
  if (cheapest == nullptr) return fail("no configuration was measured");
  if (best == nullptr)
    return fail("no configuration takes {:g} ms or less; the cheapest, {}, takes {:.4g}", ms, cheapest->name,
                cheapest->ms.median);
  return AccuracyChoice{best, alike(points, *best)};
}

Result<AccuracyChoice> cheapestFor(std::span<const AccuracyPoint> points, double dssim) {
  const AccuracyPoint* cheapest = nullptr;
  const AccuracyPoint* best = nullptr;
  for (const AccuracyPoint& point : points) {
    if (best == nullptr || point.dssim.median < best->dssim.median) best = &point;
    if (point.dssim.median > dssim) continue;
    if (cheapest == nullptr || std::pair(point.ms.median, point.dssim.median) <
                                   std::pair(cheapest->ms.median, cheapest->dssim.median))
      cheapest = &point;
  }
  if (best == nullptr) return fail("no configuration was measured");
  if (cheapest == nullptr)
    return fail("no configuration has a DSSIM of {:g} or less; the best, {}, has {:.4g}", dssim, best->name,
                best->dssim.median);
  return AccuracyChoice{cheapest, alike(points, *cheapest)};
}

}  // namespace tessera
