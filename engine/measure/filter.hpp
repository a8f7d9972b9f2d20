// Separable filters over bands of rows, spread over threads. Shared by the image metrics; not part of the
// API.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace tessera {

/// width * height values, rows from the top.
template <class T>
struct Plane {
  Plane(int planeWidth, int planeHeight)
      : width(planeWidth),
        height(planeHeight),
        values(static_cast<std::size_t>(planeWidth) * static_cast<std::size_t>(planeHeight)) {}

  [[nodiscard]] T* row(int y) {
    return values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
  }
  [[nodiscard]] const T* row(int y) const {
    return values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
  }

  int width;
  int height;
  std::vector<T> values;
};

/// Correlates each row with `taps`, after leaving out `crop` values at both ends of the row. Windows lie
/// wholly inside: the result is `in.width - 2 * crop - taps.size() + 1` wide, which the caller keeps
/// positive.
template <class T>
Plane<T> convolveRows(const Plane<T>& in, std::span<const T> taps, int crop = 0);
/// The same down the columns.
template <class T>
Plane<T> convolveColumns(const Plane<T>& in, std::span<const T> taps, int crop = 0);

/// Gaussian of `size` taps around the middle, normalized to a sum of 1. `sigma` in taps; even sizes lie
/// between taps.
std::vector<double> gaussianTaps(int size, double sigma);

/// Calls work(firstRow, endRow) for bands of at most `bandRows` that cover [0, rows) once, on at most two
/// threads, and returns the sum of what the calls return, added in the order of the rows: the same on any
/// number of threads.
double sumOverBands(int rows, int bandRows, const std::function<double(int, int)>& work);

}  // namespace tessera
