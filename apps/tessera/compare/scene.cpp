#include "apps/tessera/compare/scene.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>

#include <fmt/format.h>

#include "apps/tessera/compare/equal_samples.hpp"
#include "apps/tessera/compare/runs.hpp"
#include "apps/tessera/measured_scene.hpp"

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

struct PvsMethod {
  Method method;
  std::string of;  // the method's without the set
};

/// Each method that fills an atlas for one view, with each of the sets.
std::vector<PvsMethod> pvsMethods(const std::vector<Method>& methods, const std::vector<Pvs>& sets) {
  std::vector<PvsMethod> moving;
  for (const Method& method : methods)
    for (const Pvs& set : sets) {
      if (!method.usesAtlasOnce()) continue;
      moving.push_back({method, method.name});
      moving.back().method.pvs = set;
      moving.back().method.name += " (" + nameOf(set) + ")";
    }
  return moving;
}

// Added to a method's own bias: from twice the samples to a quarter.
constexpr std::array<double, 5> kCurveBiases = {-1.0, -0.5, 0.0, 1.0, 2.0};

std::vector<Method> curveMethods(const std::vector<Method>& methods) {
  std::vector<Method> swept;
  std::copy_if(methods.begin(), methods.end(), std::back_inserter(swept),
               [](const Method& method) { return method.usesAtlasOnce(); });
  return swept;
}

Result<std::vector<ReportCurvePoint>> curveOf(Runs& runs, const Method& method, const ReportScene& scene,
                                              Progress& progress) {
  std::vector<ReportCurvePoint> curve;
  for (const double step : kCurveBiases) {
    Method biased = method;
    biased.atlas.bias += step;
    auto series = runs.run(biased, progress, Runs::Wanted::Numbers);
    if (!series) return tl::unexpected(series.error());
    const ReportMethod point = reportOf(biased, std::move(*series));
    curve.push_back(
        {biased.atlas.bias, shadedPerTargetPixel(scene, point), point.mssim, point.gatherMs.median});
  }
  return curve;
}

}  // namespace

Result<ReportScene> compareScene(gl::Context& context, const std::string& file,
                                 const std::vector<Method>& asked, const std::vector<Pvs>& pvs,
                                 const CompareOptions& options, glm::ivec2 size) {
  auto setup = engineOptions(options.atlas);
  if (!setup) return tl::unexpected(setup.error());
  ReportScene report;
  std::vector<TimedView> views;
  std::unique_ptr<Engine> engine;
  {
    Progress loading(file);
    const auto step = [&](const std::string& text) { loading.step(text); };
    auto measured = loadMeasured(file, options.stage, options.camera, size, step);
    if (!measured) return tl::unexpected(measured.error());
    views = std::move(measured->views);
    report.file = file;
    report.triangles = measured->scene.triangleCount();
    report.instances = measured->scene.instances.size();
    report.materials = measured->scene.materials.size();
    report.lights = measured->lights;
    report.note = fmt::format("{}; path {}; atlas {} x {}", measured->stageNote, measured->path,
                              setup->atlas.memory.width, setup->atlas.memory.height);
    setup->request = requestOf(asked);
    setup->timePasses = true;
    setup->countFragments = true;
    setup->progress = step;
    auto made = Engine::create(context, std::move(measured->scene), std::move(measured->stage), *setup);
    if (!made) return tl::unexpected(made.error());
    engine = std::move(*made);
  }
  std::vector<Method> methods = asked;
  if (options.equalSamples)
    if (auto equal = equalizeSamples(*engine, views, options.warmup, methods); !equal)
      return fail("{}: {}", file, equal.error().message);
  const std::vector<PvsMethod> moving = pvsMethods(methods, pvs);
  const std::vector<Method> swept = options.curve ? curveMethods(methods) : std::vector<Method>();
  report.width = size.x;
  report.height = size.y;
  report.frames = static_cast<int>(views.size());
  report.errorMetric = "FLIP";
  report.errorFull = static_cast<double>(kErrorFull);
  Progress progress(std::filesystem::path(file).filename().string(),
                    (methods.size() + moving.size() + kCurveBiases.size() * swept.size()) * views.size());
  Runs runs(*engine, views, methods, options);
  for (const Method& method : methods) {
    auto series = runs.run(method, progress);
    if (!series) return fail("{}: {}: {}", file, method.name, series.error().message);
    report.methods.push_back(reportOf(method, std::move(*series)));
  }
  report.crops = runs.crops();
  if (const Method* reference = samplesReference(methods)) report.atlasReference = reference->name;
  for (const auto& [method, of] : moving) {
    auto series = runs.run(method, progress, Runs::Wanted::Numbers);
    if (!series) return fail("{}: {}: {}", file, method.name, series.error().message);
    const auto sampled = static_cast<int>(pvsViews(views.front().view, *method.pvs).size());
    report.pvs.push_back(
        {{of, method.pvs->radius, method.pvs->degrees, sampled + 1}, reportOf(method, std::move(*series))});
  }
  for (const Method& method : swept) {
    auto curve = curveOf(runs, method, report, progress);
    if (!curve) return fail("{}: {}: {}", file, method.name, curve.error().message);
    for (ReportMethod& reported : report.methods)
      if (reported.name == method.name) reported.curve = std::move(*curve);
  }
  return report;
}

}  // namespace tessera::app
