#include "apps/tessera/study/study.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "apps/tessera/progress.hpp"
#include "apps/tessera/study/warp_stream.hpp"

namespace tessera::app {

namespace {

bool same(double a, double b) { return std::abs(a - b) < 1e-9; }

/// What is measured of each method, runs that share frames as one.
struct Plan {
  struct Entry {
    double serverHz;
    double latencyMs;
    std::vector<double> bitratesMbit;
    bool filmed = false;
  };
  std::vector<Entry> entries;

  void add(double serverHz, double latencyMs, double mbit, bool filmed) {
    auto found = std::find_if(entries.begin(), entries.end(), [&](const Entry& entry) {
      return same(entry.serverHz, serverHz) && same(entry.latencyMs, latencyMs);
    });
    if (found == entries.end()) found = entries.insert(entries.end(), {serverHz, latencyMs, {}});
    found->filmed |= filmed;
    auto& rates = found->bitratesMbit;
    if (std::none_of(rates.begin(), rates.end(), [&](double one) { return same(one, mbit); }))
      rates.push_back(mbit);
  }

  explicit Plan(const StudySettings& s) {
    for (const double latency : s.latenciesMs) add(s.serverHz, latency, s.mbit, false);
    // The videos' bitrate is the first of their run.
    if (s.videos) add(s.serverHz, s.videoLatencyMs, s.mbit, true);
    for (const double rate : s.serverRates) add(rate, 0.0, s.mbit, false);
    for (const double mbit : s.bitratesMbit) add(s.serverHz, 0.0, mbit, false);
  }

  /// Entries by what is coded: one server rate, the same bitrates.
  std::vector<std::vector<Entry>> alike() const {
    std::vector<std::vector<Entry>> groups;
    for (const Entry& entry : entries) {
      const auto group = std::find_if(groups.begin(), groups.end(), [&](const std::vector<Entry>& one) {
        return same(one.front().serverHz, entry.serverHz) && one.front().bitratesMbit == entry.bitratesMbit;
      });
      if (group == groups.end())
        groups.push_back({entry});
      else
        group->push_back(entry);
    }
    return groups;
  }
};

std::vector<Shot> shotsOf(const StudyPath& path, const StudySettings& settings, bool filmed) {
  const Samples& samples = path.samples();
  std::vector<Shot> shots;
  for (int i = 0; i < samples.count; ++i) shots.push_back({samples.at(i), i, false});
  if (!filmed) return shots;
  const int pictures = static_cast<int>((samples.last() - samples.first) * settings.videoHz + 1e-6) + 1;
  for (int i = 0; i < pictures; ++i) {
    const double time = samples.first + i / settings.videoHz;
    const auto at =
        std::find_if(shots.begin(), shots.end(), [&](const Shot& shot) { return same(shot.time, time); });
    if (at != shots.end())
      at->filmed = true;
    else
      shots.push_back({time, -1, true});
  }
  std::sort(shots.begin(), shots.end(), [](const Shot& a, const Shot& b) { return a.time < b.time; });
  return shots;
}

/// All points of a method, from whichever run.
class Points {
 public:
  void add(const StudyPoint& point) { points_.push_back(point); }
  /// By latency, by rate and by bitrate.
  void fill(StudyMethod& method, const StudySettings& s) const {
    for (const double latency : s.latenciesMs) pick(method.byLatency, s.serverHz, latency, s.mbit);
    for (const double rate : s.serverRates) pick(method.byRate, rate, 0.0, s.mbit);
    for (const double mbit : s.bitratesMbit) pick(method.byBitrate, s.serverHz, 0.0, mbit);
  }

