// tessera render: pictures of a scene by one method, with statistics or debug views.
#include <array>
#include <map>
#include <memory>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/tessera/accuracy/choose.hpp"
#include "apps/tessera/commands.hpp"
#include "apps/tessera/context_json.hpp"
#include "apps/tessera/progress.hpp"
#include "engine/core/file.hpp"

namespace tessera::app {

namespace {

struct RenderOptions {
  std::string scene;
  std::string output;
  std::string method = "rect";
  std::string view;
  std::string stats;
  ContextChoice context;
  SizeChoice size;
  CameraChoice camera;
  StageChoice stage;
  AtlasChoice atlas;
  SpatialChoice spatial;
  PredictionChoice prediction;
  StudyChoice study;
  int shadowSize = EngineOptions().shadowSize;
  ShadowFilter shadowFilter = EngineOptions().shadowFilter;
  NumericForms forms;
};

const std::map<std::string, DebugView> kDebugViews = {{"ids", DebugView::Ids},
                                                      {"patches", DebugView::Patches},
                                                      {"levels", DebugView::Levels},
                                                      {"blocks", DebugView::Blocks},
                                                      {"texel-density", DebugView::TexelDensity},
                                                      {"atlas", DebugView::Atlas}};

FrameRequest requestOf(const RenderOptions& options) {
  FrameRequest request;
  request.forward = options.method.starts_with("forward");
  request.depthPrepass = options.method == "forward-prepass";
  request.upsample = options.method == "forward-lanczos";
  request.rect = !request.forward || !options.view.empty();
  request.displayDeferred = options.method.ends_with("-deferred");
  request.displayGeometry = !request.displayDeferred;
  request.lens = options.spatial.lens.has_value();
  return request;
}

Sampling samplingOf(const std::string& method) {
  if (method.starts_with("lpack")) return Sampling::LPack;
  if (method.starts_with("oversample")) return Sampling::Oversample;
  if (method.starts_with("texel")) return Sampling::Texel;
  return method.starts_with("tess") ? Sampling::Tess : Sampling::Rect;
}

std::filesystem::path numbered(const std::filesystem::path& output, std::size_t frame, std::size_t frames) {
  if (frames == 1) return output;
  return output.parent_path() /
         fmt::format("{}.{:04}{}", output.stem().string(), frame, output.extension().string());
}

/// The file that was written, and how full the atlas was, in the last frame of which that has arrived.
std::string progressOf(const std::filesystem::path& file, Engine& engine) {
  std::string line = file.filename().string();
  RectAtlas* atlas = engine.atlas();
  const auto stats = atlas != nullptr ? atlas->memory().latestStatistics() : std::nullopt;
  if (stats) line += fmt::format(", atlas {:.0f} % in use", 100.0f * stats->load);
  if (stats && stats->failures > 0) line += fmt::format(", {} patches without memory", stats->failures);
  return line;
}

/// The picture of forward, or of what enlarges it.
Result<void> drawForward(Engine& engine, const RenderOptions& options, const View& view) {
  if (options.method != "forward-lanczos") {
    engine.forward(view, options.method == "forward-prepass");
    return {};
  }
  View quarter = view;
  quarter.width /= 2;
  quarter.height /= 2;
  engine.forward(quarter);
  return engine.upsample(view.width, view.height);
}

/// The options with what a study says is best, if one is asked.
Result<RenderOptions> withStudy(const RenderOptions& options) {
  if (options.study.file.empty()) return options;
  auto chosen = chooseFrom(options.study, options.scene);
  if (!chosen) return tl::unexpected(chosen.error());
  const Method& method = chosen->configuration.method;
  RenderOptions chosenOptions = options;
  // The name has no settings; deferred display is a method of its own here.
  chosenOptions.method = method.name + (method.kind == Kind::RectDeferred ? "-deferred" : "");
  if (method.usesAtlas()) chosenOptions.atlas = method.atlas;
  chosenOptions.shadowSize = chosen->configuration.shadowSize;
  chosenOptions.shadowFilter = chosen->configuration.shadowFilter;
  chosenOptions.forms = chosen->configuration.forms;
  fmt::print("{}\n", chosen->reason);
  return chosenOptions;
}

nlohmann::json frameStatistics(Engine& engine, const TimedView& timed) {
  nlohmann::json json;
  json["time_s"] = timed.time;
  nlohmann::json passes = nlohmann::json::array();
  for (const PassTime& pass : engine.times())
    passes.push_back({{"name", pass.name}, {"ms", pass.milliseconds}});
  json["passes"] = passes;
  json["fragments"] = engine.fragments();
  if (RectAtlas* atlas = engine.atlas(); atlas != nullptr && engine.visibleSet()->frame() > 0) {
    const RectStatistics stats = atlas->memory().readStatistics();
    json["visible_patches"] = stats.visiblePatches;
    json["visible_triangles"] = engine.visibleTriangles();
    json["samples_allocated"] = stats.samples;
    json["atlas_texels_used"] = stats.liveTexels;
    json["out_of_memory"] = stats.failures;
    json["resets"] = stats.resets;
    json["bias"] = stats.bias;
  }
  if (const TessAtlas* tess = engine.tess(); tess != nullptr && engine.visibleSet()->frame() > 0) {
    const TessStatistics stats = tess->memory().readStatistics();
    json["gather"] = nameOf(tess->spawn());
    json["visible_triangles"] = stats.visible;
    json["single_texels"] = stats.singles;
    json["samples_allocated"] = stats.samples;
    json["atlas_texels_used"] = stats.liveTexels;
    json["cell_texels"] = stats.cellTexels;
    json["free_texels"] = stats.freeTexels;
    json["l_samples"] = stats.lSamples;
    json["slanted_triangles"] = stats.slanted;
    json["out_of_memory"] = stats.failures;
    json["resets"] = stats.resets;
    json["bias"] = stats.bias;
  }
  if (const TexelAtlas* texel = engine.texel(); texel != nullptr && engine.visibleSet()->frame() > 0) {
    const TexelStatistics stats = texel->readCounts();
    json["visible_patches"] = stats.visible;
    json["visible_triangles"] = engine.visibleTriangles();
    json["samples_allocated"] = stats.samples;
    json["tiles"] = stats.tiles;
    json["tiles_marked"] = stats.marked;
    json["tiles_lost"] = stats.lost;
    json["slots"] = stats.slots;
    json["tiles_kept"] = stats.kept;
    json["wasted_share"] = stats.wasted();
    json["levels_coarser"] = stats.coarser;
    json["bias"] = stats.bias;
  }
  return json;
}

/// The potentially visible set, if one is asked for; fails where the picture could not be drawn from it.
Result<std::optional<PvsOptions>> pvsOf(const RenderOptions& options) {
  auto pvs = pvsOptionsOf(options.prediction);
  if (!pvs || !*pvs) return pvs;
  if (options.method.starts_with("forward") && options.view.empty())
    return fail("--prediction: method {} has no visible set", options.method);
  if (options.method.ends_with("-deferred"))
    return fail("--prediction: method {} displays by the ids of one view", options.method);
  if (!options.view.empty() && options.view != "atlas" && options.view != "blocks")
    return fail("--prediction: --view {} shows the ids of one view", options.view);
  return pvs;
}

/// Finds and places what one view sees, or what the predicted ones do.
Result<void> findAndPlace(Engine& engine, const TimedView& timed, const std::optional<PvsOptions>& pvs,
                          PoseTrack& track, std::span<const TimedView> path, const PlaceOptions& reuse) {
  if (!pvs) {
    engine.findVisible({&timed.view, 1});
    return engine.place({&timed.view, 1}, reuse);
  }
  track.add(timed);
  const auto predicted = predictedViews(track, path, *pvs);
  const auto wide = widened(predicted, pvs->margin);
  if (!wide) return tl::unexpected(wide.error());
  engine.findVisible(*wide);
  // The camera is nearest to a patch at one end of its way or the other, but for a patch that it passes.
  const std::array<View, 2> ends = {predicted.front().view, predicted.back().view};
  return engine.place(std::span(ends).first(predicted.size() > 1 ? 2 : 1), reuse);
}

Result<void> render(const RenderOptions& asked) {
  auto studied = withStudy(asked);
  if (!studied) return tl::unexpected(studied.error());
  const RenderOptions& options = *studied;
  auto size = parseSize(options.size.text);
  if (!size) return tl::unexpected(size.error());
  if (options.method == "forward-lanczos" && (size->x % 2 != 0 || size->y % 2 != 0))
    return fail("--size {}: forward-lanczos draws half of the width and of the height: both must be even",
                options.size.text);
  auto spatial = spatialOf(options.spatial);
  if (!spatial) return tl::unexpected(spatial.error());
  const auto pvs = pvsOf(options);
  if (!pvs) return tl::unexpected(pvs.error());
  PoseTrack track;
  AtlasChoice atlas = options.atlas;
  atlas.sampling = samplingOf(options.method);
  auto engineSetup = engineOptions(atlas);
  if (!engineSetup) return tl::unexpected(engineSetup.error());
  auto stage = loadStageOf(options.stage);
  if (!stage) return tl::unexpected(stage.error());
  auto progress = std::make_unique<Progress>("render");
  const auto step = [&](const std::string& text) { progress->step(text); };
  auto scene = loadGltf(options.scene, {.loadImages = true, .progress = step});
  if (!scene) return tl::unexpected(scene.error());
  for (const std::string& warning : scene->warnings)
    fmt::print(stderr, "warning: {}: {}\n", options.scene, warning);
  auto views = viewsOf(options.camera, *scene, *stage ? &**stage : nullptr, *size);
  if (!views) return tl::unexpected(views.error());
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());

