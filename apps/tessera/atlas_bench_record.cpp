#include <algorithm>
#include <filesystem>
#include <numeric>

#include "apps/tessera/atlas_bench.hpp"
#include "apps/tessera/progress.hpp"

namespace tessera::app {

namespace {

// Whole frames are slow on software renderers; their time changes slowly along a path.
constexpr std::size_t kWholeFrames = 16;

RequestFrame requestsOf(Engine& engine) {
  const std::vector<std::uint32_t> list = engine.visibleSet()->read();
  const auto measures = engine.atlas()->memory().measures().readAll<glsl::PatchMeasure>(list.size());
  // The list is in the order of compaction, which depends on threads.
  std::vector<std::uint32_t> order(list.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return list[a] < list[b]; });
  RequestFrame frame;
  for (const std::uint32_t i : order) {
    frame.patches.push_back(list[i]);
    frame.measures.push_back(measures[i]);
  }
  return frame;
}

void addTimes(const std::vector<PassTime>& passes, RequestFrame& frame) {
  for (const PassTime& pass : passes) {
    frame.frameMs += static_cast<float>(pass.milliseconds);
    if (pass.name == "memory") frame.memoryMs += static_cast<float>(pass.milliseconds);
  }
}

}  // namespace

Result<RequestStream> recordRequests(gl::Context& context, const std::string& file,
                                     const AtlasBenchOptions& options, glm::ivec2 size) {
  auto stage = loadStageFor(options.stage, file);
  if (!stage) return tl::unexpected(stage.error());
  auto setup = engineOptions(options.atlas);
  if (!setup) return tl::unexpected(setup.error());
  std::vector<TimedView> views;
  std::unique_ptr<Engine> engine;
  CameraChoice camera = options.camera;
  {
    Progress loading(file);
    const auto step = [&](const std::string& text) { loading.step(text); };
    auto scene = loadGltf(file, {.loadImages = true, .progress = step});
    if (!scene) return tl::unexpected(scene.error());
    const Stage* lit = *stage ? &**stage : nullptr;
    if (auto covered = coverPath(camera, lit); !covered) return tl::unexpected(covered.error());
    if (camera.path.empty() && camera.camera.empty() && camera.eye.empty())
      return fail("{}: its stage has no path '{}': give --path, or --camera or --eye to stand still", file,
                  camera.pathUnlessChosen);
    auto found = viewsOf(camera, *scene, lit, size);
    if (!found) return tl::unexpected(found.error());
    views = std::move(*found);
    setup->request = {.rect = true, .displayGeometry = true, .displayDeferred = false, .forward = false};
    setup->timePasses = true;
    setup->progress = step;
    auto made = Engine::create(context, std::move(*scene), std::move(*stage), *setup);
    if (!made) return tl::unexpected(made.error());
    engine = std::move(*made);
  }
  const std::string name = std::filesystem::path(file).filename().string();
  RequestStream stream({.scene = name,
                        .width = static_cast<std::uint32_t>(size.x),
                        .height = static_cast<std::uint32_t>(size.y),
                        .patchInstances = engine->visibleSet()->capacity(),
                        .fps = camera.fps});
  engine->update(views.front().time);
  engine->rect(views.front().view);  // some drivers compile at the first draw
  const std::size_t every = std::max<std::size_t>(1, views.size() / kWholeFrames);
  Progress progress("recording " + name, views.size());
  for (std::size_t f = 0; f < views.size(); ++f) {
    const TimedView& timed = views[f];
    const std::array<View, 1> one = {timed.view};
    // Whole ones lie in the middle of their stretch of the path.
    const bool whole = f % every == every / 2;
    engine->clearTimes();
    // Lights, and the shadow maps that come with them, change nothing about what is visible.
    if (whole || engine->features().animated) engine->update(timed.time);
    engine->findVisible(one);
    engine->place(one);
    if (whole) {
      engine->shade(timed.view);
      engine->display(timed.view);
    }
    RequestFrame frame = requestsOf(*engine);
    if (whole) addTimes(engine->times(), frame);
    if (auto added = stream.add(frame); !added) return tl::unexpected(added.error());
    progress.step();
  }
  return stream;
}

}  // namespace tessera::app
