// LDR-FLIP of Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem and Fairchild: "FLIP: A Difference
// Evaluator for Alternating Images", Proc. ACM CGIT 3(2), 2020. Section numbers below are the paper's.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <glm/glm.hpp>

#include "engine/measure/filter.hpp"
#include "engine/measure/metrics.hpp"
#include "engine/measure/metrics_check.hpp"

namespace tessera {
namespace {

// Constants of sec. 4: exponents of the colour and feature differences, where the compressed range of colour
// differences begins (as shares of the largest difference and of the result), and the width of a feature in
// degrees.
constexpr float kColourExponent = 0.7F;
constexpr float kFeatureExponent = 0.5F;
constexpr float kKneeIn = 0.4F;
constexpr float kKneeOut = 0.95F;
constexpr double kFeatureWidth = 0.082;
constexpr int kBandRows = 64;

// ---- colour spaces ----

/// Linear sRGB to CIE XYZ (IEC 61966-2-1), columns are red, green and blue.
const glm::mat3 kToXyz{0.4124F, 0.2126F, 0.0193F, 0.3576F, 0.7152F, 0.1192F, 0.1805F, 0.0722F, 0.9505F};
const glm::mat3 kFromXyz = glm::inverse(kToXyz);
const glm::vec3 kWhite = kToXyz * glm::vec3(1.0F);

float linearFromSrgb(float encoded) {
  return encoded <= 0.04045F ? encoded / 12.92F : std::pow((encoded + 0.055F) / 1.055F, 2.4F);
}

/// YCxCz: the opponent space that is linear in light, in which contrast sensitivity is a filter (sec. 4.1.1).
glm::vec3 ycxczFromLinear(const glm::vec3& linear) {
  const glm::vec3 xyz = kToXyz * linear / kWhite;
  return {116.0F * xyz.y - 16.0F, 500.0F * (xyz.x - xyz.y), 200.0F * (xyz.y - xyz.z)};
}

glm::vec3 linearFromYcxcz(const glm::vec3& ycxcz) {
  const float y = (ycxcz.x + 16.0F) / 116.0F;
  return kFromXyz * (glm::vec3(y + ycxcz.y / 500.0F, y, y - ycxcz.z / 200.0F) * kWhite);
}

float labCurve(float t) {
  constexpr float kDelta = 6.0F / 29.0F;
  return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3.0F * kDelta * kDelta) + 4.0F / 29.0F;
}

/// CIE L*a*b* with the chroma scaled by lightness: colour counts for less in the dark (Hunt effect,
/// sec. 4.1.2).
glm::vec3 huntLabFromLinear(const glm::vec3& linear) {
  const glm::vec3 xyz = kToXyz * linear / kWhite;
  const float fx = labCurve(xyz.x);
  const float fy = labCurve(xyz.y);
  const float fz = labCurve(xyz.z);
  const float lightness = 116.0F * fy - 16.0F;
  return {lightness, 0.01F * lightness * 500.0F * (fx - fy), 0.01F * lightness * 200.0F * (fy - fz)};
}

/// Distance made for large colour differences: city block between lightness and chroma, Euclidean within
/// chroma.
float hyab(const glm::vec3& a, const glm::vec3& b) {
  const glm::vec3 d = a - b;
  return std::abs(d.x) + std::sqrt(d.y * d.y + d.z * d.z);
}

// ---- kernels ----

/// One separable term of a 2D kernel: taps(x) * taps(y).
struct Term {
  std::vector<float> taps;
  int radius = 0;
};

std::vector<float> toFloat(const std::vector<double>& values) { return {values.begin(), values.end()}; }

double squared(double x) { return x * x; }

/// sum over a * sqrt(pi / b) * exp(-pi^2 d^2 / b), d the distance in degrees: the contrast sensitivity of one
/// channel brought to the spatial domain (sec. 4.1.1).
struct Sensitivity {
  double a = 0.0;
  double b = 0.0;
};

struct Kernels {
  explicit Kernels(double pixelsPerDegree) {
    // The widest Gaussian, three standard deviations, gives the extent of all three channels' kernels.
    constexpr std::array<Sensitivity, 1> kAchromatic{{{1.0, 0.0047}}};
    constexpr std::array<Sensitivity, 1> kRedGreen{{{1.0, 0.0053}}};
    constexpr std::array<Sensitivity, 2> kBlueYellow{{{34.1, 0.04}, {13.5, 0.025}}};
    const int extent = static_cast<int>(
        std::ceil(3.0 * std::sqrt(0.04 / (2.0 * squared(std::numbers::pi))) * pixelsPerDegree));
    achromatic = contrastFilter(kAchromatic, extent, pixelsPerDegree);
    redGreen = contrastFilter(kRedGreen, extent, pixelsPerDegree);
    blueYellow = contrastFilter(kBlueYellow, extent, pixelsPerDegree);
    makeFeatures(pixelsPerDegree);
    margin = std::max(extent, featureRadius);
  }

