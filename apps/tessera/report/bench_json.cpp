#include <cmath>
#include <utility>

#include "apps/tessera/report/bench_report.hpp"
#include "apps/tessera/report/report_json.hpp"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

Json summaryJson(const std::string& name, const BenchSummary& s) {
  return {{"name", name},
          {"oom_frames", s.oomFrames},
          {"failed_requests", s.failures},
          {"reduced_requests", s.reduced},
          {"resets", s.resets},
          {"live_share", number(s.liveShare)},
          {"kept_place", number(s.keptPlace)},
          {"texels_moved_share", number(s.movedShare)},
          {"texels_moved_share_outside_resets", number(s.movedShareOutsideResets)},
          {"bias_mean", number(s.bias)},
          {"ms_per_frame", timingJson(s.ms)}};
}

Json seriesJson(const BenchRun& run) {
  Json series = Json::object();
  const auto add = [&](const char* name, auto&& value) {
    Json values = Json::array();
    for (const BenchFrame& frame : run.frames) values.push_back(value(frame));
    series[name] = std::move(values);
  };
  const std::pair<const char*, double BenchFrame::*> fields[] = {
      {"live", &BenchFrame::live},          {"end", &BenchFrame::end},
      {"stack", &BenchFrame::stack},        {"inaccessible", &BenchFrame::inaccessible},
      {"free", &BenchFrame::free},          {"blocks_made", &BenchFrame::made},
      {"blocks_moved", &BenchFrame::moved}, {"blocks_freed", &BenchFrame::freed},
      {"failures", &BenchFrame::failures},  {"moved_texels", &BenchFrame::movedTexels},
      {"target", &BenchFrame::target}};
  for (const auto& [name, field] : fields)
    add(name, [field = field](const BenchFrame& frame) { return std::llround(frame.*field); });
  add("reset", [](const BenchFrame& frame) { return frame.reset ? 1 : 0; });
  add("bias", [](const BenchFrame& frame) { return number(std::round(frame.bias * 1e4) / 1e4); });
  add("ms", [](const BenchFrame& frame) { return number(std::round(frame.ms * 1e4) / 1e4); });
  return series;
}

Json runJson(const BenchRun& run) {
  Json json = summaryJson(run.name, summarize(run));
  json["series"] = seriesJson(run);
  return json;
}

Json sceneJson(const BenchScene& scene) {
  Json strategies = Json::array();
  for (const BenchRun& run : scene.strategies) strategies.push_back(runJson(run));
  Json sweep = Json::array();
  for (const BenchVariant& variant : scene.sweep) {
    const bool ran = variant.skipped.empty();
    Json json = ran ? summaryJson("S0", variant.summary) : Json{{"name", "S0"}};
    json["skipped"] = ran ? Json(nullptr) : Json(variant.skipped);
    json["superblock"] = variant.superblock;
    json["smallest_block"] = variant.smallest;
    json["largest_block"] = variant.largest;
    json["largest_aspect"] = variant.aspect;
    json["default"] = variant.standard;
    sweep.push_back(std::move(json));
  }
  return {{"scene", scene.scene},
          {"size", {scene.width, scene.height}},
          {"fps", scene.fps},
          {"patch_instances", scene.patchInstances},
          {"visible_patches", number(scene.visiblePatches)},
          {"atlas", {scene.atlasWidth, scene.atlasHeight}},
          {"recorded_frame_ms", timingJson(scene.frameMs)},
          {"recorded_memory_ms", timingJson(scene.memoryMs)},
          {"strategies", std::move(strategies)},
          {"cpu_quadtree", runJson(scene.quadtree)},
          {"sweep", std::move(sweep)}};
}

double meanOf(const std::vector<BenchSummary>& all, double BenchSummary::*field) {
  double sum = 0.0;
  double count = 0.0;
  for (const BenchSummary& one : all) {
    if (std::isnan(one.*field)) continue;
    sum += one.*field;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : kNotMeasured;
}

/// Counts summed, all else the mean of the scenes' values.
BenchSummary overScenes(const std::vector<BenchSummary>& all) {
  BenchSummary over;
  for (const BenchSummary& one : all) {
    over.frames += one.frames;
    over.oomFrames += one.oomFrames;
    over.failures += one.failures;
    over.reduced += one.reduced;
    over.resets += one.resets;
    over.ms.count += one.ms.count;
  }
  for (const auto field : {&BenchSummary::liveShare, &BenchSummary::keptPlace, &BenchSummary::movedShare,
                           &BenchSummary::movedShareOutsideResets, &BenchSummary::bias})
    over.*field = meanOf(all, field);
  for (const auto field : {&Statistics::median, &Statistics::p95, &Statistics::min, &Statistics::spread}) {
    double sum = 0.0;
    for (const BenchSummary& one : all) sum += one.ms.*field;
    over.ms.*field = sum / static_cast<double>(all.size());
  }
  return over;
}

}  // namespace

std::string toJson(const BenchReport& report) {
  Json strategies = Json::array();
  Json quadtree = nullptr;
  if (!report.scenes.empty()) {
    const BenchScene& first = report.scenes.front();
    for (std::size_t i = 0; i < first.strategies.size(); ++i) {
      std::vector<BenchSummary> all;
      for (const BenchScene& scene : report.scenes) all.push_back(summarize(scene.strategies[i]));
      strategies.push_back(summaryJson(first.strategies[i].name, overScenes(all)));
    }
    std::vector<BenchSummary> all;
    for (const BenchScene& scene : report.scenes) all.push_back(summarize(scene.quadtree));
    quadtree = summaryJson(first.quadtree.name, overScenes(all));
  }
  Json scenes = Json::array();
  for (const BenchScene& scene : report.scenes) scenes.push_back(sceneJson(scene));
  const Json root = {{"schema", 1},
                     {"context", contextJson(report.context)},
                     {"settings", report.settings},
                     {"strategies", std::move(strategies)},
                     {"cpu_quadtree", std::move(quadtree)},
                     {"scenes", std::move(scenes)}};
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tessera
