#include "apps/tessera/compare/scene.hpp"

#include <memory>

#include <fmt/format.h>

#include "apps/tessera/compare/runs.hpp"

namespace tessera::app {

namespace {

FrameRequest requestOf(const std::vector<Method>& methods) {
  FrameRequest request;
  for (const Method& method : methods) {
    request.forward = request.forward || !method.usesAtlas();
    request.depthPrepass = request.depthPrepass || method.kind == Kind::ForwardPrepass;
    request.upsample = request.upsample || method.kind == Kind::ForwardLanczos;
    request.warp = request.warp || method.kind == Kind::WarpStereo;
    request.rect = request.rect || method.usesAtlas();
    request.displayDeferred = request.displayDeferred || method.kind == Kind::RectDeferred;
    request.lens = request.lens || method.spatial.options.lens.has_value();
  }
  return request;
}

}  // namespace

Result<ReportScene> compareScene(gl::Context& context, const std::string& file,
                                 const std::vector<Method>& methods, const CompareOptions& options,
                                 glm::ivec2 size) {
  auto stage = loadStageFor(options.stage, file);
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
    // Short runs see as much of the scene as long ones. Without a path, its first camera sees it, or one from
    // outside.
    if (auto covered = coverPath(camera, lit); !covered) return tl::unexpected(covered.error());
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
    setup->request = requestOf(methods);
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
  Runs runs(*engine, views, methods, options);
  for (const Method& method : methods) {
    auto series = runs.run(method, progress);
    if (!series) return fail("{}: {}: {}", file, method.name, series.error().message);
    report.methods.push_back(reportOf(method, std::move(*series)));
  }
  return report;
}

}  // namespace tessera::app
