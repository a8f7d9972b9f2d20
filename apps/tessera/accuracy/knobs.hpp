// What trades accuracy for time: the one list of knobs that `tessera accuracy` turns. A new knob is one entry
// more.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/tessera/compare/method.hpp"
#include "apps/tessera/report/accuracy_report.hpp"

namespace tessera::app {

/// A way to draw frames, with all that knobs turn.
struct Configuration {
  Method method;
  int shadowSize = EngineOptions().shadowSize;
  ShadowFilter shadowFilter = EngineOptions().shadowFilter;
  NumericForms forms;

  [[nodiscard]] bool isForward() const { return !method.usesAtlas(); }
  [[nodiscard]] bool isSampledBy(Sampling sampling) const {
    return method.usesAtlas() && method.atlas.sampling == sampling;
  }
  /// Whether the tessellation gatherer fills the atlas, with Ls, oversampled triangles or both.
  [[nodiscard]] bool isTess() const {
    return method.usesAtlas() && method.atlas.sampling != Sampling::Rect &&
           method.atlas.sampling != Sampling::Texel;
  }
};

struct Knob {
  std::string name;                           // in accuracy.json
  std::string label;                          // on the page
  std::string sentence;                       // what it does, and what it costs
  std::vector<std::string> values;            // in the order of a curve; the standard one is among them
  std::vector<std::string> quickValues = {};  // of them, those of a quick study; none: not in it
  std::string standard;                       // what holds unless it is turned
  std::vector<Settings> curves;               // what it is turned in, the most telling first
  int quickCurves = 1;                        // of them, so many in a quick study
  /// Whether turning it changes anything in this configuration; only what is applied before it counts.
  std::function<bool(const Configuration&)> heeded;
  /// Fails with what the value should have been. Takes any sensible value, not only those above.
  std::function<Result<void>(Configuration&, std::string_view value)> apply;
};

/// All knobs, in the order in which they are applied: the method first.
const std::vector<Knob>& knobs();

/// The configuration with these settings, all else standard. Fails with the first setting of an unknown knob,
/// of one that is set twice or that the configuration does not heed, or with a value that is out of range.
Result<Configuration> configurationOf(const Settings& settings);
/// The settings of every knob that the configuration with `settings` heeds, in the order of the registry.
/// Equal for configurations that draw alike. Fails as configurationOf.
Result<Settings> completed(const Settings& settings);
/// "rect", "tess, bias -2": the method and what is not standard.
std::string nameOf(const Settings& settings);
/// The value that `settings` gives a knob; `otherwise` where it gives none.
std::string settingOf(const Settings& settings, std::string_view knob, std::string_view otherwise = {});
/// With this value of a knob in place of the one that there may be.
Settings withKnob(Settings settings, const std::string& knob, const std::string& value);

}  // namespace tessera::app
