// tessera pvs: how well potentially visible sets at predicted views fit what is shown within the latency.
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>

#include <fmt/format.h>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/measured_scene.hpp"
#include "apps/tessera/progress.hpp"
#include "apps/tessera/pvs/measure.hpp"
#include "apps/tessera/report_output.hpp"
#include "engine/core/file.hpp"

namespace tessera::app {

namespace {

struct PvsCommand {
  std::vector<std::string> scenes;
  std::vector<std::string> predictions = {"none", "linear", "reference"};
  std::vector<double> margins = {0.0, glm::degrees(PvsOptions().margin)};
  std::vector<int> steps = {PvsOptions().steps};
  double latencyMs = 1e3 * PvsOptions().latency;
  PvsSampling sampling;
  double speed = 1.0;
  std::string headTurn;  // "degrees,hertz"
  std::string element = "patch";
  std::string output;
  std::string json;
  std::string command;
  ContextChoice context;
  SizeChoice size;
  CameraChoice camera;
  StageChoice stage;
};

/// Every combination that differs: without prediction there are no steps.
Result<std::vector<PvsOptions>> waysOf(const PvsCommand& command) {
  std::vector<PvsOptions> ways;
  for (const std::string& name : command.predictions) {
    const Prediction prediction = predictions().at(name);
    for (const double degrees : command.margins)
      for (const int& steps : command.steps) {
        if (prediction == Prediction::None && &steps != &command.steps.front()) continue;
        const PvsOptions options{.prediction = prediction,
                                 .latency = 1e-3 * command.latencyMs,
                                 .steps = steps,
                                 .margin = glm::radians(degrees)};
        if (auto good = check(options); !good) return tl::unexpected(good.error());
        ways.push_back(options);
      }
  }
  return ways;
}

/// A head that turns to and fro about its own vertical while the camera moves: `degrees` to either side of
/// where the path looks, `hertz` times a second.
void turnHead(std::span<TimedView> path, double degrees, double hertz) {
  for (TimedView& pose : path) {
    const double angle =
        glm::radians(degrees) * std::sin(2.0 * std::numbers::pi * hertz * (pose.time - path.front().time));
    const glm::dvec3 right = glm::cross(pose.view.forward, pose.view.up);
    pose.view.forward = std::cos(angle) * pose.view.forward + std::sin(angle) * right;
  }
}

Result<glm::dvec2> headTurnOf(const std::string& text) {
  if (text.empty()) return glm::dvec2(0.0);
  auto turn = parsePair("--head-turn", text);
  if (!turn) return tl::unexpected(turn.error());
  if (!(turn->x >= 0.0 && turn->x <= 90.0))
    return fail("--head-turn {}: {:g} degrees are outside [0, 90]", text, turn->x);
  if (!(turn->y >= 0.0 && turn->y <= 10.0))
    return fail("--head-turn {}: {:g} turns a second are outside [0, 10]", text, turn->y);
  return *turn;
}

Result<PvsScene> pvsScene(gl::Context& context, const std::string& file, const PvsCommand& command,
                          std::span<const PvsOptions> ways, glm::ivec2 size) {
  const auto headTurn = headTurnOf(command.headTurn);
  if (!headTurn) return tl::unexpected(headTurn.error());
  CameraChoice camera = command.camera;
  camera.fps = command.sampling.rate / command.speed;
  // A camera that stands still: as many poses as the frames take.
  const bool still = !camera.camera.empty() || !camera.eye.empty();
  const auto needed = static_cast<int>(command.sampling.shownViews()) + command.sampling.frames;
  if (still) camera.frames = needed;
  std::vector<TimedView> path;
  std::unique_ptr<Engine> engine;
  std::string pathName;
  {
    Progress loading(file);
    const auto step = [&](const std::string& text) { loading.step(text); };
    auto measured = loadMeasured(file, command.stage, camera, size, step);
    if (!measured) return tl::unexpected(measured.error());
    pathName = measured->path;
    if (command.speed != 1.0) pathName += fmt::format(", {:g} times as fast", command.speed);
    if (headTurn->x > 0.0)
      pathName += fmt::format(", head turning by {:g}° at {:g} Hz", headTurn->x, headTurn->y);
    path = std::move(measured->views);
    // A scene without a path of its own stands still as well.
    if (measured->path == "none" && !still) path.resize(static_cast<std::size_t>(needed), path.front());
    // The scene's own time runs as ever, however fast the path is walked.
    for (std::size_t i = 1; i < path.size(); ++i)
      path[i].time = path.front().time + static_cast<double>(i) / command.sampling.rate;
    turnHead(path, headTurn->x, headTurn->y);
    AtlasChoice atlas;
    atlas.sampling = command.element == "triangle" ? Sampling::Tess : Sampling::Rect;
    auto setup = engineOptions(atlas);
    if (!setup) return tl::unexpected(setup.error());
    setup->request = {.rect = true, .displayGeometry = true, .displayDeferred = false, .forward = false};
    setup->timePasses = true;
    setup->progress = step;
    auto made = Engine::create(context, std::move(measured->scene), std::move(measured->stage), *setup);
    if (!made) return tl::unexpected(made.error());
    engine = std::move(*made);
  }
  const std::string name = std::filesystem::path(file).filename().string();
  if (engine->visibleSet() == nullptr) return fail("{}: nothing opaque to be visible", file);
  engine->update(path.front().time);
  const auto frames = presentPoses(path.size(), command.sampling.shownViews(),
                                   static_cast<std::size_t>(command.sampling.frames));
  Progress progress("sets of " + name, frames.size());
  auto scene = measurePvs(*engine, path, command.sampling, ways, [&] { progress.step(); });
  if (!scene) return fail("{}: {}", file, scene.error().message);
  scene->scene = name;
  scene->path = pathName;
  return scene;
}

void print(const PvsScene& scene) {
  fmt::print("{}: {} x {}, path {}, {} shown views at {:g} Hz within {:.1f} ms; an id pass {:.1f} ms\n",
             scene.scene, scene.width, scene.height, scene.path, scene.shownViews, scene.rate,
             scene.latencyMs, scene.idMs.median);
  fmt::print("  {:<34} {:>10} {:>9} {:>9} {:>7} {:>7} {:>9} {:>8} {:>8} {:>8}\n", "prediction", "id buffer",
             "coverage", "worst", "over", "worst", "missed px", "needed", "in set", "ms");
  for (const PvsRun& run : scene.runs) {
    const PvsSummary s = summarize(run);
    fmt::print(
        "  {:<34} {:>10} {:>8.3f}% {:>8.3f}% {:>6.2f}% {:>6.2f}% {:>9.1f} {:>8.0f} {:>8.0f} {:>8.1f}\n",
        run.name, fmt::format("{}x{}", run.width, run.height), 100.0 * s.coverage, 100.0 * s.coverageWorst,
        100.0 * s.overestimation, 100.0 * s.overestimationWorst, s.missedPixels, s.neededElements, s.elements,
        s.ms.median);
  }
}

Result<void> pvs(const PvsCommand& command) {
  auto size = parseSize(command.size.text);
  if (!size) return tl::unexpected(size.error());
  PvsCommand checked = command;
  checked.sampling.latency = 1e-3 * command.latencyMs;
  auto ways = waysOf(checked);
  if (!ways) return tl::unexpected(ways.error());
  std::optional<ReportFiles> files;
  if (!command.output.empty()) {
    auto created = ReportFiles::create(command.output, "pvs");
    if (!created) return tl::unexpected(created.error());
    files = std::move(*created);
  }
  if (!command.json.empty())
    if (auto writable = checkWritable(command.json); !writable)
      return fail("--json {}", writable.error().message);
  auto context = openContext(command.context);
  if (!context) return tl::unexpected(context.error());
  PvsReport report;
  report.context = reportContext((*context)->info(), command.command);
  for (const std::string& file : command.scenes) {
    auto scene = pvsScene(**context, file, checked, *ways, *size);
    if (!scene) return tl::unexpected(scene.error());
    print(*scene);
    report.scenes.push_back(std::move(*scene));
  }
  const std::string json = toJson(report);
  if (!command.json.empty())
    if (auto written = writeFile(command.json, json); !written) return written;
  return files ? files->write(json, toHtml(report)) : Result<void>();
}

}  // namespace

Run addPvs(CLI::App& app) {
  auto options = std::make_shared<PvsCommand>();
  options->camera.pathUnlessChosen = "tour";
  CLI::App& command = *app.add_subcommand(
      "pvs",
      "Potentially visible sets of predicted views against the views that are shown within the latency.\n"
      "Coverage is the share of their pixels whose patch is in the set; overestimation is the pixels, in the "
      "set's own views, of patches that none of them shows, as a share of their pixels (means over views; "
      "Mueller et al. 2018, sec. 5.1).");
  command.add_option("scenes", options->scenes, "glTF 2.0 files")->required();
  command.add_option("-o,--output", options->output, "folder for pvs.json and pvs.html");
  command.add_option("--json", options->json, "file for the same JSON");
  command
      .add_option(
          "--prediction", options->predictions,
          "comma-separated: none (the present view alone), linear (from the two last poses), reference "
          "(the path itself)")
      ->delimiter(',')
      ->check(CLI::IsMember(predictions()))
      ->capture_default_str();
  command
      .add_option("--margin-deg", options->margins,
                  "comma-separated: degrees that the set's views see further to each side, 0 to 45; their id "
                  "buffers grow so that pixels keep their size and place")
      ->delimiter(',')
      ->check(CLI::Range(0.0, 45.0))
      ->capture_default_str();
  command
      .add_option("--steps", options->steps,
                  "comma-separated: predicted views beside the present one, evenly over the latency")
      ->delimiter(',')
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command
      .add_option("--latency-ms", options->latencyMs,
                  "views are shown for so long by one set, to the nearest whole number of them")
      ->check(CLI::Range(0.0, 10000.0))
      ->capture_default_str();
  command.add_option("--rate", options->sampling.rate, "poses and shown views a second of the path")
      ->check(CLI::Range(0.1, 10000.0))
      ->capture_default_str();
  command.add_option("--speed", options->speed, "times that the path is walked faster than it says")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  command.add_option(
      "--head-turn", options->headTurn,
      "degrees,hertz: on top of the path the head turns so far to either side, so often a second");
  command.add_option("--element", options->element, "what a set holds: patch or triangle")
      ->check(CLI::IsMember({"patch", "triangle"}))
      ->capture_default_str();
  addContext(command, options->context);
  addSize(command, options->size);
  addCamera(command, options->camera);
  addStage(command, options->stage);
  // The rate is that of the poses, and the number of sets has its own default.
  for (const char* unused : {"--fps", "--frames"}) command.remove_option(command.get_option(unused));
  command.add_option("--frames", options->sampling.frames, "sets, evenly along the path")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  return [options](const std::string& line) {
    options->command = line;
    return pvs(*options);
  };
}

}  // namespace tessera::app
