// Which configurations are worth measuring: each knob by itself, then combinations that those lead to expect
// much of.
#pragma once

#include <span>
#include <vector>

#include "apps/tessera/accuracy/knobs.hpp"

namespace tessera::app {

/// Where a knob is turned, all else the same.
struct PlannedCurve {
  std::size_t knob = 0;             // of knobs()
  Settings with;                    // completed, the knob at its own value
  std::vector<std::string> values;  // of the knob
  std::vector<std::size_t> points;  // indices of Plan::configurations, one a value
  std::size_t standard = 0;         // of values: what `with` has
};

struct Plan {
  std::vector<Settings> configurations;  // completed, no two alike
  std::vector<PlannedCurve> curves;
  /// The index of a configuration, which is added where it is new. Fails as completed().
  Result<std::size_t> add(const Settings& settings);
};

/// Every knob by itself, or those of these names. The method is swept in any case: the others are turned in
/// methods.
Result<Plan> planSweep(bool quick, std::span<const std::string> only = {});

/// A measured configuration: less is better in both.
struct Measured {
  Settings settings;  // completed
  Tradeoff trade;
};
/// Up to `most` combinations of settings that were each measured alone in the same method, expecting that
/// each change multiplies cost and error as it did by itself; what is within the spread counts as no change.
/// One after another those that get farthest beyond all that is measured or chosen, or stay least behind it.
/// At most three changes each; cheapest first.
std::vector<Settings> worthCombining(std::span<const Measured> measured, std::size_t most);

}  // namespace tessera::app
