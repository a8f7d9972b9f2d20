// tessera compare: the methods side by side on the same frames, as report.json and report.html.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>

#include <fmt/core.h>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/progress.hpp"
#include "apps/tessera/report/report.hpp"
#include "engine/core/file.hpp"
#include "engine/measure/colormap.hpp"
#include "engine/measure/metrics.hpp"
#include "engine/measure/statistics.hpp"

namespace tessera::app {

namespace {

struct CompareOptions {
  std::vector<std::string> scenes;
  std::string output;
  std::vector<std::string> methods = {"forward", "rect", "rect:bias=-2", "rect-deferred", "forward-prepass"};
  int warmup = 2;
  int repeats = 1;
  ContextChoice context;
  SizeChoice size;
  CameraChoice camera;
  StageChoice stage;
  AtlasChoice atlas;
  std::string command;
};

enum class Kind : std::uint8_t { Forward, ForwardPrepass, Rect, RectDeferred };

struct Method {
  std::string name;
  Kind kind = Kind::Forward;
  double bias = 0.0;
  [[nodiscard]] bool usesAtlas() const { return kind == Kind::Rect || kind == Kind::RectDeferred; }
};

Result<Method> parseMethod(const std::string& text, double defaultBias) {
  static const std::map<std::string, Kind> kKinds = {{"forward", Kind::Forward},
                                                     {"forward-prepass", Kind::ForwardPrepass},
                                                     {"rect", Kind::Rect},
                                                     {"rect-deferred", Kind::RectDeferred}};
  const std::size_t colon = text.find(':');
  const auto kind = kKinds.find(text.substr(0, colon));
  if (kind == kKinds.end())
    return fail(
        "--methods {}: not one of forward, forward-prepass, rect, rect-deferred (with :bias=N for rect)",
        text);
  Method method{text, kind->second, defaultBias};
  if (colon == std::string::npos) return method;
  constexpr std::string_view kBias = "bias=";
  const std::string_view option = std::string_view(text).substr(colon + 1);
  const char* end = text.data() + text.size();
  if (!method.usesAtlas() || option.substr(0, kBias.size()) != kBias ||
      std::from_chars(option.data() + kBias.size(), end, method.bias).ptr != end ||
      !(std::abs(method.bias) <= 16.0))
    return fail("--methods {}: after the colon only bias=N, -16 to 16, for rect methods", text);
  return method;
}

/// Everything measured of one method, frame by frame.
struct Series {
  std::map<std::string, std::vector<double>> passes;
  std::vector<std::string> passOrder;
  std::vector<double> frameMs, gatherMs, displayMs, nsPerSample;
  std::vector<double> nsPerPassed, passed, partly;
  std::vector<double> mssim, psnr, flip, samples, allocated, live, patches, triangles, covered, bias;
  double outOfMemory = 0.0;
  double resets = 0.0;
  double holes = 0.0;
  double nonFinite = kNotMeasured;
  std::vector<ReportFrame> pictures;
};

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? kNotMeasured : sum / static_cast<double>(values.size());
}

/// A PSNR of a whole sequence is that of its mean squared error: means of decibels hide the bad frames.
double pooledPsnr(const std::vector<double>& decibels) {
  double mse = 0.0;
  for (const double db : decibels) mse += std::isinf(db) ? 0.0 : std::pow(10.0, -db / 10.0);
  if (decibels.empty()) return kNotMeasured;
  return mse == 0.0 ? std::numeric_limits<double>::infinity()
                    : -10.0 * std::log10(mse / static_cast<double>(decibels.size()));
}

bool isShading(const std::string& pass) { return pass == "gather" || pass == "forward"; }
bool isDisplay(const std::string& pass) {
  return pass.rfind("display", 0) == 0 || pass == "rect-transparent";
}

/// Median over the repeats of each pass, in the order of the first run. By name: a repeat of the same moment
/// keeps the shadow map, and so has one pass less.
std::vector<PassTime> medianTimes(const std::vector<std::vector<PassTime>>& runs) {
  std::vector<PassTime> medians = runs.front();
  for (PassTime& median : medians) {
    std::vector<double> samples;
    for (const auto& run : runs)
      for (const PassTime& time : run)
        if (time.name == median.name) samples.push_back(time.milliseconds);
    median.milliseconds = summarize(samples).median;
  }
  return medians;
}

void record(Series& series, const std::vector<PassTime>& times, std::uint64_t shaded) {
  double total = 0.0;
  double shading = 0.0;
  double display = 0.0;
  for (const PassTime& time : times) {
    if (series.passes.find(time.name) == series.passes.end()) series.passOrder.push_back(time.name);
    series.passes[time.name].push_back(time.milliseconds);
    total += time.milliseconds;
    if (isShading(time.name)) shading += time.milliseconds;
    if (isDisplay(time.name)) display += time.milliseconds;
  }
  series.frameMs.push_back(total);
  series.gatherMs.push_back(shading);
  if (display > 0.0) series.displayMs.push_back(display);
  series.samples.push_back(static_cast<double>(shaded));
  if (shaded > 0) series.nsPerSample.push_back(shading * 1e6 / static_cast<double>(shaded));
}

std::size_t coveredPixels(const Image& image) {
  std::size_t covered = 0;
  for (std::size_t i = 3; i < image.pixels.size(); i += 4) covered += image.pixels[i] > 0 ? 1 : 0;
  return covered;
}

std::size_t holesOf(const Image& reference, const Image& test) {
  std::size_t holes = 0;
  for (std::size_t i = 3; i < reference.pixels.size(); i += 4)
    holes += reference.pixels[i] > 0 && test.pixels[i] == 0 ? 1 : 0;
  return holes;
}

Image halved(const Image& image, int largestSide) {
  Image small = image;
  while (std::max(small.width, small.height) > largestSide && small.width > 1 && small.height > 1) {
    Image next{small.width / 2, small.height / 2, {}};
    next.pixels.resize(static_cast<std::size_t>(next.width) * static_cast<std::size_t>(next.height) * 4);
    for (int y = 0; y < next.height; ++y)
      for (int x = 0; x < next.width; ++x)
        for (int c = 0; c < 4; ++c)
          next.at(x, y)[c] = static_cast<std::uint8_t>(
              (small.at(2 * x, 2 * y)[c] + small.at(2 * x + 1, 2 * y)[c] + small.at(2 * x, 2 * y + 1)[c] +
               small.at(2 * x + 1, 2 * y + 1)[c] + 2) /
              4);
    small = std::move(next);
  }
  return small;
}

// A page of four scenes and five methods stays a page that a browser opens at once.
constexpr int kPictureQuality = 90;
constexpr int kErrorQuality = 75;
constexpr int kAtlasQuality = 80;
constexpr int kAtlasPreview = 2048;
constexpr std::size_t kPictures = 3;

/// The error that the map paints brightest: what a critical eye sees at once.
constexpr float kErrorFull = 0.5f;

std::vector<std::size_t> pictureFrames(std::size_t frames) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < std::min(kPictures, frames); ++i)
    chosen.push_back(frames <= kPictures ? i : (2 * i + 1) * frames / (2 * kPictures));
  return chosen;
}