  static std::vector<Term> contrastFilter(std::span<const Sensitivity> terms, int extent,
                                          double pixelsPerDegree) {
    std::vector<std::vector<double>> profiles;
    double total = 0.0;
    for (const Sensitivity& s : terms) {
      std::vector<double>& profile = profiles.emplace_back();
      double sum = 0.0;
      for (int i = -extent; i <= extent; ++i) {
        profile.push_back(std::exp(-squared(std::numbers::pi * i / pixelsPerDegree) / s.b));
        sum += profile.back();
      }
      const double scale = s.a * std::sqrt(std::numbers::pi / s.b);
      for (double& value : profile) value *= std::sqrt(scale);
      total += scale * squared(sum);
    }
    std::vector<Term> out;
    for (std::vector<double>& profile : profiles) {
      for (double& value : profile) value /= std::sqrt(total);
      // The ends of a narrow Gaussian inside the common extent weigh nothing in 8-bit images: leave them out.
      int radius = extent;
      while (radius > 0 && profile[static_cast<std::size_t>(extent - radius)] < 1e-8) --radius;
      out.push_back({{profile.begin() + (extent - radius), profile.end() - (extent - radius)}, radius});
    }
    return out;
  }

  /// First and second derivative of a Gaussian for edges and points; each sign's weights sum to one
  /// (sec. 4.2.1).
  void makeFeatures(double pixelsPerDegree) {
    const double sigma = 0.5 * kFeatureWidth * pixelsPerDegree;
    featureRadius = static_cast<int>(std::ceil(3.0 * sigma));
    const std::vector<double> gauss = gaussianTaps(2 * featureRadius + 1, sigma);
    std::vector<double> first;
    std::vector<double> second;
    for (int i = -featureRadius; i <= featureRadius; ++i) {
      const double weight = gauss[first.size()];
      first.push_back(-i * weight);
      second.push_back((squared(i / sigma) - 1.0) * weight);
    }
    smooth = toFloat(gauss);
    edge = toFloat(balanced(first));
    point = toFloat(balanced(second));
  }

  static std::vector<double> balanced(std::vector<double> taps) {
    double positive = 0.0;
    double negative = 0.0;
    for (const double tap : taps) (tap > 0.0 ? positive : negative) += std::abs(tap);
    for (double& tap : taps) tap /= tap > 0.0 ? positive : negative;
    return taps;
  }

