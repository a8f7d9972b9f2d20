#include "apps/tessera/report/report_json.hpp"
#include "apps/tessera/report/study_report.hpp"

namespace tessera {

namespace {

using Json = nlohmann::ordered_json;

Json pointsJson(const std::vector<StudyPoint>& points) {
  Json list = Json::array();
  for (const StudyPoint& p : points)
    list.push_back({{"latency_ms", number(p.latencyMs)},
                    {"server_hz", number(p.serverHz)},
                    {"mbit_s", number(p.mbit)},
                    {"mssim", number(p.mssim)},
                    {"mssim_worst", number(p.mssimWorst)},
                    {"psnr_db", number(p.psnrDb)},
                    {"video_mbit_s", number(p.videoMbit)},
                    {"meta_mbit_s", number(p.metaMbit)},
                    {"first_meta_bytes", number(p.firstMetaBytes)},
                    {"uncovered_pixels", number(p.uncoveredPixels)},
                    {"atlas_used", number(p.atlasUsed)},
                    {"level_bias", number(p.bias)},
                    {"age_ms", number(p.shadedBehindMs)}});
  return list;
}

Json stagesJson(const std::vector<StudyStage>& stages) {
  Json json = Json::object();
  for (const StudyStage& stage : stages) json[stage.name] = number(stage.ms);
  return json;
}

Json timelineJson(const StudyTimeline& t) {
  if (!t.failed.empty()) return {{"failed", t.failed}};
  return {{"method", t.method},
          {"server_ms", stagesJson(t.server)},
          {"viewer_ms", stagesJson(t.viewer)},
          {"total_ms", number(t.totalMs)},
          {"first_picture_s", number(t.firstPictureSeconds)},
          {"video_mbit_s", number(t.videoMbit)},
          {"meta_mbit_s", number(t.metaMbit)},
          {"server_own_share", number(t.ownShare)}};
}

Json sceneJson(const StudyScene& scene) {
  Json methods = Json::array();
  for (const StudyMethod& m : scene.methods)
    methods.push_back({{"name", m.name},
                       {"atlas", m.atlas},
                       {"coded_size", {m.width, m.height}},
                       {"by_latency", pointsJson(m.byLatency)},
                       {"by_server_rate", pointsJson(m.byRate)},
                       {"by_bitrate", pointsJson(m.byBitrate)}});
  Json findings = Json::array();
  for (const StudyFinding& f : findingsOf(scene)) {
    Json finding = {{"text", f.text}};
    if (f.goal) finding["reached"] = f.reached;
    findings.push_back(std::move(finding));
  }
  return {{"file", scene.file},
          {"note", scene.note},
          {"triangles", scene.triangles},
          {"size", {scene.width, scene.height}},
          {"path_start_s", scene.start},
          {"lead_s", scene.leadSeconds},
          {"sampled_s", scene.seconds},
          {"samples", scene.samples},
          {"camera_m_s", number(scene.metresPerSecond)},
          {"camera_deg_s", number(scene.degreesPerSecond)},
          {"methods", std::move(methods)},
          {"findings", std::move(findings)},
          {"timeline", timelineJson(scene.timeline)}};
}

}  // namespace

std::string toJson(const StudyReport& report) {
  Json scenes = Json::array();
  for (const StudyScene& scene : report.scenes) scenes.push_back(sceneJson(scene));
  Json settings = Json::object();
  for (const auto& [name, value] : report.settings) settings[name] = value;
  const Json root = {{"schema", 1},
                     {"context", contextJson(report.context)},
                     {"settings", std::move(settings)},
                     {"scenes", std::move(scenes)}};
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tessera