class SceneComparison {
 public:
  SceneComparison(Engine& engine, const std::vector<TimedView>& views, const CompareOptions& options)
      : engine_(engine), views_(views), options_(options), chosen_(pictureFrames(views.size())) {}

  Result<Series> run(const Method& method, Progress& progress) {
    Series series;
    if (method.usesAtlas() && engine_.atlas() != nullptr) {
      engine_.atlas()->memory().setBias(static_cast<float>(method.bias));
      engine_.atlas()->memory().reset();
    }
    for (int i = 0; i < options_.warmup; ++i) draw(method, views_.front());
    const double resetsBefore = resets();
    for (std::size_t f = 0; f < views_.size(); ++f) {
      if (auto done = frame(method, f, series); !done) return tl::unexpected(done.error());
      progress.step(fmt::format("{} frame {}", method.name, f + 1));
    }
    if (method.usesAtlas()) series.resets = resets() - resetsBefore;
    return series;
  }

 private:
  void draw(const Method& method, const TimedView& timed) {
    engine_.clearTimes();
    engine_.update(timed.time);
    switch (method.kind) {
      case Kind::Forward:
        engine_.forward(timed.view, false);
        break;
      case Kind::ForwardPrepass:
        engine_.forward(timed.view, true);
        break;
      case Kind::Rect:
        engine_.rect(timed.view, DisplayMode::Geometry);
        break;
      case Kind::RectDeferred:
        engine_.rect(timed.view, DisplayMode::Deferred);
        break;
    }
  }