  engineSetup->request = requestOf(options);
  engineSetup->shadowSize = options.shadowSize;
  engineSetup->shadowFilter = options.shadowFilter;
  engineSetup->forms = options.forms;
  engineSetup->timePasses = !options.stats.empty();
  engineSetup->countFragments = !options.stats.empty();
  engineSetup->progress = step;
  auto made = Engine::create(**context, std::move(*scene), std::move(*stage), *engineSetup);
  if (!made) return tl::unexpected(made.error());
  Engine& engine = **made;
  progress.reset();

  nlohmann::json frames = nlohmann::json::array();
  Progress frameProgress("frames", views->size());
  for (std::size_t i = 0; i < views->size(); ++i) {
    const TimedView& timed = (*views)[i];
    engine.clearTimes();
    engine.update(timed.time);
    const PlaceOptions reuse = spatial->at(timed.time);
    if (engineSetup->request.forward)
      if (auto drawn = drawForward(engine, options, timed.view); !drawn) return drawn;
    if (engineSetup->request.rect) {
      if (auto placed = findAndPlace(engine, timed, *pvs, track, *views, reuse); !placed) return placed;
      engine.shade(timed.view, shadeOptions(options.atlas));
    }
    Image picture;
    if (!options.view.empty()) {
      auto debug = engine.debugView(kDebugViews.at(options.view), timed.view);
      if (!debug) return tl::unexpected(debug.error());
      picture = std::move(*debug);
    } else {
      if (engineSetup->request.rect)
        engine.display(timed.view,
                       engineSetup->request.displayDeferred ? DisplayMode::Deferred : DisplayMode::Geometry);
      if (reuse.lens)
        if (auto distorted = engine.distort(*reuse.lens); !distorted) return distorted;
      picture = engine.readColor();
    }
    const auto file = numbered(options.output, i, views->size());
    if (auto written = writePng(file, picture); !written) return written;
    if (!options.stats.empty()) frames.push_back(frameStatistics(engine, timed));
    frameProgress.step(progressOf(file, engine));
  }
  if (!options.stats.empty()) {
    nlohmann::json json;
    json["schema"] = 1;
    json["context"] = contextJson((*context)->info(), engine.timerMode());
    json["file"] = options.scene;
    json["method"] = options.method;
    json["size"] = {size->x, size->y};
    json["frames"] = frames;
    nlohmann::json memory;
    for (const auto& [what, bytes] : engine.memory()) memory[what] = bytes;
    json["memory_bytes"] = memory;
    if (auto written = writeFile(options.stats, json.dump(2) + "\n"); !written) return written;
  }
  return {};
}

}  // namespace

