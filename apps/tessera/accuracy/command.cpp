// tessera accuracy: what accuracy costs in time, as accuracy.json and accuracy.html.
#include <algorithm>
#include <memory>
#include <random>

#include <fmt/ranges.h>

#include "apps/tessera/accuracy/measure.hpp"
#include "apps/tessera/accuracy/plan.hpp"
#include "apps/tessera/commands.hpp"
#include "apps/tessera/compare/pictures.hpp"
#include "apps/tessera/compare/runs.hpp"
#include "apps/tessera/progress.hpp"
#include "apps/tessera/report_output.hpp"

namespace tessera::app {

namespace {

struct AccuracyOptions {
  std::vector<std::string> scenes;
  std::string output;
  bool quick = false;
  std::vector<std::string> knobs;  // none: all
  int places = 4;
  int repeats = 5;
  int combinations = 40;
  unsigned seed = 1;
  MeasureOptions measure;
  ContextChoice context;
  SizeChoice size{"960x540"};
  CameraChoice camera;
  StageChoice stage;
  std::string command;
};

constexpr int kFrontQuality = 88;  // of JPEG
constexpr int kOtherQuality = 72;
constexpr int kErrorQuality = 75;
constexpr int kOtherSide = 480;  // pixels, at most, of pictures that are on no front

/// In a row at each place of the path, so that what an atlas keeps from frame to frame counts.
constexpr std::size_t kFramesInRow = 2;

/// Rows of frames at so many places along all of them.
std::vector<TimedView> pickViews(const std::vector<TimedView>& all, std::size_t places) {
  if (all.size() <= places * kFramesInRow) return all;
  std::vector<TimedView> views;
  const std::size_t last = all.size() - kFramesInRow;
  for (std::size_t p = 0; p < places; ++p)
    for (std::size_t i = 0; i < kFramesInRow; ++i)
      // Not at the very ends, where paths often rest.
      views.push_back(all[(2 * p + 1) * last / (2 * places) + i]);
  return views;
}

/// All runs of one configuration.
struct Runs {
  std::vector<double> ms, dssim;
};

class SceneStudy {
 public:
  SceneStudy(Measuring& measuring, Plan plan, const AccuracyOptions& options, AccuracyScene& scene)
      : measuring_(measuring), plan_(std::move(plan)), options_(options), scene_(scene) {}

  void run() {
    std::mt19937 random(options_.seed);
    const auto repeats = static_cast<std::size_t>(options_.repeats);
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < plan_.configurations.size(); ++i) order.insert(order.end(), repeats, i);
    measure("knobs", order, random);
    order.clear();
    const std::vector<Measured> singles = measured();
    for (const Settings& settings : worthCombining(singles, static_cast<std::size_t>(options_.combinations)))
      if (auto index = plan_.add(settings)) order.insert(order.end(), repeats, *index);
    if (!order.empty()) {
      // What they compete with runs again beside them: the machine may have changed since.
      std::vector<Tradeoff> trades;
      for (const Measured& single : singles) trades.push_back(single.trade);
      for (const std::size_t i : paretoFront(trades))
        if (auto index = plan_.add(singles[i].settings)) order.insert(order.end(), repeats, *index);
      measure("combinations", order, random);
    }
    finish();
  }

 private:
  /// In random order: a drift of the machine is not taken for a trend.
  void measure(const char* what, std::vector<std::size_t> order, std::mt19937& random) {
    Progress progress(scene_.file + " " + what, order.size());
    std::shuffle(order.begin(), order.end(), random);
    runs_.resize(plan_.configurations.size());
    points_.resize(plan_.configurations.size());
    failed_.resize(plan_.configurations.size());
    for (const std::size_t i : order) {
      progress.step(nameOf(plan_.configurations[i]));
      if (failed_[i]) continue;
      auto configuration = configurationOf(plan_.configurations[i]);
      auto result = configuration ? measuring_.run(*configuration, runs_[i].ms.empty())
                                  : Result<RunResult>(tl::unexpected(configuration.error()));
      if (!result) {
        failed_[i] = true;
        scene_.skipped.push_back(nameOf(plan_.configurations[i]) + ": " + result.error().message);
        continue;
      }
      if (runs_[i].ms.empty()) describe(*result, points_[i]);
      runs_[i].ms.push_back(result->ms);
      runs_[i].dssim.push_back(result->dssim);
    }
  }

