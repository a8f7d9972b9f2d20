#include "apps/tessera/accuracy/measure.hpp"

#include <algorithm>

#include "apps/tessera/accuracy/supersample.hpp"
#include "apps/tessera/compare/drawing.hpp"
#include "apps/tessera/compare/quality.hpp"
#include "apps/tessera/compare/runs.hpp"
#include "engine/measure/colormap.hpp"

namespace tessera::app {

namespace {

double bytesOf(Engine& engine, bool atlas) {
  double sum = 0.0;
  for (const auto& [purpose, bytes] : engine.memory())
    if (atlas || purpose != "atlas") sum += static_cast<double>(bytes);
  return sum;
}

}  // namespace

Result<Measuring> Measuring::create(gl::Context& context, const MeasuredScene& scene,
                                    const MeasureOptions& options,
                                    std::function<void(const std::string&)> step) {
  Measuring measuring(context, scene, options, std::move(step));
  auto plain = configurationOf({{"method", "forward"}});
  if (!plain) return tl::unexpected(plain.error());
  auto engine = measuring.engineFor(*plain);
  if (!engine) return tl::unexpected(engine.error());
  // The best that there is: shadow maps as fine as they get, too.
  if (auto sized = (*engine)->setShadowSize(kReferenceShadowSize); !sized)
    return tl::unexpected(sized.error());
  for (const TimedView& timed : scene.views) {
    TimedView large = timed;
    large.view.width *= options.supersampling;
    large.view.height *= options.supersampling;
    auto drawn = drawFrame(**engine, plain->method, large, {.read = true});
    if (!drawn) return tl::unexpected(drawn.error());
    measuring.references_.push_back(averaged(drawn->pictures.front(), options.supersampling));
    if (measuring.step_) measuring.step_("reference");
  }
  return measuring;
}

Result<Engine*> Measuring::engineFor(const Configuration& configuration) {
  // Forward draws the same whatever patches there are: it takes the engine of the standard ones.
  if (configuration.isForward()) {
    auto standard = configurationOf({});
    if (!standard) return tl::unexpected(standard.error());
    standard->forms = configuration.forms;
    return engineFor(*standard);
  }
  auto setup = engineOptions(configuration.method.atlas);
  if (!setup) return tl::unexpected(setup.error());
  std::unique_ptr<Engine>& engine = engines_[{setup->splitEdges, setup->patches.pair, configuration.forms}];
  if (engine) return engine.get();
  setup->request = {.rect = true,
                    .displayGeometry = true,
                    .displayDeferred = true,
                    .forward = true,
                    .depthPrepass = true,
                    .upsample = true};
  setup->forms = configuration.forms;
  setup->timePasses = true;
  setup->countFragments = true;
  auto made = Engine::create(*context_, scene_->scene, scene_->stage, *setup);
  if (!made) return tl::unexpected(made.error());
  engine = std::move(*made);
  return engine.get();
}

Result<void> Measuring::frame(Engine& engine, const Configuration& configuration, std::size_t f,
                              bool thorough, RunResult& result, std::vector<double>& decibels) const {
  const Method& method = configuration.method;
  auto drawn = drawFrame(engine, method, scene_->views[f], {.read = true});
  if (!drawn) return tl::unexpected(drawn.error());
  for (const PassTime& pass : drawn->times) result.ms += pass.milliseconds;
  const MetricChoice metrics{.psnr = thorough, .flip = thorough};
  auto quality = qualityOf({&references_[f], 1}, drawn->pictures, metrics, {}, scene_->views[f].view.fovY);
  if (!quality) return tl::unexpected(quality.error());
  result.dssim += dssim(quality->mssim);
  if (!thorough) return {};
  decibels.push_back(quality->psnr);
  result.flip += quality->flip;
  if (method.usesAtlas()) {
    const GatherStatistics stats = engine.gatherer()->readStatistics();
    result.samples += static_cast<double>(stats.samples);
    result.texels += static_cast<double>(stats.liveTexels);
  } else {
    result.samples += static_cast<double>(drawn->passed);
  }
  result.bytes += bytesOf(engine, method.usesAtlas());
  if (f == shown()) {
    result.picture = std::move(drawn->pictures.front());
    result.error = errorMap(*quality->error, kErrorFull);
  }
  return {};
}

Result<RunResult> Measuring::run(const Configuration& configuration, bool thorough) {
  auto engine = engineFor(configuration);
  if (!engine) return tl::unexpected(engine.error());
  if (auto sized = (*engine)->setShadowSize(configuration.shadowSize); !sized)
    return tl::unexpected(sized.error());
  (*engine)->setShadowFilter(configuration.shadowFilter);
  if (auto made = useAtlas(**engine, configuration.method); !made) return tl::unexpected(made.error());
  const std::vector<TimedView>& views = scene_->views;
  for (int i = 0; i < options_.warmup; ++i)
    if (auto drawn = drawFrame(**engine, configuration.method, views.front(), {}); !drawn)
      return tl::unexpected(drawn.error());
  RunResult result;
  result.flip = thorough ? 0.0 : kNotMeasured;
  std::vector<double> decibels;
  for (std::size_t f = 0; f < views.size(); ++f)
    if (auto done = frame(**engine, configuration, f, thorough, result, decibels); !done)
      return fail("frame {}: {}", f, done.error().message);
  const auto frames = static_cast<double>(views.size());
  for (double* sum :
       {&result.ms, &result.dssim, &result.flip, &result.samples, &result.texels, &result.bytes})
    *sum /= frames;
  if (thorough) result.psnrDb = pooledPsnr(decibels);
  return result;
}

}  // namespace tessera::app