 private:
  void pick(std::vector<StudyPoint>& figure, double serverHz, double latencyMs, double mbit) const {
    for (const StudyPoint& point : points_)
      if (same(point.serverHz, serverHz) && same(point.latencyMs, latencyMs) && same(point.mbit, mbit)) {
        figure.push_back(point);
        return;
      }
  }
  std::vector<StudyPoint> points_;
};

void complete(StudyPoint& point, const StreamRun& run, const StreamFacts& facts, std::size_t bitrate) {
  point.serverHz = run.serverHz;
  point.latencyMs = 1e3 * run.latency;
  point.mbit = run.bitratesMbit[bitrate];
  point.videoMbit = facts.videoMbit[bitrate];
  point.metaMbit = facts.metaMbit;
  point.firstMetaBytes = facts.firstMetaBytes;
  point.atlasUsed = facts.atlasUsed;
  point.bias = facts.bias;
}

class Study {
 public:
  Study(const gl::Context& context, Engine& engine, const StudyPath& path, const StudySettings& settings,
        AtlasStream::Masks masks, StudyScene& scene)
      : context_(context),
        engine_(engine),
        path_(path),
        settings_(settings),
        masks_(std::move(masks)),
        scene_(scene),
        plan_(settings),
        truth_(engine, path) {}

  Result<void> run() {
    for (int i = 0; i < path_.samples().count; ++i) truth_.at(path_.samples().at(i));
    if (auto filmed = filmTruth(); !filmed) return filmed;
    if (auto measured = atlases(); !measured) return measured;
    return warps();
  }

 private:
  [[nodiscard]] bool wants(const char* option) const {
    return std::find(settings_.methods.begin(), settings_.methods.end(), option) != settings_.methods.end();
  }

  Result<void> filmTruth() {
    if (!settings_.videos) return {};
    auto film = Film::create(settings_.size, settings_.videoHz);
    if (!film) return tl::unexpected(film.error());
    for (const Shot& shot : shotsOf(path_, settings_, true))
      if (shot.filmed)
        if (auto added = film->add(truth_.once(shot.time)); !added) return added;
    auto file = film->finish();
    if (!file) return tl::unexpected(file.error());
    scene_.truth = std::move(*file);
    return {};
  }

  StreamRun runOf(const Plan::Entry& entry) const {
    return {entry.serverHz, 1e-3 * entry.latencyMs, entry.bitratesMbit,
            shotsOf(path_, settings_, entry.filmed)};
  }

  Result<void> atlases() {
    auto stream = AtlasStream::create(context_, engine_, path_, settings_, masks_);
    if (!stream) return tl::unexpected(stream.error());
    for (const StudyMethodName& name : studyMethods()) {
      if (name.warp || !wants(name.option)) continue;
      for (const double megapixels : settings_.megapixels) {
        AtlasChoice atlas;
        atlas.sampling = std::string_view(name.option) == "tess" ? Sampling::Tess : Sampling::Rect;
        atlas.megapixels = megapixels;
        atlas.biasFloor = settings_.biasFloor;
        StudyMethod method;
        method.name = fmt::format("{}, {:g} Mpix", name.title, megapixels);
        method.atlas = true;
        if (auto measured = atlasMethod(*stream, atlas, method); !measured) return measured;
        scene_.methods.push_back(std::move(method));
      }
    }
    return {};
  }

  Result<void> atlasMethod(AtlasStream& stream, const AtlasChoice& atlas, StudyMethod& method) {
    Points points;
    Progress progress(scene_.file + ": " + method.name, plan_.entries.size());
    for (const Plan::Entry& entry : plan_.entries) {
      const StreamRun run = runOf(entry);
      auto recorder = Recorder::create(truth_, run.bitratesMbit.size(), entry.filmed, settings_);
      if (!recorder) return tl::unexpected(recorder.error());
      auto facts = stream.run(atlas, run, [&](const Taken& taken) { return recorder->add(taken); });
      if (!facts) return fail("{}: {}", method.name, facts.error().message);
      method.width = facts->width;
      method.height = facts->height;
      for (std::size_t i = 0; i < run.bitratesMbit.size(); ++i) {
        StudyPoint point = recorder->point(i);
        complete(point, run, *facts, i);
        points.add(point);
      }
      if (entry.filmed) {
        auto film = recorder->film();
        if (!film) return tl::unexpected(film.error());
        method.video = std::move(*film);
      }
      progress.step(fmt::format("{:g} ms, {:g} Hz", entry.latencyMs, entry.serverHz));
    }
    points.fill(method, settings_);
    return {};
  }

