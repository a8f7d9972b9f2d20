// The frames of one scene, drawn and measured method by method.
#pragma once

#include <span>

#include "apps/tessera/compare/crops.hpp"
#include "apps/tessera/compare/options.hpp"
#include "apps/tessera/compare/pictures.hpp"
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
  enum class Wanted : std::uint8_t { All, Numbers };  // Numbers: no pictures, and of the metrics MSSIM alone
  Result<Series> run(const Method& method, Progress& progress, Wanted wanted = Wanted::All);
  /// Where most is slanted, as the methods that were run showed it.
  [[nodiscard]] const std::vector<ReportCrop>& crops() const { return crops_; }

 private:
  [[nodiscard]] std::uint64_t resets() const;
  Result<void> frame(const Method& method, std::size_t f, Wanted wanted, Series& series);
  Result<void> keepCrops(const Method& method, std::size_t f, const Image& picture);
  void keepAtlasNumbers(std::size_t f, Series& series) const;
  void keepPictures(std::size_t f, const Image& picture, const Quality& quality, bool atlas,
                    Series& series) const;

  Engine& engine_;
  const std::vector<TimedView>& views_;
  const CompareOptions& options_;
  MetricChoice metrics_;
  PictureBudget budget_;
  References references_;
  std::vector<ReportCrop> crops_;
};

}  // namespace tessera::app
