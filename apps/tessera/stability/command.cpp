// tessera stability: runs the hard cases, and prints a line each.
#include <algorithm>
#include <chrono>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/context_json.hpp"
#include "apps/tessera/measured_scene.hpp"
#include "apps/tessera/stability/case.hpp"

namespace tessera::app {

namespace {

using stability::Case;
using stability::Sense;

struct StabilityOptions {
  ContextChoice context;
  std::vector<std::string> scenes;
  std::vector<std::string> only;
  bool json = false;
  bool list = false;
  bool full = false;
};

stability::Cases allCases() {
  stability::Cases cases;
  for (const auto add : {stability::addTriangleCases, stability::addCameraCases, stability::addFarCases,
                         stability::addDepthCases, stability::addTransformCases, stability::addShadingCases,
                         stability::addLevelCases, stability::addTessellationCases, stability::addMetricCases,
                         stability::addSoakCases, stability::addDeterminismCases})
    add(cases);
  return cases;
}

bool chosen(const Case& entry, const std::vector<std::string>& only) {
  return only.empty() || std::any_of(only.begin(), only.end(), [&](const std::string& text) {
           return entry.name.find(text) != std::string::npos;
         });
}

std::string lineOf(const Case& entry, double worst, bool passed, const std::string& error) {
  const char* sign = entry.sense == Sense::AtMost ? "<=" : ">=";
  const std::string figure = error.empty() ? fmt::format("{:.4g} {}", worst, entry.unit) : error;
  return fmt::format("{:4} {:34} {} ({} {:.4g})  {}", passed ? "ok" : "FAIL", entry.name, figure, sign,
                     entry.bound, entry.why);
}

/// Frames along the path that a scene's stage has, and one from outside.
Result<double> badInScene(stability::Bench& bench, const std::string& file) {
  constexpr int kFrames = 4;
  CameraChoice camera;
  camera.pathUnlessChosen = "tour";
  camera.frames = kFrames;
  auto scene =
      loadMeasured(file, {}, camera, {stability::kWidth, stability::kHeight}, [](const std::string&) {});
  if (!scene) return tl::unexpected(scene.error());
  std::vector<View> views = {autoView(scene->scene, stability::kWidth, stability::kHeight)};
  for (const TimedView& timed : scene->views) views.push_back(timed.view);
  return badPixels(bench, std::move(scene->scene), std::move(scene->stage), views, stability::Pixels::Any);
}

stability::Cases casesOf(const std::vector<std::string>& scenes) {
  stability::Cases cases;
  for (const std::string& file : scenes)
    cases.push_back({"scene/" + std::filesystem::path(file).filename().string(),
                     "all methods from outside and along the scene's path",
                     "texels not finite or pixels without texels", 0.0, Sense::AtMost,
                     [file](stability::Bench& bench) { return badInScene(bench, file); }});
  return cases;
}

Result<Exit> stability(const StabilityOptions& options) {
  stability::Cases cases = options.scenes.empty() ? allCases() : casesOf(options.scenes);
  std::erase_if(cases, [&](const Case& entry) { return !chosen(entry, options.only); });
  if (cases.empty()) return fail("no case has a name with '{}'", options.only.front());
  if (options.list) {
    for (const Case& entry : cases) fmt::print("{:34} {}\n", entry.name, entry.why);
    return Exit::Ok;
  }
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());
  stability::Bench bench{**context, options.full};
  const gl::ContextInfo& info = (*context)->info();
  nlohmann::json list = nlohmann::json::array();
  std::size_t failed = 0;
  if (!options.json) fmt::print("{}, {}, GL {}\n", info.backendName, info.renderer, info.version);
  for (const Case& entry : cases) {
    const auto start = std::chrono::steady_clock::now();
    const auto worst = entry.worst(bench);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const bool passed = worst && passes(entry, *worst);
    failed += passed ? 0 : 1;
    const std::string error = worst ? "" : worst.error().message;
    if (options.json) {
      nlohmann::json record = {{"name", entry.name},
                               {"why", entry.why},
                               {"passed", passed},
                               {"unit", entry.unit},
                               {"bound", entry.bound},
                               {"seconds", seconds},
                               {"sense", entry.sense == Sense::AtMost ? "at most" : "at least"}};
      // JSON has no infinity: of those only the sign of the bound's side matters.
      record["worst"] = worst && std::isfinite(*worst) ? nlohmann::json(*worst) : nlohmann::json(nullptr);
      if (!error.empty()) record["error"] = error;
      list.push_back(std::move(record));
    } else {
      fmt::print("{}\n", lineOf(entry, worst ? *worst : 0.0, passed, error));
      std::fflush(stdout);
    }
  }
  if (options.json) {
    const nlohmann::json all = {{"context", contextJson(info, gl::timerModeFor(info))}, {"cases", list}};
    fmt::print("{}\n", all.dump(2));
  } else {
    fmt::print("{} of {} cases hold\n", cases.size() - failed, cases.size());
  }
  return failed == 0 ? Exit::Ok : Exit::Failed;
}

}  // namespace

Run addStability(CLI::App& app, Exit& ending) {
  auto options = std::make_shared<StabilityOptions>();
  CLI::App& command = *app.add_subcommand(
      "stability", "Run the hard cases: inputs that break renderers, each with a bound that must hold");
  command.add_option("scenes", options->scenes,
                     "glTF 2.0 files: in place of the library, whether all that is shaded of them is finite");
  command.add_flag("--json", options->json, "as JSON");
  command.add_flag("--list", options->list, "only name the cases");
  command.add_flag("--long", options->full, "also what takes minutes: 10,000 frames of a slow camera");
  command.add_option("--only", options->only, "cases whose name has this text");
  addContext(command, options->context);
  return [options, &ending](const std::string&) -> Result<void> {
    const auto result = stability(*options);
    if (!result) return tl::unexpected(result.error());
    ending = *result;
    return {};
  };
}

}  // namespace tessera::app
