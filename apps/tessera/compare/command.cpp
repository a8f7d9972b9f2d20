// tessera compare: the methods side by side on the same frames, as report.json and report.html.
#include <algorithm>
#include <memory>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/compare/equal_samples.hpp"
#include "apps/tessera/compare/figures.hpp"
#include "apps/tessera/compare/print.hpp"
#include "apps/tessera/compare/scene.hpp"
#include "apps/tessera/report_output.hpp"

namespace tessera::app {

namespace {

/// The methods asked for and those of the figures, each once, what others are compared with first.
Result<std::vector<Method>> methodsOf(const CompareOptions& options,
                                      const std::vector<ReportFigure>& figures) {
  auto spatial = spatialOf(options.spatial);
  if (!spatial) return tl::unexpected(spatial.error());
  std::vector<std::string> names = figures.empty() ? options.methods : std::vector<std::string>();
  for (const ReportFigure& figure : figures)
    for (const ReportBar& bar : figure.bars) names.push_back(bar.method);
  std::vector<Method> methods;
  for (const std::string& name : names) {
    const auto same = [&](const Method& method) { return method.name == name; };
    if (std::any_of(methods.begin(), methods.end(), same)) continue;
    auto method = parseMethod(name, options.atlas, *spatial);
    if (!method) return tl::unexpected(method.error());
    methods.push_back(std::move(*method));
  }
  // References are drawn whether they are asked for or not.
  for (const Kind kind : {Kind::ForwardStereo, Kind::Forward}) {
    const bool stereo = kind == Kind::ForwardStereo;
    if (std::none_of(methods.begin(), methods.end(), [&](const Method& m) { return m.isStereo() == stereo; }))
      continue;
    const auto found =
        std::find_if(methods.begin(), methods.end(), [&](const Method& m) { return m.kind == kind; });
    if (found == methods.end())
      methods.insert(methods.begin(), Method{stereo ? "forward-stereo" : "forward", kind, {}, {}});
    else
      std::rotate(methods.begin(), found, found + 1);
  }
  return methods;
}

Result<void> compare(const CompareOptions& options) {
  auto size = parseSize(options.size.text);
  if (!size) return tl::unexpected(size.error());
  auto figures = figuresOf(options.figures);
  if (!figures) return tl::unexpected(figures.error());
  auto methods = methodsOf(options, *figures);
  if (!methods) return tl::unexpected(methods.error());
  for (const Method& method : *methods)
    if (method.kind == Kind::ForwardLanczos && (size->x % 2 != 0 || size->y % 2 != 0))
      return fail("--size {}: forward-lanczos draws half of the width and of the height: both must be even",
                  options.size.text);
  auto pvs = parsePvs(options.pvs);
  if (!pvs) return tl::unexpected(pvs.error());
  const auto once = [](const Method& method) { return method.usesAtlasOnce(); };
  if ((options.curve || !pvs->empty()) && std::none_of(methods->begin(), methods->end(), once))
    return fail("{}: no method of --methods fills an atlas for one view",
                options.curve ? "--curve" : "--pvs");
  if (options.equalSamples && samplesReference(*methods) == nullptr)
    return fail("--equal-samples: --methods has no rect for one view, whose samples the others would get");
  auto files = ReportFiles::create(options.output, "report");
  if (!files) return tl::unexpected(files.error());
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());

  Report report;
  report.context = reportContext((*context)->info(), options.command);
  for (const std::string& file : options.scenes) {
    auto scene = compareScene(**context, file, *methods, *pvs, options, *size);
    if (!scene) return tl::unexpected(scene.error());
    printSummary(*scene);
    report.scenes.push_back(std::move(*scene));
  }
  report.figures = std::move(*figures);
  return files->write(toJson(report), toHtml(report));
}

}  // namespace

Run addCompare(CLI::App& app) {
  auto options = std::make_shared<CompareOptions>();
  options->camera.pathUnlessChosen = "tour";
  options->camera.frames = 12;
  options->camera.fps = 0.0;  // unless given: as many as show the whole path
  CLI::App& command = *app.add_subcommand(
      "compare", "Draw the same frames by several methods; writes report.json and report.html");
  command.add_option("scenes", options->scenes, "glTF 2.0 files")->required();
  command.add_option("-o,--output", options->output, "folder for the report")->required();
  auto* methods =
      command
          .add_option(
              "--methods", options->methods,
              "comma-separated: forward, forward-prepass, forward-lanczos, forward-stereo, warp-stereo, "
              "rect, tess, lpack, oversample, and each of these four -deferred or -stereo; they take "
              "settings "
              "after a colon, joined by +: mpix=N, bias=N, bias=off, floor=N, texbias=N, slanted=N, foveate, "
              "lens")
          ->delimiter(',')
          ->capture_default_str();
  auto* figures =
      command
          .add_option("--figures", options->figures,
                      "in place of methods: 4.1, 4.3, 4.6, 4.7 (comma-separated) or all: what these "
                      "figures of the thesis compare; then 1920x1080, 6 frames and MSSIM alone, "
                      "unless asked for otherwise")
          ->delimiter(',')
          ->excludes(methods);
  command
      .add_option("--pvs", options->pvs,
                  "also with the visible set of a moving camera: RADIUS,DEGREES it may go and turn, or all: "
                  "0.1,40, 0.2,80 and 0.3,120; may be given several times")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->excludes(figures);
  command
      .add_flag("--equal-samples", options->equalSamples,
                "bias the other methods that fill an atlas so that they shade as many samples as rect")
      ->excludes(figures);
  command
      .add_flag("--curve", options->curve,
                "samples against quality of methods that fill an atlas, over five biases")
      ->excludes(figures);
  auto* metrics =
      command
          .add_option("--metrics", options->metrics,
                      "comma-separated: mssim (always taken), psnr, flip (and its error pictures)")
          ->delimiter(',')
          ->check(CLI::IsMember({"mssim", "psnr", "flip"}))
          ->capture_default_str();
  command
      .add_option("--eye-distance", options->eyeDistance,
                  "between the eyes of stereo methods, in the scene's unit (glTF: metres)")
      ->check(CLI::Range(0.0, 1e6))
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
  addSpatial(command, options->spatial);
  const auto* size = command.get_option("--size");
  const auto* frames = command.get_option("--frames");
  return [options, figures, metrics, size, frames](const std::string& line) {
    if (figures->count() > 0) {
      if (size->count() == 0) options->size.text = "1920x1080";
      if (frames->count() == 0) options->camera.frames = 6;
      if (metrics->count() == 0) options->metrics = {"mssim"};
    }
    options->command = line;
    return compare(*options);
  };
}

}  // namespace tessera::app
