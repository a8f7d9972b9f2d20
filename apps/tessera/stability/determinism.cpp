// Two runs of the same frames.
#include <algorithm>
#include <array>
#include <map>
#include <memory>

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

using Pair = std::array<Run, 2>;
/// One pair of runs a method, however many cases look at it.
using Done = std::shared_ptr<std::map<Method, Pair>>;

Result<const Pair*> runsOf(Bench& bench, const Done& done, Method method) {
  if (!done->contains(method)) {
    Pair pair;
    for (Run& run : pair) {
      auto made = runOf(bench, method);
      if (!made) return tl::unexpected(made.error());
      run = std::move(*made);
    }
    done->emplace(method, std::move(pair));
  }
  return &done->at(method);
}

/// What differs between two runs.
Result<double> differences(Bench& bench, const Done& done, Method method, bool pictures) {
  const auto pair = runsOf(bench, done, method);
  if (!pair) return tl::unexpected(pair.error());
  const Run* first = &(**pair)[0];
  const Run* second = &(**pair)[1];
  if (pictures) {
    int largest = 0;
    for (std::size_t i = 0; i < first->pictures.size(); ++i)
      largest = std::max(largest, largestDifference(first->pictures[i], second->pictures[i]));
    return largest;
  }
  std::size_t different = 0;
  for (std::size_t i = 0; i < first->ids.size(); ++i) different += first->ids[i] != second->ids[i] ? 1 : 0;
  for (std::size_t i = 0; i < first->figures.size(); ++i)
    different += first->figures[i] != second->figures[i] ? 1 : 0;
  return static_cast<double>(different);
}

}  // namespace

void addDeterminismCases(Cases& cases) {
  const auto done = std::make_shared<std::map<Method, Pair>>();
  for (const Method method : kMethods) {
    const bool atlas = method != Method::Forward;
    cases.push_back(
        {std::string("determinism/") + nameOf(method) + "-picture",
         atlas
             ? "two runs of the same frames; atomics may put blocks elsewhere, which changes the last bit of "
               "what a texel stores and of what filters it: the pictures"
             : "two runs of the same frames: the pictures, to the bit",
         "of 255", atlas ? kLastBits : 0.0, Sense::AtMost,
         [done, method](Bench& bench) { return differences(bench, done, method, true); }});
    if (!atlas) continue;
    cases.push_back({std::string("determinism/") + nameOf(method) + "-figures",
                     "two runs of the same frames: visible triangles, samples, failures, resets", "figures",
                     0.0, Sense::AtMost,
                     [done, method](Bench& bench) { return differences(bench, done, method, false); }});
  }
}

}  // namespace tessera::stability
