// The frames of one scene, drawn and measured method by method.
#pragma once

#include "apps/tessera/compare/options.hpp"
#include "apps/tessera/compare/series.hpp"
#include "apps/tessera/progress.hpp"

namespace tessera::app {

/// The error that the map paints brightest: what a critical eye sees at once.
inline constexpr float kErrorFull = 0.5f;

/// Draws the views by one method after another; the first must be forward, whose pictures the others are
/// compared with.
class Runs {
 public:
  Runs(Engine& engine, const std::vector<TimedView>& views, const CompareOptions& options);
  Result<Series> run(const Method& method, Progress& progress);

 private:
  void draw(const Method& method, const TimedView& timed);
  [[nodiscard]] double resets() const;
  Result<void> frame(const Method& method, std::size_t f, Series& series);

  Engine& engine_;
  const std::vector<TimedView>& views_;
  const CompareOptions& options_;
  std::vector<std::size_t> chosen_;
  std::vector<Image> references_;
};

}  // namespace tessera::app