  static void describe(const RunResult& result, AccuracyPoint& point) {
    using Bytes = std::vector<std::uint8_t>;
    point.samples = result.samples;
    point.texels = result.texels;
    point.bytes = result.bytes;
    point.psnrDb = result.psnrDb;
    point.flip = result.flip;
    point.image = encodeJpeg(result.picture, kFrontQuality).value_or(Bytes());
    point.error = encodeJpeg(result.error, kErrorQuality).value_or(Bytes());
    point.smallImage = encodeJpeg(halved(result.picture, kOtherSide), kOtherQuality).value_or(Bytes());
    point.smallError = encodeJpeg(halved(result.error, kOtherSide), kOtherQuality).value_or(Bytes());
  }

  [[nodiscard]] std::vector<Measured> measured() const {
    std::vector<Measured> all;
    for (std::size_t i = 0; i < runs_.size(); ++i)
      if (!failed_[i])
        all.push_back({plan_.configurations[i], {spreadOf(runs_[i].ms), spreadOf(runs_[i].dssim)}});
    return all;
  }

  void finish() {
    std::vector<std::size_t> placeOf(plan_.configurations.size());
    for (std::size_t i = 0; i < plan_.configurations.size(); ++i) {
      if (failed_[i]) continue;
      AccuracyPoint& point = points_[i];
      point.scene = scene_.file;
      point.name = nameOf(plan_.configurations[i]);
      point.config = plan_.configurations[i];
      point.ms = spreadOf(runs_[i].ms);
      point.dssim = spreadOf(runs_[i].dssim);
      point.runs = static_cast<int>(runs_[i].ms.size());
      placeOf[i] = scene_.points.size();
      scene_.points.push_back(std::move(point));
    }
    findFront(scene_.points);
    for (const PlannedCurve& planned : plan_.curves) {
      const Knob& knob = knobs()[planned.knob];
      if (scene_.knobs.empty() || scene_.knobs.back().name != knob.name)
        scene_.knobs.push_back({knob.name, knob.label, knob.sentence, {}});
      AccuracyCurve curve{
          planned.knob == 0 ? std::string() : nameOf(planned.with), {}, {}, planned.values[planned.standard]};
      for (std::size_t v = 0; v < planned.points.size(); ++v) {
        if (failed_[planned.points[v]]) continue;
        curve.values.push_back(planned.values[v]);
        curve.points.push_back(placeOf[planned.points[v]]);
      }
      scene_.knobs.back().curves.push_back(std::move(curve));
    }
  }