  [[nodiscard]] double resets() {
    return engine_.atlas() == nullptr
               ? 0.0
               : static_cast<double>(engine_.atlas()->memory().readStatistics().resets);
  }

  Result<void> frame(const Method& method, std::size_t f, Series& series) {
    const TimedView& timed = views_[f];
    std::vector<std::vector<PassTime>> runs;
    for (int repeat = 0; repeat < options_.repeats; ++repeat) {
      draw(method, timed);
      runs.push_back(engine_.times());
    }
    // Forward counts fragment-shader invocations. The atlas shades each allocated texel once, whatever the
    // rasterizer runs besides (some count the unlit lanes of its 2 x 2 quads).
    const std::uint64_t shaded = method.usesAtlas() && engine_.atlas() != nullptr
                                     ? engine_.atlas()->memory().readStatistics().samples
                                     : engine_.fragments();
    record(series, medianTimes(runs), shaded);
    if (!method.usesAtlas() && engine_.samplesPassed() > 0) {
      series.passed.push_back(static_cast<double>(engine_.samplesPassed()));
      series.nsPerPassed.push_back(series.gatherMs.back() * 1e6 / series.passed.back());
    }
    const Image picture = engine_.readColor();
    if (references_.size() <= f) references_.push_back(picture);
    const Image& reference = references_[f];
    auto similarity = mssim(reference, picture);
    auto ratio = psnr(reference, picture);
    auto difference = flip(reference, picture);
    if (!similarity || !ratio || !difference) return fail("frame {}: pictures cannot be compared", f);
    series.mssim.push_back(similarity->mean);
    series.psnr.push_back(*ratio);
    series.flip.push_back(difference->mean);
    series.covered.push_back(static_cast<double>(coveredPixels(reference)));
    series.holes += static_cast<double>(holesOf(reference, picture));
    if (method.usesAtlas() && engine_.atlas() != nullptr) {
      const RectStatistics stats = engine_.atlas()->memory().readStatistics();
      series.allocated.push_back(static_cast<double>(stats.samples));
      series.live.push_back(static_cast<double>(stats.liveTexels));
      series.partly.push_back(static_cast<double>(engine_.samplesPartlyInView(timed.view)));
      series.patches.push_back(static_cast<double>(stats.visiblePatches));
      series.triangles.push_back(static_cast<double>(engine_.visibleTriangles()));
      series.bias.push_back(static_cast<double>(stats.bias));
      series.outOfMemory += static_cast<double>(stats.failures);
      if (engine_.atlas()->format() == AtlasFormat::Rgba16f)
        series.nonFinite = (f == 0 ? 0.0 : series.nonFinite) + static_cast<double>(engine_.nonFiniteTexels());
    }
    if (std::find(chosen_.begin(), chosen_.end(), f) != chosen_.end()) {
      ReportFrame pictures;
      pictures.frame = static_cast<int>(f);
      pictures.image = encodeJpeg(picture, kPictureQuality).value_or(std::vector<std::uint8_t>());
      pictures.error =
          encodeJpeg(errorMap(*difference, kErrorFull), kErrorQuality).value_or(std::vector<std::uint8_t>());
      // One atlas picture a method: the page shows it beside every frame.
      if (method.usesAtlas() && engine_.atlas() != nullptr && series.pictures.empty())
        pictures.atlas = encodeJpeg(halved(engine_.readAtlas(), kAtlasPreview), kAtlasQuality)
                             .value_or(std::vector<std::uint8_t>());
      series.pictures.push_back(std::move(pictures));
    }
    return {};
  }

  Engine& engine_;
  const std::vector<TimedView>& views_;
  const CompareOptions& options_;
  std::vector<std::size_t> chosen_;
  std::vector<Image> references_;  // forward's pictures: the first method that runs is forward
};

