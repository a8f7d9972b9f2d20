// tessera stream-study: is it better than sending pictures?
#include <cmath>
#include <filesystem>
#include <memory>

#include <fmt/core.h>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/measured_scene.hpp"
#include "apps/tessera/progress.hpp"
#include "apps/tessera/report_output.hpp"
#include "apps/tessera/study/loopback.hpp"
#include "apps/tessera/study/print.hpp"
#include "apps/tessera/study/study.hpp"

namespace tessera::app {

namespace {

struct StudyCommand {
  std::vector<std::string> scenes;
  std::string output;
  std::string path;
  std::string size;
  std::string warpPose = "present";
  bool quick = false;
  StudySettings settings;
  ContextChoice context;
  StageChoice stage;
  std::string command;
  std::vector<const CLI::Option*> given;  // what --quick leaves alone where it was given
};

/// Few pictures, few settings: whether it works, and about how it comes out.
void makeQuick(StudyCommand& command, const std::string& size) {
  const auto free = [&](const char* name) {
    for (const CLI::Option* option : command.given)
      if (option->check_lname(name)) return option->count() == 0;
    return true;
  };
  StudySettings& s = command.settings;
  if (size.empty()) command.size = "320x180";
  if (free("samples")) s.samples = 4;
  if (free("seconds")) s.seconds = 0.25;
  if (free("latencies-ms")) s.latenciesMs = {0.0, 50.0, 100.0};
  if (free("server-rates")) s.serverRates = {15.0, 30.0};
  if (free("bitrates-mbit")) s.bitratesMbit = {5.0, 20.0};
  if (free("atlas-mpix")) s.megapixels = {2.0};
}

Result<void> check(const StudySettings& s) {
  const auto rising = [](const char* option, const std::vector<double>& values) -> Result<void> {
    for (std::size_t i = 1; i < values.size(); ++i)
      if (!(values[i] > values[i - 1]))
        return fail("{}: {:g} after {:g}; values must rise", option, values[i], values[i - 1]);
    return {};
  };
  for (const auto& done : {rising("--latencies-ms", s.latenciesMs), rising("--server-rates", s.serverRates),
                           rising("--bitrates-mbit", s.bitratesMbit), rising("--atlas-mpix", s.megapixels)})
    if (!done) return done;
  if (s.size.x % 2 != 0 || s.size.y % 2 != 0 || s.size.x < 32 || s.size.y < 32)
    return fail("--size {}x{}: video takes even sides, from 32 on", s.size.x, s.size.y);
  if (s.seconds * s.displayHz < s.samples)
    return fail("--samples {}: more than the {:g} pictures of {:g} s", s.samples, s.seconds * s.displayHz,
                s.seconds);
  return {};
}

Result<StudyScene> studyScene(gl::Context& context, const std::string& file, const StudyCommand& command) {
  const StudySettings& settings = command.settings;
  StudyScene scene;
  scene.file = std::filesystem::path(file).filename().string();
  CameraChoice camera;
  camera.path = command.path;
  camera.pathUnlessChosen = "tour";
  camera.fps = settings.displayHz;
  std::unique_ptr<Engine> engine;
  std::optional<StudyPath> path;
  AtlasStream::Masks masks;
  {
    Progress loading(file);
    const auto step = [&](const std::string& text) { loading.step(text); };
    auto measured = loadMeasured(file, command.stage, camera, settings.size, step);
    if (!measured) return tl::unexpected(measured.error());
    if (measured->path == "none")
      return fail("{}: no camera moves: name a --path, or a --stage that has the path tour", file);
    auto piece = StudyPath::of(std::move(measured->views), settings);
    if (!piece) return fail("{}: path {}: {}", file, measured->path, piece.error().message);
    path = std::move(*piece);
    scene.note = fmt::format("{}, path {}", measured->stageNote, measured->path);
    scene.triangles = measured->scene.triangleCount();
    AtlasChoice atlas;
    atlas.megapixels = settings.megapixels.front();
    auto setup = engineOptions(atlas);
    if (!setup) return tl::unexpected(setup.error());
    setup->request = {
        .rect = true, .displayGeometry = true, .displayDeferred = false, .forward = true, .blended = true};
    setup->visiblePixels = true;  // regions of interest, as serve has them
    setup->progress = step;
    masks = std::make_shared<const std::vector<wire::MaskImage>>(masksOf(measured->scene));
    auto made = Engine::create(context, std::move(measured->scene), std::move(measured->stage), *setup);
    if (!made) return tl::unexpected(made.error());
    engine = std::move(*made);
  }
  if (engine->visibleSet() == nullptr) return fail("{}: nothing opaque to be visible", file);
  scene.width = settings.size.x;
  scene.height = settings.size.y;
  scene.start = path->start();
  scene.leadSeconds = path->samples().first;
  scene.seconds = path->samples().last() - path->samples().first;
  scene.samples = path->samples().count;
  scene.metresPerSecond = path->metresPerSecond();
  scene.degreesPerSecond = path->degreesPerSecond();
  if (auto measured = measureStudy(context, *engine, *path, settings, masks, scene); !measured)
    return fail("{}: {}", file, measured.error().message);
  engine.reset();
  if (settings.loopback) {
    Progress progress(scene.file + ": two processes over loopback");
    scene.timeline = measureLoopback(file, command.stage.file, command.context, *path, settings,
                                     std::filesystem::path(command.output) / "loopback" / scene.file);
  } else {
    scene.timeline.failed = "--no-loopback";
  }
  return scene;
}

std::vector<std::pair<std::string, std::string>> settingsOf(const StudySettings& s) {
  return {
      {"Display", fmt::format("{} × {} at {:g} Hz", s.size.x, s.size.y, s.displayHz)},
      {"Server", fmt::format("{:g} Hz, {:g} Mbit/s where they do not vary", s.serverHz, s.mbit)},
      {"Video",
       fmt::format("H.264, CAVLC, one reference frame, no B-frames, 4:2:0, an I-frame every {} frames",
                   s.iFrames)},
      {"Server's view", fmt::format("{:g} % wider angle, for atlases and warps alike", 100.0 * s.widening)},
      {"Atlas", "potentially visible set by linear prediction in steps of 33.3 ms, as tessera serve has it"},
      {"Warps", fmt::format("picture of the {} pose; depth is sent without loss and without being counted",
                            s.warpPose == WarpPose::Present ? "present" : "linearly predicted")},
      {"MSSIM", "Gaussian window of 11, sigma 2, C1 1e-4, C2 9e-4, on luma"},
      {"Scene", s.moving ? "lights and nodes move" : "lights and nodes stand still"}};
}

Result<void> study(StudyCommand command) {
  if (command.quick) makeQuick(command, command.size);
  auto size = parseSize(command.size.empty() ? "640x360" : command.size);
  if (!size) return tl::unexpected(size.error());
  command.settings.size = *size;
  command.settings.warpPose = command.warpPose == "predicted" ? WarpPose::Predicted : WarpPose::Present;
  if (auto good = check(command.settings); !good) return good;
  auto files = ReportFiles::create(command.output, "study", "index");
  if (!files) return tl::unexpected(files.error());
  for (const std::string& file : command.scenes)
    if (std::error_code error; !std::filesystem::is_regular_file(file, error))
      return fail("{}: no such file", file);
  auto context = openContext(command.context);
  if (!context) return tl::unexpected(context.error());
  StudyReport report;
  report.context = reportContext((*context)->info(), command.command);
  report.settings = settingsOf(command.settings);
  report.serverHz = command.settings.serverHz;
  report.mbit = command.settings.mbit;
  report.videoLatencyMs = command.settings.videoLatencyMs;
  for (const std::string& file : command.scenes) {
    auto scene = studyScene(**context, file, command);
    if (!scene) return tl::unexpected(scene.error());
    printStudy(*scene);
    report.scenes.push_back(std::move(*scene));
    // What is measured of one scene is not lost with the next.
    if (&file != &command.scenes.back())
      if (auto written = files->write(toJson(report), toHtml(report)); !written) return written;
  }
  return files->write(toJson(report), toHtml(report));
}

}  // namespace

Run addStreamStudy(CLI::App& app) {
  auto options = std::make_shared<StudyCommand>();
  StudySettings& s = options->settings;
  CLI::App& command = *app.add_subcommand(
      "stream-study",
      "Streamed atlases against warped pictures: MSSIM by latency, server rate and bitrate, video coding "
      "included (Mueller 2021, sec. 7.2), and the time from pose to picture of the two programs");
  command.add_option("scenes", options->scenes, "glTF 2.0 files")->required();
  command.add_option("-o,--output", options->output, "folder for study.json and index.html")->required();
  const auto keep = [&](CLI::Option* option) {
    options->given.push_back(option);
    return option;
  };
  command.add_option("--size", options->size, "WxH of a shown picture, even; 640x360");
  command.add_option("--path", options->path,
                     "camera path: of the stage, or a JSON file; else the stage's tour");
  command.add_flag("--quick", options->quick, "few and small pictures, few settings: a minute or so");
  keep(command.add_option("--seconds", s.seconds, "of the path, over which samples spread")
           ->check(CLI::Range(0.05, 600.0))
           ->capture_default_str());
  keep(command
           .add_option("--samples", s.samples, "pictures that are compared with the truth, of each setting")
           ->check(CLI::Range(1, 10000))
           ->capture_default_str());
  command
      .add_option("--start", s.start,
                  "seconds of the path at which the server begins; else so that its middle is sampled")
      ->check(CLI::Range(0.0, 1e6));
  keep(command.add_option("--latencies-ms", s.latenciesMs, "comma-separated, rising")
           ->delimiter(',')
           ->check(CLI::Range(0.0, 2000.0))
           ->capture_default_str());
  keep(command.add_option("--server-rates", s.serverRates, "frames a second, comma-separated, rising")
           ->delimiter(',')
           ->check(CLI::Range(1.0, 240.0))
           ->capture_default_str());
  keep(
      command.add_option("--bitrates-mbit", s.bitratesMbit, "million bits a second, comma-separated, rising")
          ->delimiter(',')
          ->check(CLI::Range(0.05, 1000.0))
          ->capture_default_str());
  command.add_option("--server-fps", s.serverHz, "frames a second where latency or bitrate varies")
      ->check(CLI::Range(1.0, 240.0))
      ->capture_default_str();
  command.add_option("--mbit", s.mbit, "million bits a second where latency or rate varies")
      ->check(CLI::Range(0.05, 1000.0))
      ->capture_default_str();
  command.add_option("--i-frames", s.iFrames, "frames from one I-frame, and reset of the atlas, to the next")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  keep(command.add_option("--atlas-mpix", s.megapixels, "2^20 texels, comma-separated, rising")
           ->delimiter(',')
           ->check(CLI::Range(0.0625, 64.0))
           ->capture_default_str());
  command
      .add_option(
          "--bias-floor", s.biasFloor,
          "lowest level bias that room to spare in an atlas may lead to; -2: up to four texels a pixel")
      ->check(CLI::Range(-4.0, 0.0))
      ->capture_default_str();
  std::vector<std::string> names;
  for (const StudyMethodName& name : studyMethods()) names.emplace_back(name.option);
  command
      .add_option("--methods", s.methods, "comma-separated: rect, tess, time-warp, mesh-warp, iterative-warp")
      ->delimiter(',')
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  command
      .add_option("--warp-pose", options->warpPose,
                  "of the picture that is warped: present, or predicted for when it arrives")
      ->check(CLI::IsMember({"present", "predicted"}))
      ->capture_default_str();
  command.add_option("--widening", s.widening, "share by which the server's angle of view is wider")
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str();
  command.add_flag("--moving", s.moving, "lights and nodes move; else they stand still");
  command.add_flag("!--no-videos", s.videos, "films none of the methods");
  command.add_flag("!--no-loopback", s.loopback, "no time line of the two programs");
  addContext(command, options->context);
  addStage(command, options->stage);
  return [options](const std::string& line) {
    options->command = line;
    return study(*options);
  };
}

}  // namespace tessera::app
