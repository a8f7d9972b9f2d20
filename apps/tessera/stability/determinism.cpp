// Two runs of the same frames.
#include "apps/tessera/stability/case.hpp"
#include "apps/tessera/stability/motion.hpp"

namespace tessera::stability {

namespace {

struct Run {
  std::vector<Image> pictures;
  std::vector<std::uint32_t> ids;
  std::vector<std::uint64_t> figures;  // of statistics, that do not hang on where atomics placed what
};

Result<Run> runOf(Bench& bench, Method method) {
  auto made = makeEngine(bench, hall(), hallLights());
  if (!made) return tl::unexpected(made.error());
  Engine& engine = **made;
  if (auto used = use(engine, method); !used) return tl::unexpected(used.error());
  Run run;
  for (int frame = 0; frame < 6; ++frame) {
    auto image = draw(engine, method, onTheWay(0.07 * frame));
    if (!image) return tl::unexpected(image.error());
    run.pictures.push_back(std::move(*image));
    if (method == Method::Forward) continue;
    const auto ids = engine.readIds();
    run.ids.insert(run.ids.end(), ids.begin(), ids.end());
    const GatherStatistics statistics = engine.gatherer()->readStatistics();
    run.figures.insert(run.figures.end(),
                       {statistics.samples, statistics.visible, statistics.failures, statistics.resets,
                        statistics.liveTexels, engine.visibleTriangles()});
  }
  return run;
}

/// What differs between two runs.
Result<double> differences(Bench& bench, Method method, bool pictures) {
  const auto first = runOf(bench, method);
  if (!first) return tl::unexpected(first.error());
  const auto second = runOf(bench, method);
  if (!second) return tl::unexpected(second.error());
  std::size_t different = 0;
  if (pictures) {
    for (std::size_t i = 0; i < first->pictures.size(); ++i)
      different += countDifferent(first->pictures[i], second->pictures[i]);
  } else {
    for (std::size_t i = 0; i < first->ids.size(); ++i) different += first->ids[i] != second->ids[i] ? 1 : 0;
    for (std::size_t i = 0; i < first->figures.size(); ++i)
      different += first->figures[i] != second->figures[i] ? 1 : 0;
  }
  return static_cast<double>(different);
}

}  // namespace

void addDeterminismCases(Cases& cases) {
  for (const Method method : kMethods) {
    cases.push_back({std::string("determinism/") + nameOf(method) + "-picture",
                     "two runs of the same frames, whose blocks atomics may have put elsewhere: the pictures",
                     "bytes", 0.0, Sense::AtMost,
                     [method](Bench& bench) { return differences(bench, method, true); }});
    if (method == Method::Forward) continue;
    cases.push_back({std::string("determinism/") + nameOf(method) + "-figures",
                     "two runs of the same frames: visible triangles, samples, failures, resets", "figures",
                     0.0, Sense::AtMost,
                     [method](Bench& bench) { return differences(bench, method, false); }});
  }
}

}  // namespace tessera::stability