  Measuring& measuring_;
  Plan plan_;
  const AccuracyOptions& options_;
  AccuracyScene& scene_;
  std::vector<Runs> runs_;
  std::vector<AccuracyPoint> points_;
  std::vector<bool> failed_;
};

Result<AccuracyScene> studyScene(gl::Context& context, const std::string& file, const Plan& plan,
                                 const AccuracyOptions& options, glm::ivec2 size) {
  AccuracyScene scene;
  Result<MeasuredScene> measured;
  Result<Measuring> measuring = fail("not loaded");
  {
    Progress loading(file);
    const auto step = [&](const std::string& text) { loading.step(text); };
    measured = loadMeasured(file, options.stage, options.camera, size, step);
    if (!measured) return tl::unexpected(measured.error());
    measured->views = pickViews(measured->views, static_cast<std::size_t>(options.places));
    measuring = Measuring::create(context, *measured, options.measure, step);
    if (!measuring) return fail("{}: {}", file, measuring.error().message);
  }
  scene.file = std::filesystem::path(file).filename().string();
  scene.note = fmt::format("{}, path {}", measured->stageNote, measured->path);
  scene.triangles = measured->scene.triangleCount();
  scene.width = size.x;
  scene.height = size.y;
  scene.frames = static_cast<int>(measured->views.size());
  scene.supersampling = options.measure.supersampling;
  scene.errorFull = static_cast<double>(kErrorFull);
  scene.reference = encodeJpeg(measuring->reference(), kFrontQuality).value_or(std::vector<std::uint8_t>());
  SceneStudy(*measuring, plan, options, scene).run();
  if (scene.points.empty())
    return fail("{}: no configuration could be measured; {}", file, scene.skipped.front());
  return scene;
}

/// One line for the terminal.
void printSummary(const AccuracyScene& scene) {
  std::size_t front = 0;
  std::size_t told = 0;
  for (const AccuracyPoint& point : scene.points) {
    front += point.pareto ? 1 : 0;
    told += point.distinguishable ? 1 : 0;
  }
  fmt::print("{}: {} configurations, {} on the front, {} of them to be told apart\n", scene.file,
             scene.points.size(), front, told);
  for (const std::string& skipped : scene.skipped) fmt::print("  not measured: {}\n", skipped);
}

/// The plan without the knobs that were not asked for.
Result<Plan> planOf(const AccuracyOptions& options) {
  for (const std::string& name : options.knobs) {
    std::vector<std::string> names;
    for (const Knob& knob : knobs()) names.push_back(knob.name);
    if (std::find(names.begin(), names.end(), name) == names.end())
      return fail("--knobs {}: not one of {}", name, fmt::join(names, ", "));
  }
  return planSweep(options.quick, options.knobs);
}

Result<void> accuracy(const AccuracyOptions& options) {
  auto size = parseSize(options.size.text);
  if (!size) return tl::unexpected(size.error());
  auto plan = planOf(options);
  if (!plan) return tl::unexpected(plan.error());
  auto files = ReportFiles::create(options.output, "accuracy");
  if (!files) return tl::unexpected(files.error());
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());
  AccuracyReport report;
  report.context = reportContext((*context)->info(), options.command);
  report.settings = fmt::format(
      "{} runs of each configuration in random order (seed {}), medians and quartiles; {} frame of warm-up "
      "each; up to {} "
      "combinations",
      options.repeats, options.seed, options.measure.warmup, options.combinations);
  for (const std::string& file : options.scenes) {
    auto scene = studyScene(**context, file, *plan, options, *size);
    if (!scene) return tl::unexpected(scene.error());
    printSummary(*scene);
    report.scenes.push_back(std::move(*scene));
  }
  return files->write(toJson(report), toHtml(report));
}

}  // namespace

Run addAccuracy(CLI::App& app) {
  auto options = std::make_shared<AccuracyOptions>();
  options->camera.pathUnlessChosen = "tour";
  CLI::App& command = *app.add_subcommand(
      "accuracy", "Turn every knob that trades accuracy for time; writes accuracy.json and accuracy.html");
  command.add_option("scenes", options->scenes, "glTF 2.0 files")->required();
  command.add_option("-o,--output", options->output, "folder for the report")->required();
  command.add_flag(
      "--quick", options->quick,
      "minutes instead of an hour: fewer knobs and values, and unless given 480x270, 3 places, 3 "
      "repeats and 10 combinations");
  auto* places =
      command
          .add_option(
              "--places", options->places,
              "along the camera path, two frames in a row at each; --frames and --fps make the path's frames")
          ->check(CLI::Range(1, 1000))
          ->capture_default_str();
  command.add_option("--knobs", options->knobs, "comma-separated: of the knobs, these alone")->delimiter(',');
  auto* repeats =
      command.add_option("--repeats", options->repeats, "runs of each configuration over the frames")
          ->check(CLI::Range(1, 100))
          ->capture_default_str();
  auto* combinations = command
                           .add_option("--combinations", options->combinations,
                                       "of settings that did well alone, at most so many")
                           ->check(CLI::Range(0, 1000))
                           ->capture_default_str();
  command.add_option("--seed", options->seed, "of the order of the runs")->capture_default_str();
  command
      .add_option("--supersampling", options->measure.supersampling,
                  "samples a pixel of the reference, a side: 4 are 16 samples")
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
  command.add_option("--warmup", options->measure.warmup, "frames drawn and thrown away before each run")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  addContext(command, options->context);
  addSize(command, options->size);
  addCamera(command, options->camera);
  addStage(command, options->stage);
  const auto* size = command.get_option("--size");
  return [=](const std::string& line) {
    if (options->quick) {
      if (size->count() == 0) options->size.text = "480x270";
      if (places->count() == 0) options->places = 3;
      if (repeats->count() == 0) options->repeats = 3;
      if (combinations->count() == 0) options->combinations = 10;
    }
    options->command = line;
    return accuracy(*options);
  };
}

}  // namespace tessera::app
