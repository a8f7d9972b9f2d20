// The comparison report: what was measured, as report.json and as one self-contained page.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "engine/measure/statistics.hpp"

namespace tessera {

/// A number that was not measured or does not apply to a method: null in report.json, a dash on the page.
inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// Where the numbers were made. Plain text, any of them may be empty.
struct ReportContext {
  std::string backend;   // "osmesa", "egl"
  std::string renderer;  // GL_RENDERER
  std::string gl;        // GL_VERSION
  std::string glsl;      // GL_SHADING_LANGUAGE_VERSION
  std::string timer;     // how milliseconds were taken: "timer query", "glFinish and CPU clock"
  std::string commit;    // of the program
  std::string command;   // that made the report
};

struct ReportPass {
  std::string name;
  Statistics ms;  // over the measured frames
};

/// One value per measured frame, all of them of the same length or empty. NaN leaves a gap in a chart.
struct ReportSeries {
  std::vector<double> frameMs;
  std::vector<double> mssim;
  std::vector<double> flip;
  std::vector<double> samplesShaded;
  std::vector<double> atlasTexelsUsed;
  std::vector<double> bias;  // level bias in force, memory pressure included
};

/// The pictures of one measured frame: PNG or JPEG bytes. An empty one is not there.
struct ReportFrame {
  int frame = 0;                    // index into the series
  std::vector<std::uint8_t> image;  // what the method displayed
  std::vector<std::uint8_t> error;  // its error against forward, coloured by errorMap
  std::vector<std::uint8_t> atlas;  // the shading atlas; any size
};

/// One method on one scene. Counts are means per measured frame unless they say otherwise.
struct ReportMethod {
  std::string name;              // "forward" is what the others are compared with
  double mssim = kNotMeasured;   // mean against forward
  double psnrDb = kNotMeasured;  // infinite where every picture equals forward's: null in report.json
  double flip = kNotMeasured;
  double samplesShaded = kNotMeasured;
  double samplesPassed = kNotMeasured;  // forward: of the samples, those that the depth test let through
  double samplesPartlyInView = kNotMeasured;  // of the samples, those of patches that leave the picture
  double samplesAllocated = kNotMeasured;
  double atlasTexelsUsed = kNotMeasured;
  double visiblePatches = kNotMeasured;
  double visibleTriangles = kNotMeasured;
  double coveredPixels = kNotMeasured;    // pixels of the picture with a surface
  double outOfMemory = kNotMeasured;      // patches that got no block, over all frames
  double resets = kNotMeasured;           // of the atlas, over all frames
  double holes = kNotMeasured;            // pixels that forward covers and this does not, over all frames
  double nonFiniteTexels = kNotMeasured;  // over all frames
  std::vector<ReportPass> passes;         // in the order they ran
  Statistics frameMs;
  Statistics gatherMs;
  Statistics displayMs;
  double nsPerSample = kNotMeasured;  // shading time over samples shaded
  double nsPerPassed = kNotMeasured;  // forward: shading time over samples passed
  ReportSeries series;
  std::vector<ReportFrame> frames;  // chosen frames, rising
};

struct ReportScene {
  std::string file;
  std::string note;  // stage, camera path, atlas size: one line
  std::uint64_t triangles = 0;
  std::uint64_t instances = 0;
  std::uint64_t materials = 0;
  std::uint64_t lights = 0;
  int width = 0;  // of the pictures, in pixels
  int height = 0;
  int frames = 0;                    // measured
  std::string errorMetric = "FLIP";  // what the error pictures show
  double errorFull = 1.0;            // the error with the brightest colour
  std::vector<ReportMethod> methods;
};

struct Report {
  ReportContext context;
  std::vector<ReportScene> scenes;
};

/// report.json, schema 1, indented. Bytes in strings that are not UTF-8 are replaced by U+FFFD.
std::string toJson(const Report& report);
/// The page: no request leaves it, opens from a file. Strings are escaped, whatever they hold.
std::string toHtml(const Report& report);

}  // namespace tessera
