#include "apps/tessera/study/loopback.hpp"

#include <array>
#include <cmath>
#include <csignal>
#include <span>

#include <nlohmann/json.hpp>

#include "apps/tessera/study/process.hpp"
#include "engine/core/file.hpp"

namespace tessera::app {

namespace {

constexpr double kStart = 120.0;  // seconds for the server to load its scene
constexpr double kView = 180.0;   // seconds for the viewer's pictures
constexpr int kPictures = 90;     // that the viewer shows

using Json = nlohmann::ordered_json;

/// As `tessera view --path` reads it.
std::string pathJson(const StudyPath& path) {
  Json keys = Json::array();
  constexpr int kKeys = 60;
  for (int i = 0; i < kKeys; ++i) {
    const double time = path.samples().last() * i / (kKeys - 1);
    const View view = path.at(time).view;
    const glm::dvec3 target = view.eye + view.forward;
    keys.push_back({{"t", time},
                    {"eye", {view.eye.x, view.eye.y, view.eye.z}},
                    {"target", {target.x, target.y, target.z}},
                    {"fov_y", glm::degrees(view.fovY)}});
  }
  return Json({{"keyframes", std::move(keys)}}).dump(1) + "\n";
}

Result<Json> readJson(const std::filesystem::path& file) {
  auto bytes = readFile(file);
  if (!bytes) return tl::unexpected(bytes.error());
  Json json = Json::parse(bytes->begin(), bytes->end(), nullptr, false);
  if (!json.is_object()) return fail("{}: not JSON", file.string());
  return json;
}

double numberOf(const Json& json, const char* name) {
  const auto found = json.find(name);
  return found != json.end() && found->is_number() ? found->get<double>() : kNotMeasured;
}

/// In the order in which a frame passes them; the files have them by name.
constexpr std::array kServerStages = {"visible", "place", "shade",  "convert",
                                      "read",    "meta",  "encode", "send"};
constexpr std::array kViewerStages = {"server", "receive", "decode", "apply", "wait", "upload", "display"};

std::vector<StudyStage> stagesOf(const Json& json, const char* member, std::span<const char* const> names) {
  std::vector<StudyStage> stages;
  const auto found = json.find(member);
  if (found == json.end()) return stages;
  for (const char* name : names)
    if (const double ms = numberOf(*found, name); !std::isnan(ms)) stages.push_back({name, ms});
  return stages;
}

Result<StudyTimeline> measure(const std::string& sceneFile, const std::string& stageFile,
                              const ContextChoice& context, const StudyPath& path,
                              const StudySettings& settings, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail("{}: {}", folder.string(), error.message());
  const auto file = [&](const char* name) { return (folder / name).string(); };
  if (auto written = writeFile(file("path.json"), pathJson(path)); !written)
    return tl::unexpected(written.error());
  for (const char* name : {"serve.json", "view.json"}) std::filesystem::remove(folder / name, error);

  StudyTimeline timeline;
  const double megapixels = settings.megapixels.front();
  timeline.method =
      fmt::format("rect, {:g} Mpix, {:g} Mbit/s, {:g} Hz", megapixels, settings.mbit, settings.serverHz);
  std::vector<std::string> serve = {"serve",        sceneFile,
                                    "--listen",     "127.0.0.1:0",
                                    "--context",    context.name,
                                    "--method",     "rect",
                                    "--atlas-mpix", fmt::format("{}", megapixels),
                                    "--bitrate",    fmt::format("{}M", settings.mbit),
                                    "--fps",        fmt::format("{}", settings.serverHz),
                                    "--stats",      file("serve.json")};
  if (!stageFile.empty()) serve.insert(serve.end(), {"--stage", stageFile});
  auto server = OwnProcess::start(serve);
  if (!server) return tl::unexpected(server.error());
  const std::string listening = "listening on ";
  if (!server->waitFor(", atlas", kStart)) return fail("serve: {}", server->lastLine());
  const std::size_t at = server->said().find(listening) + listening.size();
  const std::string address = server->said().substr(at, server->said().find(',', at) - at);
  auto viewer = OwnProcess::start({"view", address, "--headless", "--context", context.name, "--size",
                                   fmt::format("{}x{}", settings.size.x, settings.size.y), "--path",
                                   file("path.json"), "--fps", "30", "--frames", fmt::format("{}", kPictures),
                                   "--stats", file("view.json")});
  if (!viewer) return tl::unexpected(viewer.error());
  const auto viewed = viewer->wait(kView);
  if (!viewed) return fail("view: {}", viewed.error().message);
  if (*viewed != 0) return fail("view: {}", viewer->lastLine());
  server->signal(SIGTERM);
  const auto served = server->wait(30.0);
  if (!served) return fail("serve: {}", served.error().message);
  if (*served != 0) return fail("serve: {}", server->lastLine());

  const auto serverSaid = readJson(file("serve.json"));
  if (!serverSaid) return tl::unexpected(serverSaid.error());
  const auto viewerSaid = readJson(file("view.json"));
  if (!viewerSaid) return tl::unexpected(viewerSaid.error());
  timeline.server = stagesOf(*serverSaid, "ms", kServerStages);
  timeline.viewer = stagesOf(*viewerSaid, "latency_ms", kViewerStages);
  if (timeline.server.empty() || timeline.viewer.empty()) return fail("serve or view named no stages");
  timeline.totalMs = numberOf((*viewerSaid)["latency_ms"], "total");
  timeline.firstPictureSeconds = numberOf(*viewerSaid, "first_picture_s");
  timeline.videoMbit = numberOf(*viewerSaid, "video_mbit_s");
  timeline.metaMbit = numberOf(*viewerSaid, "meta_mbit_s");
  timeline.ownShare = numberOf(*serverSaid, "own_share");
  return timeline;
}

}  // namespace

StudyTimeline measureLoopback(const std::string& sceneFile, const std::string& stageFile,
                              const ContextChoice& context, const StudyPath& path,
                              const StudySettings& settings, const std::filesystem::path& folder) {
  auto timeline = measure(sceneFile, stageFile, context, path, settings, folder);
  if (timeline) return std::move(*timeline);
  StudyTimeline none;
  none.failed = timeline.error().message;
  return none;
}

}  // namespace tessera::app
