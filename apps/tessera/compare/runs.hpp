// The frames of one scene, drawn and measured method by method.
#pragma once

#include <span>

#include "apps/tessera/compare/options.hpp"
#include "apps/tessera/compare/quality.hpp"
#include "apps/tessera/compare/references.hpp"
#include "apps/tessera/compare/series.hpp"
#include "apps/tessera/progress.hpp"

namespace tessera::app {

/// The error that the map paints brightest: what a critical eye sees at once.
inline constexpr float kErrorFull = 0.5f;

/// Draws the views by one method after another; a reference must come before what is compared with it.
class Runs {
 public:
  Runs(Engine& engine, const std::vector<TimedView>& views, const std::vector<Method>& methods,
       const CompareOptions& options);
  Result<Series> run(const Method& method, Progress& progress);

 private:
  [[nodiscard]] double resets() const;
  Result<void> frame(const Method& method, std::size_t f, Series& series);
  void keepAtlasNumbers(std::size_t f, Series& series) const;
  void keepPictures(std::size_t f, const Image& picture, const Quality& quality, bool atlas,
                    Series& series) const;

  Engine& engine_;
  const std::vector<TimedView>& views_;
  const CompareOptions& options_;
  MetricChoice metrics_;
  std::vector<std::size_t> chosen_;
  References references_;
};

}  // namespace tessera::app
