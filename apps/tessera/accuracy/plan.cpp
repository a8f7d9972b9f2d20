#include "apps/tessera/accuracy/plan.hpp"

#include <algorithm>
#include <cmath>

namespace tessera::app {

namespace {

constexpr int kMostChanges = 3;
constexpr double kFarthest = 1.2;  // behind another configuration in cost and in error, to be measured at all

/// What turning one knob does to a method.
struct Change {
  std::string knob;
  std::string value;
  double cost = 1.0;  // factors
  double error = 1.0;
};

struct Candidate {
  Settings settings;
  double cost = 0.0;
  double error = 0.0;
  int changes = 0;
};

/// The settings that are not standard, but for the method's.
Settings turned(const Settings& settings) {
  Settings changes;
  for (const Knob& knob : knobs()) {
    const std::string value = settingOf(settings, knob.name, knob.standard);
    if (knob.name != "method" && value != knob.standard) changes.emplace_back(knob.name, value);
  }
  return changes;
}

/// 1 where the two cannot be told apart.
double factor(const Spread& from, const Spread& to) {
  return touch(from, to) ? 1.0 : to.median / from.median;
}

/// What each knob by itself does to the method of `base`, where it makes anything better.
std::vector<Change> changesOf(const Measured& base, std::span<const Measured> measured) {
  std::vector<Change> changes;
  for (const Measured& one : measured) {
    const Settings change = turned(one.settings);
    if (settingOf(one.settings, "method") != settingOf(base.settings, "method") || change.size() != 1)
      continue;
    const double cost = factor(base.trade.cost, one.trade.cost);
    const double error = factor(base.trade.error, one.trade.error);
    if (std::min(cost, error) < 1.0) changes.push_back({change[0].first, change[0].second, cost, error});
  }
  return changes;
}

/// All that few of the changes make of the base, each knob turned once.
std::vector<Candidate> grow(const Measured& base, const std::vector<Change>& changes) {
  std::vector<Candidate> all = {{base.settings, base.trade.cost.median, base.trade.error.median, 0}};
  std::size_t first = 0;
  for (int depth = 0; depth < kMostChanges; ++depth) {
    const std::size_t last = all.size();
    for (; first < last; ++first)
      for (const Change& change : changes) {
        const Candidate from = all[first];
        // In rising order of names: no set of changes is made twice.
        const Settings done = turned(from.settings);
        if (std::any_of(done.begin(), done.end(), [&](const auto& d) { return d.first >= change.knob; }))
          continue;
        all.push_back({withKnob(from.settings, change.knob, change.value), from.cost * change.cost,
                       from.error * change.error, from.changes + 1});
      }
  }
  return all;
}

}  // namespace

Result<std::size_t> Plan::add(const Settings& settings) {
  auto whole = completed(settings);
  if (!whole) return tl::unexpected(whole.error());
  const auto found = std::find(configurations.begin(), configurations.end(), *whole);
  if (found != configurations.end()) return static_cast<std::size_t>(found - configurations.begin());
  configurations.push_back(std::move(*whole));
  return configurations.size() - 1;
}

Result<Plan> planSweep(bool quick, std::span<const std::string> only) {
  Plan plan;
  for (std::size_t k = 0; k < knobs().size(); ++k) {
    const Knob& knob = knobs()[k];
    if (k > 0 && !only.empty() && std::find(only.begin(), only.end(), knob.name) == only.end()) continue;
    const std::vector<std::string>& values = quick ? knob.quickValues : knob.values;
    if (values.empty()) continue;
    const std::size_t curves =
        quick ? std::min(knob.curves.size(), static_cast<std::size_t>(knob.quickCurves)) : knob.curves.size();
    for (std::size_t c = 0; c < curves; ++c) {
      auto with = completed(knob.curves[c]);
      if (!with) return tl::unexpected(with.error());
      PlannedCurve curve{k, *with, values, {}, 0};
      const std::string own = settingOf(*with, knob.name);
      for (const std::string& value : values) {
        auto index = plan.add(withKnob(knob.curves[c], knob.name, value));
        if (!index) return tl::unexpected(index.error());
        if (value == own) curve.standard = curve.points.size();
        curve.points.push_back(*index);
      }
      plan.curves.push_back(std::move(curve));
    }
  }
  return plan;
}

std::vector<Settings> worthCombining(std::span<const Measured> measured, std::size_t most) {
  std::vector<Candidate> expected;
  std::vector<Candidate> taken;  // what there is, and what is chosen
  for (const Measured& one : measured)
    taken.push_back({one.settings, one.trade.cost.median, one.trade.error.median, 0});
  for (const Measured& base : measured) {
    if (!turned(base.settings).empty() || !(base.trade.cost.median > 0.0) || !(base.trade.error.median > 0.0))
      continue;
    for (Candidate& candidate : grow(base, changesOf(base, measured))) {
      const auto same = [&](const Measured& m) { return m.settings == candidate.settings; };
      if (candidate.changes > 1 && std::none_of(measured.begin(), measured.end(), same))
        expected.push_back(std::move(candidate));
    }
  }
  std::vector<double> reach(expected.size(), 0.0);
  const auto account = [&](const Candidate& other) {
    for (std::size_t i = 0; i < expected.size(); ++i)
      reach[i] = std::max(reach[i], std::min(expected[i].cost / other.cost, expected[i].error / other.error));
  };
  for (const Candidate& candidate : taken) account(candidate);
  std::vector<Candidate> chosen;
  while (chosen.size() < most && !expected.empty()) {
    const auto best = std::min_element(reach.begin(), reach.end()) - reach.begin();
    if (!(reach[static_cast<std::size_t>(best)] < kFarthest)) break;
    chosen.push_back(expected[static_cast<std::size_t>(best)]);
    // The one that is chosen is in its own way from here on, and in that of those like it.
    account(chosen.back());
    reach[static_cast<std::size_t>(best)] = kFarthest;
  }
  std::stable_sort(chosen.begin(), chosen.end(),
                   [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  std::vector<Settings> settings;
  for (Candidate& candidate : chosen) settings.push_back(std::move(candidate.settings));
  return settings;
}

}  // namespace tessera::app
