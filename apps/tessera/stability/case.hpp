// Hard inputs: each a small scene or call, why it is hard, and what must hold.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/tessera/stability/bench.hpp"

namespace tessera::stability {

enum class Sense : std::uint8_t { AtMost, AtLeast };

struct Case {
  std::string name;  // "group/case"
  std::string why;   // why it is hard; where less holds than one would wish, also why no more can be had
  std::string unit;
  double bound = 0.0;  // of the worst figure
  /// AtLeast is for qualities in dB, and for textbook forms: there the bound is an error that they make.
  Sense sense = Sense::AtMost;
  std::function<Result<double>(Bench&)> worst;
};

/// Not a number never passes.
inline bool passes(const Case& entry, double worst) {
  return entry.sense == Sense::AtMost ? worst <= entry.bound : worst >= entry.bound;
}

using Cases = std::vector<Case>;

// The groups.
void addTriangleCases(Cases& cases);
void addCameraCases(Cases& cases);
void addFarCases(Cases& cases);
void addDepthCases(Cases& cases);
void addTransformCases(Cases& cases);
void addShadingCases(Cases& cases);
void addLevelCases(Cases& cases);
void addTessellationCases(Cases& cases);
void addMetricCases(Cases& cases);
void addSoakCases(Cases& cases);
void addDeterminismCases(Cases& cases);

}  // namespace tessera::stability