  /// All warps of one server rate and the same bitrates in one go: they bend the same pictures.
  Result<void> warps() {
    std::vector<Warp> wanted;
    std::vector<StudyMethod> methods;
    for (const StudyMethodName& name : studyMethods()) {
      if (!name.warp || !wants(name.option)) continue;
      wanted.push_back(*name.warp);
      methods.emplace_back().name = name.title;
    }
    if (wanted.empty()) return {};
    auto stream = WarpStream::create(context_, engine_, path_, settings_, std::move(wanted));
    if (!stream) return tl::unexpected(stream.error());
    std::vector<Points> points(methods.size());
    Progress progress(scene_.file + ": warps", plan_.entries.size());
    for (const std::vector<Plan::Entry>& group : plan_.alike()) {
      if (auto measured = warpGroup(*stream, group, methods, points); !measured) return measured;
      for (const Plan::Entry& entry : group)
        progress.step(fmt::format("{:g} ms, {:g} Hz", entry.latencyMs, entry.serverHz));
    }
    for (std::size_t w = 0; w < methods.size(); ++w) points[w].fill(methods[w], settings_);
    std::move(methods.begin(), methods.end(), std::back_inserter(scene_.methods));
    return {};
  }

  Result<void> warpGroup(WarpStream& stream, const std::vector<Plan::Entry>& group,
                         std::vector<StudyMethod>& methods, std::vector<Points>& points) {
    std::vector<StreamRun> runs;
    std::vector<Recorder> recorders;  // of each run, one of each warp
    for (const Plan::Entry& entry : group) {
      runs.push_back(runOf(entry));
      for (std::size_t w = 0; w < methods.size(); ++w) {
        auto recorder = Recorder::create(truth_, entry.bitratesMbit.size(), entry.filmed, settings_);
        if (!recorder) return tl::unexpected(recorder.error());
        recorders.push_back(std::move(*recorder));
      }
    }
    const auto recorderOf = [&](std::size_t warp, std::size_t run) -> Recorder& {
      return recorders[run * methods.size() + warp];
    };
    const auto facts = stream.run(runs, [&](std::size_t warp, std::size_t run, const Taken& taken) {
      return recorderOf(warp, run).add(taken);
    });
    if (!facts) return fail("warps: {}", facts.error().message);
    for (std::size_t w = 0; w < methods.size(); ++w)
      for (std::size_t r = 0; r < runs.size(); ++r) {
        const StreamFacts& said = (*facts)[r];
        methods[w].width = said.width;
        methods[w].height = said.height;
        for (std::size_t i = 0; i < runs[r].bitratesMbit.size(); ++i) {
          StudyPoint point = recorderOf(w, r).point(i);
          complete(point, runs[r], said, i);
          points[w].add(point);
        }
        if (!group[r].filmed) continue;
        auto film = recorderOf(w, r).film();
        if (!film) return tl::unexpected(film.error());
        methods[w].video = std::move(*film);
      }
    return {};
  }

  const gl::Context& context_;
  Engine& engine_;
  const StudyPath& path_;
  const StudySettings& settings_;
  AtlasStream::Masks masks_;
  StudyScene& scene_;
  Plan plan_;
  Truth truth_;
};

}  // namespace

const std::vector<StudyMethodName>& studyMethods() {
  static const std::vector<StudyMethodName> methods = {{"rect", "rect", {}},
                                                       {"tess", "tess", {}},
                                                       {"time-warp", "time warp", Warp::Time},
                                                       {"mesh-warp", "mesh warp", Warp::Mesh},
                                                       {"iterative-warp", "iterative warp", Warp::Iterative}};
  return methods;
}

Result<void> measureStudy(const gl::Context& context, Engine& engine, const StudyPath& path,
                          const StudySettings& settings, AtlasStream::Masks masks, StudyScene& scene) {
  return Study(context, engine, path, settings, std::move(masks), scene).run();
}

}  // namespace tessera::app
