// The report of `tessera accuracy`: what accuracy costs in time, as accuracy.json and as one self-contained
// page; and what chooses a configuration from it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/tessera/report/report.hpp"
#include "engine/core/result.hpp"

namespace tessera {

/// A median and the quartiles around it.
struct Spread {
  double median = kNotMeasured;
  double low = kNotMeasured;
  double high = kNotMeasured;
};
/// Of repeated measurements.
Spread spreadOf(std::span<const double> samples);
/// A number that has no spread.
inline Spread exactly(double value) { return {value, value, value}; }

/// Names and values of knobs.
using Settings = std::vector<std::pair<std::string, std::string>>;

/// One configuration on one scene. Costs and errors are means over the frames.
struct AccuracyPoint {
  std::string scene;     // file
  std::string name;      // what sets it apart: "rect, bias -2"
  Settings config;       // of every knob that it heeds
  Spread ms;             // over the runs
  double samples = 0.0;  // shaded
  double texels = 0.0;   // of the atlas in use; 0 without one
  double bytes = 0.0;    // of GPU memory
  Spread dssim;          // over the runs; against the supersampled reference, as what follows
  double psnrDb = kNotMeasured;
  double flip = kNotMeasured;
  int runs = 0;
  bool pareto = false;                               // no other is as good for less: of ms and DSSIM
  bool distinguishable = false;                      // of the front: beyond the spread of its neighbour
  std::vector<std::uint8_t> image, error;            // PNG or JPEG, of one frame
  std::vector<std::uint8_t> smallImage, smallError;  // what the page has of those that are on no front
};

/// A knob turned, all else the same.
struct AccuracyCurve {
  std::string with;                 // the configuration that it is turned in
  std::vector<std::string> values;  // of the knob
  std::vector<std::size_t> points;  // one a value
  std::string standard;             // the configuration's own value
};
struct AccuracyKnob {
  std::string name;
  std::string label;
  std::string sentence;
  std::vector<AccuracyCurve> curves;
};

struct AccuracyScene {
  std::string file;
  std::string note;  // one line
  std::uint64_t triangles = 0;
  int width = 0;  // of the pictures, pixels
  int height = 0;
  int frames = 0;
  int supersampling = 0;   // samples a pixel of the reference, a side
  double errorFull = 1.0;  // the FLIP error with the brightest colour
  std::vector<AccuracyPoint> points;
  std::vector<AccuracyKnob> knobs;
  std::vector<std::string> skipped;     // configurations that could not be measured, with why
  std::vector<std::uint8_t> reference;  // its picture of the frame that the points show
};

struct AccuracyReport {
  ReportContext context;
  std::string settings;  // one line
  std::vector<AccuracyScene> scenes;
};

/// What a configuration costs, and how far off it is: less is better in both.
struct Tradeoff {
  Spread cost;
  Spread error;
};
/// The points that no other point beats by medians, rising in cost: none is both as cheap and as good, and
/// better in one. Of equal ones the first. Points with a median that is not finite are on no front.
std::vector<std::size_t> paretoFront(std::span<const Tradeoff> points);
/// Whether two spreads overlap. A spread counts as one percent of its median at least: a few runs can agree
/// by chance.
bool touch(const Spread& a, const Spread& b);
/// Whether the two are apart in cost and in error.
bool apart(const Tradeoff& a, const Tradeoff& b);
/// Of a front, which points can be told from the last before them that could: the cheapest always. What
/// cannot may be the same trade, seen through noise.
std::vector<bool> distinguishable(std::span<const Tradeoff> points, std::span<const std::size_t> front);
/// Sets pareto and distinguishable.
void findFront(std::vector<AccuracyPoint>& points);

/// A configuration chosen for a scene, and how many others are not apart from it.
struct AccuracyChoice {
  const AccuracyPoint* point = nullptr;
  std::size_t alike = 0;
};
/// The least DSSIM at no more than `ms`, of equal ones the cheapest. Fails with the cheapest where all take
/// longer.
Result<AccuracyChoice> bestWithin(std::span<const AccuracyPoint> points, double ms);
/// The fewest milliseconds at no more than `dssim`. Fails with the best where none comes so close.
Result<AccuracyChoice> cheapestFor(std::span<const AccuracyPoint> points, double dssim);

/// accuracy.json, schema 1.
std::string toJson(const AccuracyReport& report);
/// The points of such a file, without pictures. `name` is what an error calls it; errors name the element and
/// its value. What the settings mean is not checked. Of members that are not known nothing is asked.
Result<std::vector<AccuracyPoint>> parseAccuracy(std::string_view text, const std::string& name);
/// The page: no request leaves it, opens from a file.
std::string toHtml(const AccuracyReport& report);

}  // namespace tessera
