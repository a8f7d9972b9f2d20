// The comparison report: what was measured, as report.json and as one self-contained page.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
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

/// Samples of one kind, see GatherKind.
struct ReportKind {
  std::string name;
  std::string color;  // "#rrggbb" in the picture of the atlas by kind
  double samples = 0.0;
};

/// How densely samples fill their places in the atlas, see GatherPacking.
struct ReportPacking {
  std::string name;
  double samples = 0.0;
  double texels = 0.0;
};

/// What a method costs and shows with one constant bias.
struct ReportCurvePoint {
  double bias = 0.0;  // log2 of area
  double samplesPerPixel = 0.0;
  double mssim = 0.0;
  double gatherMs = kNotMeasured;
};

/// The visible set of a camera that may move and turn this far, see Pvs.
struct ReportPvs {
  std::string method;    // the one of the scene without it
  double radius = 0.0;   // in the scene's unit
  double degrees = 0.0;  // in all
  int views = 0;         // sampled, the picture's own included
};

/// One method on one scene. Counts are means per measured frame unless they say otherwise.
struct ReportMethod {
  std::string name;
  std::string reference = "forward";  // the method of the scene that it is compared with; may be itself
  int views = 1;                      // pictures a frame: 2 for stereo, whose counts are of both
  double mssim = kNotMeasured;        // mean against the reference
  std::vector<double> mssimViews;     // of each picture, the left eye first
  double mssimAcuity = kNotMeasured;  // see acuityMssim; of foveated methods
  double psnrDb = kNotMeasured;       // infinite where every picture equals forward's: null in report.json
  double flip = kNotMeasured;
  double samplesShaded = kNotMeasured;
  double invocations = kNotMeasured;    // of the fragment shader, as GL counts them
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
  // Of methods that fill an atlas.
  std::vector<ReportKind> kinds;  // their samples sum to samplesShaded
  std::vector<ReportPacking> packings;
  double slantedShare = kNotMeasured;     // of the visible triangles, those sampled as slanted ones
  double takenTexels = kNotMeasured;      // of the atlas: what is not free for places of any size
  double displayBytes = kNotMeasured;     // a frame, that display reads
  double decodeBytes = kNotMeasured;      // of them, those that say where texels lie
  double constantBias = kNotMeasured;     // asked for
  double equalSamples = kNotMeasured;     // where the bias was set for it: samples against atlasReference's
  std::vector<ReportCurvePoint> curve;    // rising in bias
  std::vector<std::uint8_t> kindPicture;  // the fullest part of the atlas coloured by kind, PNG
  ReportSeries series;
  std::vector<ReportFrame> frames;  // chosen frames, rising
};

/// The same place of a frame by several methods.
struct ReportCrop {
  struct Picture {
    std::string method;
    double mssim = kNotMeasured;      // of the crop alone, against the reference
    std::vector<std::uint8_t> image;  // PNG
  };
  int frame = 0;
  int x = 0;  // pixels from the top left
  int y = 0;
  int width = 0;
  int height = 0;
  double slantedShare = 0.0;      // of its pixels, those of slanted triangles
  std::vector<Picture> pictures;  // the reference first
};

/// A method with the visible set of a camera that moves.
struct ReportPvsRow {
  ReportPvs pvs;
  ReportMethod method;
};

/// A method's bar in a figure.
struct ReportBar {
  std::string method;  // its name in the scenes
  std::string label;
};

/// Bars of shading work and of quality, a group a scene.
struct ReportFigure {
  std::string id;  // "4.1"
  std::string title;
  std::string text;  // what is shown and how it was measured, a few sentences
  std::vector<ReportBar> bars;
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
  std::string atlasReference;  // the method that others which fill an atlas are compared with; may be none
  std::vector<ReportPvsRow> pvs;
  std::vector<ReportCrop> crops;  // where most is slanted
};

struct Report {
  ReportContext context;
  std::vector<ReportScene> scenes;
  std::vector<ReportFigure> figures;
};

// What a method shades, against something. Samples are those that had to be shaded: what passed the depth
// test on the screen (drawing order decides how much, GL's count of invocations adds what the rasterizer
// shades for nothing), and every texel that the atlas allocated.

/// Samples a frame.
double shadedSamples(const ReportMethod& method);
/// Samples for each pixel of one picture, as the figures of Mueller 2021, ch. 4 have it, also for a pair.
double shadedPerTargetPixel(const ReportScene& scene, const ReportMethod& method);
/// Samples for each pixel of all pictures of the frame.
double shadedPerPicturePixel(const ReportScene& scene, const ReportMethod& method);
/// Samples against those of the method's reference; not a number without one.
double shadedAgainstReference(const ReportScene& scene, const ReportMethod& method);
/// A pass' share of the frame, of medians; not a number where the method has no such pass. "levels" and
/// "memory", which is request, provision, assign, plan and merge, are what managing the atlas takes.
double passShare(const ReportMethod& method, std::string_view pass);
/// Shading a sample against forward's, by what it counts as a sample: one that passed the depth test, or one
/// invocation of the fragment shader.
double perSampleAgainstPassed(const ReportScene& scene, const ReportMethod& method);
double perSampleAgainstInvocation(const ReportScene& scene, const ReportMethod& method);
double dssimOf(const ReportMethod& method);
/// Mean of the level bias over the frames, memory pressure included.
double biasInForce(const ReportMethod& method);
/// Display against that of the scene's atlasReference.
double displayAgainstAtlas(const ReportScene& scene, const ReportMethod& method);
/// Taken texels of the atlas without a sample.
double wastedTexels(const ReportMethod& method);
/// Bytes for each visible triangle.
double decodeBytesPerTriangle(const ReportMethod& method);
double displayBytesPerTriangle(const ReportMethod& method);
/// Samples and DSSIM of a row against those of its method without a set; not a number without one.
double samplesAgainstPlain(const ReportScene& scene, const ReportPvsRow& row);
double dssimAgainstPlain(const ReportScene& scene, const ReportPvsRow& row);
/// What a method would have, between the points of its curve: MSSIM at so many samples a pixel, and samples a
/// pixel at such an MSSIM. Not a number beyond them.
double curveMssimAt(const ReportMethod& method, double samplesPerPixel);
double curveSamplesAt(const ReportMethod& method, double mssim);
/// MSSIM of the right eye alone, the one that warping makes; not a number but of a pair.
double mssimOfRightEye(const ReportMethod& method);
/// The method of this name; null if the scene has none.
const ReportMethod* methodNamed(const ReportScene& scene, std::string_view name);
/// The method that this one is compared with; null if the scene has none of that name.
const ReportMethod* referenceOf(const ReportScene& scene, const ReportMethod& method);

/// report.json, schema 1, indented. Bytes in strings that are not UTF-8 are replaced by U+FFFD.
std::string toJson(const Report& report);
/// The page: no request leaves it, opens from a file. Strings are escaped, whatever they hold.
std::string toHtml(const Report& report);

}  // namespace tessera