  std::vector<Term> achromatic;
  std::vector<Term> redGreen;
  std::vector<Term> blueYellow;
  std::vector<float> smooth;
  std::vector<float> edge;
  std::vector<float> point;
  int featureRadius = 0;
  int margin = 0;
};

// ---- one image, one band of rows ----

struct Band {
  Plane<float> y, cx, cz;
};

/// The band's rows and `margin` more on all four sides, the image's border repeated, in YCxCz.
Band loadBand(const Image& image, int firstRow, int rows, int margin, const std::array<float, 256>& linear) {
  const int width = image.width + 2 * margin;
  const int height = rows + 2 * margin;
  Band band{{width, height}, {width, height}, {width, height}};
  for (int row = 0; row < height; ++row) {
    const int sourceRow = std::clamp(firstRow + row - margin, 0, image.height - 1);
    const std::uint8_t* pixel = image.at(0, sourceRow);
    float* y = band.y.row(row);
    float* cx = band.cx.row(row);
    float* cz = band.cz.row(row);
    for (int column = margin; column < margin + image.width; ++column, pixel += 4) {
      const glm::vec3 value = ycxczFromLinear({linear[pixel[0]], linear[pixel[1]], linear[pixel[2]]});
      y[column] = value.x;
      cx[column] = value.y;
      cz[column] = value.z;
    }
    for (float* values : {y, cx, cz}) {
      std::fill_n(values, margin, values[margin]);
      std::fill_n(values + margin + image.width, margin, values[margin + image.width - 1]);
    }
  }
  return band;
}

Plane<float> separable(const Plane<float>& in, std::span<const float> tapsX, std::span<const float> tapsY,
                       int crop) {
  return convolveColumns<float>(convolveRows<float>(in, tapsX, crop), tapsY, crop);
}

Plane<float> contrastFiltered(const Plane<float>& in, const std::vector<Term>& terms, int margin) {
  Plane<float> sum = separable(in, terms[0].taps, terms[0].taps, margin - terms[0].radius);
  for (std::size_t t = 1; t < terms.size(); ++t) {
    const Plane<float> more = separable(in, terms[t].taps, terms[t].taps, margin - terms[t].radius);
    for (std::size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += more.values[i];
  }
  return sum;
}

/// What an observer sees of a band: colours after contrast sensitivity, and the strength of edges and points.
struct Perceived {
  std::vector<glm::vec3> colour;
  std::vector<float> edge;
  std::vector<float> point;
};

std::vector<float> magnitude(const Plane<float>& x, const Plane<float>& y) {
  std::vector<float> out(x.values.size());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = std::sqrt(x.values[i] * x.values[i] + y.values[i] * y.values[i]);
  return out;
}

Perceived perceive(const Image& image, int firstRow, int rows, const Kernels& kernels,
                   const std::array<float, 256>& linear) {
  Band band = loadBand(image, firstRow, rows, kernels.margin, linear);
  const Plane<float> y = contrastFiltered(band.y, kernels.achromatic, kernels.margin);
  const Plane<float> cx = contrastFiltered(band.cx, kernels.redGreen, kernels.margin);
  const Plane<float> cz = contrastFiltered(band.cz, kernels.blueYellow, kernels.margin);
  Perceived out;
  out.colour.resize(y.values.size());
  for (std::size_t i = 0; i < y.values.size(); ++i) {
    const glm::vec3 rgb = linearFromYcxcz({y.values[i], cx.values[i], cz.values[i]});
    out.colour[i] = huntLabFromLinear(glm::clamp(rgb, 0.0F, 1.0F));
  }

  for (float& value : band.y.values) value = (value + 16.0F) / 116.0F;
  const int crop = kernels.margin - kernels.featureRadius;
  const Plane<float> smoothX = convolveRows<float>(band.y, kernels.smooth, crop);
  const Plane<float> edgeX = convolveRows<float>(band.y, kernels.edge, crop);
  const Plane<float> pointX = convolveRows<float>(band.y, kernels.point, crop);
  out.edge = magnitude(convolveColumns<float>(edgeX, kernels.smooth, crop),
                       convolveColumns<float>(smoothX, kernels.edge, crop));
  out.point = magnitude(convolveColumns<float>(pointX, kernels.smooth, crop),
                        convolveColumns<float>(smoothX, kernels.point, crop));
  return out;
}

/// Colour difference to 0..1: the lower differences get most of the range (sec. 4.1.3).
float redistributed(float difference, float largest) {
  const float knee = kKneeIn * largest;
  if (difference < knee) return difference * (kKneeOut / knee);
  return kKneeOut + (difference - knee) / (largest - knee) * (1.0F - kKneeOut);
}

}  // namespace

Result<MetricMap> flip(const Image& reference, const Image& test, double pixelsPerDegree) {
  if (auto checked = checkPair("FLIP", reference, test); !checked) return tl::unexpected(checked.error());
  if (!(pixelsPerDegree >= 1.0 && pixelsPerDegree <= 1000.0))
    return fail("FLIP: {} pixels per degree is outside 1 to 1000", pixelsPerDegree);

  const Kernels kernels(pixelsPerDegree);
  std::array<float, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = linearFromSrgb(static_cast<float>(i) / 255.0F);
  // The two corners of the sRGB gamut that lie farthest apart in HyAB.
  const float largest = std::pow(
      hyab(huntLabFromLinear({0.0F, 1.0F, 0.0F}), huntLabFromLinear({0.0F, 0.0F, 1.0F})), kColourExponent);

  MetricMap result{reference.width, reference.height, {}, 0.0};
  result.map.resize(static_cast<std::size_t>(result.width) * static_cast<std::size_t>(result.height));
  const double sum = sumOverBands(result.height, kBandRows, [&](int first, int end) {
    const Perceived a = perceive(reference, first, end - first, kernels, linear);
    const Perceived b = perceive(test, first, end - first, kernels, linear);
    float* out = result.map.data() + static_cast<std::size_t>(first) * static_cast<std::size_t>(result.width);
    double bandSum = 0.0;
    for (std::size_t i = 0; i < a.colour.size(); ++i) {
      const float colour = redistributed(std::pow(hyab(a.colour[i], b.colour[i]), kColourExponent), largest);
      const float feature = std::max(std::abs(a.edge[i] - b.edge[i]), std::abs(a.point[i] - b.point[i]));
      const float exponent = 1.0F - std::pow(feature / std::numbers::sqrt2_v<float>, kFeatureExponent);
      // A feature difference may round past one; a power of zero must stay zero then.
      out[i] = std::clamp(std::pow(colour, std::max(exponent, 0.0F)), 0.0F, 1.0F);
      bandSum += static_cast<double>(out[i]);
    }
    return bandSum;
  });
  result.mean = sum / static_cast<double>(result.map.size());
  return result;
}

}  // namespace tessera
