// How well a potentially visible set (PVS) fits what is seen then. No GL.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

/// Pixels by element, a patch or a triangle, over some views.
struct ElementPixels {
  std::vector<std::uint64_t> pixels;  // one an element
  std::size_t views = 0;
};

/// Areas in pixels a view, means over the views; see coverageOf.
struct PvsCoverage {
  double needed = 0.0;    // v: what the shown views show
  double missed = 0.0;    // f_n: of that, elements that are not in the set
  double needless = 0.0;  // f_p: of what the set's own views show, elements that no shown view has
  std::size_t neededElements = 0;
  std::size_t missedElements = 0;
  std::size_t setElements = 0;
  std::size_t needlessElements = 0;

  /// r_c = 1 - f_n / v; 1 where nothing is needed.
  [[nodiscard]] double coverage() const { return needed > 0.0 ? 1.0 - missed / needed : 1.0; }
  /// r_o = f_p / v; 0 where nothing is needless, infinite where all is.
  [[nodiscard]] double overestimation() const { return needless > 0.0 ? needless / needed : 0.0; }
};

/// Coverage and overestimation of Mueller et al. 2018, sec. 5.1, with the pixels that an element covers as
/// its area on the screen. `shown` counts the views that a client displays while the set holds, `sampled`
/// those that the set was made of, margin included. `inSet` has one entry an element, as both of the counts
/// have.
PvsCoverage coverageOf(const ElementPixels& shown, const ElementPixels& sampled,
                       const std::vector<bool>& inSet);

}  // namespace tessera
