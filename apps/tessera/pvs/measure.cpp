#include "apps/tessera/pvs/measure.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "engine/measure/pvs_coverage.hpp"

namespace tessera::app {

namespace {

/// Counts what one view after another shows.
class Counter {
 public:
  explicit Counter(Engine& engine)
      : engine_(engine), triangles_(engine.visibleSet()->element() == VisibleElement::Triangle) {
    counts_.pixels.resize(engine.visibleSet()->capacity());
  }
  /// Of the last view of Engine::findVisible.
  void add() {
    for (const std::uint32_t id : engine_.readIds())
      if (id != 0) ++counts_.pixels[triangles_ ? id - 4 : (id >> 2U) - 1];
    ++counts_.views;
  }
  [[nodiscard]] const ElementPixels& counts() const { return counts_; }

 private:
  Engine& engine_;
  bool triangles_;
  ElementPixels counts_;
};

/// Draws the ids of the views and gives the milliseconds that this and marking took.
double find(Engine& engine, std::span<const TimedView> views) {
  engine.clearTimes();
  engine.findVisible(views);
  double ms = 0.0;
  for (const PassTime& pass : engine.times()) ms += pass.milliseconds;
  return ms;
}

std::vector<bool> setOf(const Engine& engine) {
  std::vector<bool> set(engine.visibleSet()->capacity());
  for (const std::uint32_t element : engine.visibleSet()->read()) set[element] = true;
  return set;
}

Result<PvsFrame> frameOf(Engine& engine, std::span<const TimedView> path, std::size_t present,
                         const PvsOptions& options, const ElementPixels& shown, PvsRun& run) {
  PoseTrack track;
  track.add(path[present - 1]);
  track.add(path[present]);
  const auto views = widened(predictedViews(track, path, options), options.margin);
  if (!views) return tl::unexpected(views.error());
  if (run.frames.empty()) {
    run.views = static_cast<int>(views->size());
    run.width = views->front().view.width;
    run.height = views->front().view.height;
  }
  PvsFrame frame;
  frame.time = path[present].time;
  frame.ms = find(engine, *views);
  const std::vector<bool> set = setOf(engine);
  Counter sampled(engine);
  for (const TimedView& view : *views) {
    if (views->size() > 1) find(engine, {&view, 1});
    sampled.add();
  }
  const PvsCoverage coverage = coverageOf(shown, sampled.counts(), set);
  frame.coverage = coverage.coverage();
  frame.overestimation = coverage.overestimation();
  frame.missedPixels = coverage.missed;
  frame.elements = static_cast<double>(coverage.setElements);
  frame.neededElements = static_cast<double>(coverage.neededElements);
  return frame;
}

}  // namespace

std::size_t PvsSampling::shownViews() const {
  return 1 + static_cast<std::size_t>(std::llround(latency * rate));
}

std::vector<std::size_t> presentPoses(std::size_t poses, std::size_t shownViews, std::size_t frames) {
  std::vector<std::size_t> presents;
  if (poses < 1 + shownViews) return presents;
  const std::size_t starts = poses - shownViews;  // of index 1 to this
  const std::size_t count = std::min(frames, starts);
  for (std::size_t i = 0; i < count; ++i)
    presents.push_back(count == 1 ? 1 + (starts - 1) / 2 : 1 + i * (starts - 1) / (count - 1));
  return presents;
}

std::string nameOf(Prediction prediction) {
  return prediction == Prediction::None ? "none" : prediction == Prediction::Linear ? "linear" : "reference";
}

std::string nameOf(const PvsOptions& options) {
  std::string name =
      fmt::format("{}, margin {:g}°", nameOf(options.prediction), glm::degrees(options.margin));
  if (options.prediction != Prediction::None)
    name += fmt::format(", {} step{}", options.steps, options.steps == 1 ? "" : "s");
  return name;
}

Result<PvsScene> measurePvs(Engine& engine, std::span<const TimedView> path, const PvsSampling& sampling,
                            std::span<const PvsOptions> ways, const std::function<void()>& step) {
  const std::size_t shownViews = sampling.shownViews();
  const auto presents = presentPoses(path.size(), shownViews, static_cast<std::size_t>(sampling.frames));
  if (presents.empty())
    return fail("the path has {} poses at {:g} Hz; a latency of {:g} ms takes {}", path.size(), sampling.rate,
                1e3 * sampling.latency, shownViews + 1);
  PvsScene scene;
  scene.width = path.front().view.width;
  scene.height = path.front().view.height;
  scene.rate = sampling.rate;
  scene.latencyMs = 1e3 * sampling.latency;
  scene.shownViews = static_cast<int>(shownViews);
  scene.element = engine.visibleSet()->element() == VisibleElement::Triangle ? "triangle" : "patch";
  for (const PvsOptions& options : ways) {
    PvsRun& run = scene.runs.emplace_back();
    run.name = nameOf(options);
    run.prediction = nameOf(options.prediction);
    run.marginDegrees = glm::degrees(options.margin);
    run.steps = options.prediction == Prediction::None ? 0 : options.steps;
  }
  // Some drivers compile at the first draw.
  find(engine, path.first(1));
  std::vector<double> idMs;
  for (const std::size_t present : presents) {
    Counter shown(engine);
    for (const TimedView& view : path.subspan(present, shownViews)) {
      idMs.push_back(find(engine, {&view, 1}));
      shown.add();
    }
    for (std::size_t i = 0; i < ways.size(); ++i) {
      auto frame = frameOf(engine, path, present, ways[i], shown.counts(), scene.runs[i]);
      if (!frame) return tl::unexpected(frame.error());
      scene.runs[i].frames.push_back(*frame);
    }
    step();
  }
  scene.idMs = summarize(idMs);
  return scene;
}

}  // namespace tessera::app