ReportMethod reportOf(const Method& method, Series series) {
  ReportMethod report;
  report.name = method.name;
  report.mssim = mean(series.mssim);
  report.psnrDb = pooledPsnr(series.psnr);
  report.flip = mean(series.flip);
  report.samplesShaded = mean(series.samples);
  report.samplesPassed = mean(series.passed);
  report.nsPerPassed = summarize(series.nsPerPassed).median;
  report.coveredPixels = mean(series.covered);
  report.holes = series.holes;
  if (method.usesAtlas()) {
    report.samplesAllocated = mean(series.allocated);
    report.samplesPartlyInView = mean(series.partly);
    report.atlasTexelsUsed = mean(series.live);
    report.visiblePatches = mean(series.patches);
    report.visibleTriangles = mean(series.triangles);
    report.outOfMemory = series.outOfMemory;
    report.resets = series.resets;
    report.nonFiniteTexels = series.nonFinite;
  }
  for (const std::string& name : series.passOrder)
    report.passes.push_back({name, summarize(series.passes[name])});
  report.frameMs = summarize(series.frameMs);
  report.gatherMs = summarize(series.gatherMs);
  report.displayMs = summarize(series.displayMs);
  report.nsPerSample = summarize(series.nsPerSample).median;
  report.series = {series.frameMs, series.mssim, series.flip, series.samples, series.live, series.bias};
  report.frames = std::move(series.pictures);
  return report;
}

Result<ReportScene> compareScene(gl::Context& context, const std::string& file,
                                 const std::vector<Method>& methods, const CompareOptions& options,
                                 glm::ivec2 size) {
  StageChoice stageChoice = options.stage;
  if (stageChoice.file.empty())
    if (const auto shipped = shippedStage(file)) stageChoice.file = shipped->string();
  auto stage = loadStageOf(stageChoice);
  if (!stage) return tl::unexpected(stage.error());
  auto setup = engineOptions(options.atlas);
  if (!setup) return tl::unexpected(setup.error());
  ReportScene report;
  std::vector<TimedView> views;
  std::unique_ptr<Engine> engine;
  {
    Progress loading(file);
    const auto step = [&](const std::string& text) { loading.step(text); };
    auto scene = loadGltf(file, {.loadImages = true, .progress = step});
    if (!scene) return tl::unexpected(scene.error());
    CameraChoice camera = options.camera;
    const Stage* lit = *stage ? &**stage : nullptr;
    const auto named = [&](const CameraPath& path) { return path.name == camera.path; };
    const bool onStage = lit != nullptr && std::any_of(lit->paths.begin(), lit->paths.end(), named);
    // A scene without a stage is seen by its first camera, or from outside.
    if (camera.path == "tour" && !onStage) camera.path.clear();
    if (onStage) {
      // The whole path, however few frames: short runs see as much of the scene as long ones.
      const CameraPath& path = *std::find_if(lit->paths.begin(), lit->paths.end(), named);
      const double duration = path.keys.back().time - path.keys.front().time;
      if (options.camera.fps <= 0.0 && duration > 0.0) camera.fps = std::max(camera.frames - 1, 1) / duration;
    }
    if (camera.fps <= 0.0) camera.fps = 30.0;
    auto found = viewsOf(camera, *scene, lit, size);
    if (!found) return tl::unexpected(found.error());
    views = std::move(*found);
    report.file = file;
    report.triangles = scene->triangleCount();
    report.instances = scene->instances.size();
    report.materials = scene->materials.size();
    SceneState state;
    evaluate(*scene, 0.0, state);
    report.lights = evaluateLights(*scene, state, lit, 0.0).size();
    report.note = fmt::format(
        "{}; path {}; atlas {} x {}",
        lit != nullptr ? "stage " + std::filesystem::path(lit->file).filename().string() : "no stage",
        camera.path.empty() ? "none" : camera.path, setup->atlas.memory.width, setup->atlas.memory.height);
    setup->request = {};
    for (const Method& method : methods) {
      setup->request.forward = setup->request.forward || !method.usesAtlas();
      setup->request.depthPrepass = setup->request.depthPrepass || method.kind == Kind::ForwardPrepass;
      setup->request.rect = setup->request.rect || method.usesAtlas();
      setup->request.displayDeferred = setup->request.displayDeferred || method.kind == Kind::RectDeferred;
    }
    setup->timePasses = true;
    setup->countFragments = true;
    setup->progress = step;
    auto made = Engine::create(context, std::move(*scene), std::move(*stage), *setup);
    if (!made) return tl::unexpected(made.error());
    engine = std::move(*made);
  }
  report.width = size.x;
  report.height = size.y;
  report.frames = static_cast<int>(views.size());
  report.errorMetric = "FLIP";
  report.errorFull = static_cast<double>(kErrorFull);
  Progress progress(std::filesystem::path(file).filename().string(), methods.size() * views.size());
  SceneComparison comparison(*engine, views, options);
  for (const Method& method : methods) {
    auto series = comparison.run(method, progress);
    if (!series) return fail("{}: {}: {}", file, method.name, series.error().message);
    report.methods.push_back(reportOf(method, std::move(*series)));
  }
  return report;
}

