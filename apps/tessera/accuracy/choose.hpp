// A configuration from a saved study.
#pragma once

#include <optional>
#include <string>

#include "apps/tessera/accuracy/knobs.hpp"

namespace tessera::app {

struct StudyChoice {
  std::string file;  // accuracy.json; empty: none is asked for
  std::optional<double> budgetMs;
  std::optional<double> targetDssim;
};

struct Chosen {
  Configuration configuration;
  std::string reason;  // what and why, a few lines
};

/// The best configuration of the study within the budget, or the cheapest within the target, of the points of
/// the scene of this file name. Fails with the file, the element and the value that is wrong, where the study
/// has not this scene, and where nothing that it measured is so cheap or so good.
Result<Chosen> chooseFrom(const StudyChoice& choice, const std::string& scene);
/// As chooseFrom, from the text of the study; `choice.file` is what errors call it.
Result<Chosen> chooseIn(std::string_view study, const StudyChoice& choice, const std::string& scene);

}  // namespace tessera::app