Run addRender(CLI::App& app) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App& command = *app.add_subcommand("render", "Draw a scene to PNG files");
  command.add_option("scene", options->scene, "glTF 2.0 file, .gltf or .glb")->required();
  command.add_option("-o,--output", options->output, "PNG to write; several frames are numbered")->required();
  auto* method = command
                     .add_option("--method", options->method,
                                 "forward, forward-prepass, forward-lanczos, rect, lpack, oversample, tess "
                                 "or texel; those of an atlas but "
                                 "oversample "
                                 "also with -deferred")
                     ->check(CLI::IsMember({"forward", "forward-prepass", "forward-lanczos", "rect",
                                            "rect-deferred", "lpack", "lpack-deferred", "oversample", "tess",
                                            "tess-deferred", "texel", "texel-deferred"}))
                     ->capture_default_str();
  command
      .add_option("--view", options->view,
                  "debug picture: ids, patches, levels, blocks, texel-density or atlas")
      ->check(CLI::IsMember(kDebugViews));
  command.add_option("--stats", options->stats, "JSON file for times and counts");
  auto* study =
      command.add_option("--study", options->study.file,
                         "accuracy.json of 'tessera accuracy': takes method, atlas and shadow maps from it, "
                         "by one of the two that follow, and says what and why");
  study->excludes(method);
  auto* budget = command
                     .add_option("--budget-ms", options->study.budgetMs,
                                 "the best configuration of the study that takes no longer a frame")
                     ->check(CLI::Range(0.0, 1e9))
                     ->needs(study);
  auto* target = command
                     .add_option("--target-dssim", options->study.targetDssim,
                                 "the cheapest configuration of the study that is no further off")
                     ->check(CLI::Range(0.0, 1.0))
                     ->needs(study);
  budget->excludes(target);
  addContext(command, options->context);
  addSize(command, options->size);
  addCamera(command, options->camera);
  addStage(command, options->stage);
  addAtlas(command, options->atlas);
  addSpatial(command, options->spatial);
  addPrediction(command, options->prediction);
  return [options](const std::string&) -> Result<void> {
    const StudyChoice& choice = options->study;
    if (!choice.file.empty() && !choice.budgetMs && !choice.targetDssim)
      return fail("--study {}: needs --budget-ms or --target-dssim to choose by", choice.file);
    return render(*options);
  };
}

}  // namespace tessera::app