void printSummary(const ReportScene& scene) {
  fmt::print("{} ({} triangles, {} frames of {} x {})\n", scene.file, scene.triangles, scene.frames,
             scene.width, scene.height);
  fmt::print("  {:<18} {:>7} {:>9} {:>7} {:>12} {:>10} {:>11} {:>6}\n", "method", "MSSIM", "PSNR dB", "FLIP",
             "samples", "frame ms", "ns/sample", "holes");
  for (const ReportMethod& m : scene.methods)
    fmt::print("  {:<18} {:>7.4f} {:>9.2f} {:>7.4f} {:>12.0f} {:>10.1f} {:>11.1f} {:>6.0f}\n", m.name,
               m.mssim, m.psnrDb, m.flip, m.samplesShaded, m.frameMs.median, m.nsPerSample, m.holes);
}

Result<void> compare(const CompareOptions& options) {
  auto size = parseSize(options.size.text);
  if (!size) return tl::unexpected(size.error());
  std::vector<Method> methods;
  for (const std::string& text : options.methods) {
    auto method = parseMethod(text, options.atlas.bias);
    if (!method) return tl::unexpected(method.error());
    methods.push_back(*method);
  }
  // Everything is compared with forward, so it runs first, asked for or not.
  const auto forward =
      std::find_if(methods.begin(), methods.end(), [](const Method& m) { return m.kind == Kind::Forward; });
  if (forward == methods.end())
    methods.insert(methods.begin(), Method{"forward", Kind::Forward, 0.0});
  else
    std::rotate(methods.begin(), forward, forward + 1);
  std::error_code error;
  std::filesystem::create_directories(options.output, error);
  if (error) return fail("{}: cannot be created ({})", options.output, error.message());
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());

  Report report;
  const gl::ContextInfo& info = (*context)->info();
  report.context = {
      info.backendName, info.renderer, info.version, info.glslVersion, gl::nameOf(gl::timerModeFor(info)), {},
      options.command};
  for (const std::string& file : options.scenes) {
    auto scene = compareScene(**context, file, methods, options, *size);
    if (!scene) return tl::unexpected(scene.error());
    printSummary(*scene);
    report.scenes.push_back(std::move(*scene));
  }
  const std::filesystem::path folder(options.output);
  if (auto written = writeFile(folder / "report.json", toJson(report)); !written) return written;
  if (auto written = writeFile(folder / "report.html", toHtml(report)); !written) return written;
  fmt::print("{}\n", (folder / "report.html").string());
  return {};
}

}  // namespace

Run addCompare(CLI::App& app) {
  auto options = std::make_shared<CompareOptions>();
  options->camera.path = "tour";
  options->camera.frames = 12;
  options->camera.fps = 0.0;  // unless given: as it takes to see the whole path
  CLI::App& command = *app.add_subcommand(
      "compare", "Draw the same frames by several methods; writes report.json and report.html");
  command.add_option("scenes", options->scenes, "glTF 2.0 files")->required();
  command.add_option("-o,--output", options->output, "folder for the report")->required();
  command
      .add_option("--methods", options->methods,
                  "comma-separated: forward, forward-prepass, rect, rect-deferred; rect ones take :bias=N")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--warmup", options->warmup, "frames drawn and thrown away before each method")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  command
      .add_option("--repeats", options->repeats, "times each frame is drawn; the median of each pass counts")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  addContext(command, options->context);
  addSize(command, options->size);
  addCamera(command, options->camera);
  addStage(command, options->stage);
  addAtlas(command, options->atlas);
  return [options] {
    options->command = "tessera compare";
    for (const std::string& scene : options->scenes)
      options->command += " " + std::filesystem::path(scene).filename().string();
    return compare(*options);
  };
}

}  // namespace tessera::app
