#include "engine/measure/filter.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

namespace tessera {
namespace {

/// out[i] = sum over k of taps[k] * in[i + k * stride]. Four taps a sweep: one load and store of `out` for
/// four products, and a loop that the compiler vectorizes for rows (stride 1) and columns (stride width)
/// alike.
template <class T>
void weightedSum(T* __restrict out, int count, std::span<const T> taps, const T* __restrict in,
                 std::ptrdiff_t stride) {
  std::fill_n(out, count, T{0});
  std::size_t k = 0;
  for (; k + 4 <= taps.size(); k += 4, in += 4 * stride) {
    const T w0 = taps[k];
    const T w1 = taps[k + 1];
    const T w2 = taps[k + 2];
    const T w3 = taps[k + 3];
    for (int i = 0; i < count; ++i)
      out[i] += w0 * in[i] + w1 * in[i + stride] + w2 * in[i + 2 * stride] + w3 * in[i + 3 * stride];
  }
  for (; k < taps.size(); ++k, in += stride) {
    const T w = taps[k];
    for (int i = 0; i < count; ++i) out[i] += w * in[i];
  }
}

}  // namespace

template <class T>
Plane<T> convolveRows(const Plane<T>& in, std::span<const T> taps, int crop) {
  Plane<T> out(in.width - 2 * crop - static_cast<int>(taps.size()) + 1, in.height);
  for (int y = 0; y < out.height; ++y) weightedSum(out.row(y), out.width, taps, in.row(y) + crop, 1);
  return out;
}

template <class T>
Plane<T> convolveColumns(const Plane<T>& in, std::span<const T> taps, int crop) {
  Plane<T> out(in.width, in.height - 2 * crop - static_cast<int>(taps.size()) + 1);
  for (int y = 0; y < out.height; ++y) weightedSum(out.row(y), out.width, taps, in.row(y + crop), in.width);
  return out;
}

template Plane<float> convolveRows(const Plane<float>&, std::span<const float>, int);
template Plane<float> convolveColumns(const Plane<float>&, std::span<const float>, int);
template Plane<double> convolveRows(const Plane<double>&, std::span<const double>, int);
template Plane<double> convolveColumns(const Plane<double>&, std::span<const double>, int);

std::vector<double> gaussianTaps(int size, double sigma) {
  std::vector<double> taps(static_cast<std::size_t>(size));
  double sum = 0.0;
  for (int i = 0; i < size; ++i) {
    const double x = i - (size - 1) * 0.5;
    taps[static_cast<std::size_t>(i)] = std::exp(-x * x / (2.0 * sigma * sigma));
    sum += taps[static_cast<std::size_t>(i)];
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

double sumOverBands(int rows, int bandRows, const std::function<double(int, int)>& work) {
  const int bands = (rows + bandRows - 1) / bandRows;
  std::vector<double> sums(static_cast<std::size_t>(bands));
  std::atomic<int> next{0};
  const auto worker = [&] {
    for (int band = next++; band < bands; band = next++)
      sums[static_cast<std::size_t>(band)] = work(band * bandRows, std::min(rows, (band + 1) * bandRows));
  };
  if (bands > 1 && std::thread::hardware_concurrency() > 1) {
    const std::jthread second(worker);
    worker();
  } else {
    worker();
  }
  double sum = 0.0;
  for (const double bandSum : sums) sum += bandSum;
  return sum;
}

}  // namespace tessera
