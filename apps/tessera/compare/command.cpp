// tessera compare: the methods side by side on the same frames, as report.json and report.html.
#include <algorithm>
#include <filesystem>
#include <memory>

#include <fmt/core.h>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/compare/scene.hpp"
#include "engine/core/file.hpp"

namespace tessera::app {

namespace {

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
