// tessera info: what a scene holds, and what it calls for.
#include <set>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/context_json.hpp"

namespace tessera::app {

namespace {

struct InfoOptions {
  std::string scene;
  bool json = false;
  bool graph = false;
  ContextChoice context;
  StageChoice stage;
};

nlohmann::json describe(const Engine& engine, const gl::ContextInfo& context) {
  const Scene& scene = engine.scene();
  const DrawScene& draw = engine.drawScene();
  nlohmann::json json;
  json["schema"] = 1;
  json["file"] = scene.file;
  json["context"] = contextJson(context, engine.timerMode());
  json["counts"] = {{"triangles", scene.triangleCount()},
                    {"instances", scene.instances.size()},
                    {"meshes", scene.meshes.size()},
                    {"primitives", scene.primitives.size()},
                    {"materials", scene.materials.size()},
                    {"images", scene.images.size()},
                    {"nodes", scene.nodes.size()},
                    {"lights", scene.lights.size()},
                    {"cameras", scene.cameras.size()},
                    {"animations", scene.animations.size()},
                    {"vertices", scene.vertices.position.size()}};
  json["bounds"] = {{"min", {scene.bounds.min.x, scene.bounds.min.y, scene.bounds.min.z}},
                    {"max", {scene.bounds.max.x, scene.bounds.max.y, scene.bounds.max.z}}};
  json["effects"] = nlohmann::json::array();
  for (const Effect& effect : engine.features().effects)
    json["effects"].push_back({{"name", effect.name}, {"reason", effect.reason}});
  json["passes"] = nlohmann::json::array();
  for (const Pass& pass : engine.graph().passes()) json["passes"].push_back(pass.name);
  json["permutations"] = engine.permutations();
  const double all = static_cast<double>(draw.trianglesPaired + draw.trianglesTripled + draw.trianglesAlone);
  const auto share = [&](std::uint64_t count) { return all > 0.0 ? static_cast<double>(count) / all : 0.0; };
  json["patches"] = {{"count", draw.patchInstances},
                     {"triangles_in_pairs", share(draw.trianglesPaired)},
                     {"triangles_in_triples", share(draw.trianglesTripled)},
                     {"triangles_alone", share(draw.trianglesAlone)},
                     {"seconds", draw.patchSeconds}};
  nlohmann::json cameras = nlohmann::json::array();
  for (const Camera& camera : scene.cameras) cameras.push_back(camera.name);
  json["cameras"] = cameras;
  json["warnings"] = scene.warnings;
  return json;
}

void printText(const nlohmann::json& json) {
  fmt::print("{}\n", json["file"].get<std::string>());
  for (const auto& [name, value] : json["counts"].items()) fmt::print("  {:<12} {}\n", name, value.dump());
  fmt::print("effects\n");
  for (const auto& effect : json["effects"])
    fmt::print("  {:<20} {}\n", effect["name"].get<std::string>(), effect["reason"].get<std::string>());
  fmt::print("passes\n");
  for (const auto& pass : json["passes"]) fmt::print("  {}\n", pass.get<std::string>());
  fmt::print("permutations: {}\n", json["permutations"].size());
  for (const auto& permutation : json["permutations"]) fmt::print("  {}\n", permutation.get<std::string>());
  const auto& patches = json["patches"];
  fmt::print(
      "patches: {}; triangles in pairs {:.1f} %, in triples {:.1f} %, alone {:.1f} %; built in {:.2f} s\n",
      patches["count"].get<std::uint64_t>(), 100.0 * patches["triangles_in_pairs"].get<double>(),
      100.0 * patches["triangles_in_triples"].get<double>(), 100.0 * patches["triangles_alone"].get<double>(),
      patches["seconds"].get<double>());
  for (const auto& warning : json["warnings"]) fmt::print("warning: {}\n", warning.get<std::string>());
}

Result<void> info(const InfoOptions& options) {
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());
  if (options.scene.empty()) {
    const auto json = contextJson((*context)->info(), gl::timerModeFor((*context)->info()));
    fmt::print("{}\n", json.dump(2));
    return {};
  }
  auto stage = loadStageOf(options.stage);
  if (!stage) return tl::unexpected(stage.error());
  auto scene = loadGltf(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  EngineOptions setup;
  auto engine = Engine::create(**context, std::move(*scene), std::move(*stage), setup);
  if (!engine) return tl::unexpected(engine.error());
  if (options.graph) {
    fmt::print("{}", (*engine)->graph().graphviz());
    return {};
  }
  const auto json = describe(**engine, (*context)->info());
  if (options.json)
    fmt::print("{}\n", json.dump(2));
  else
    printText(json);
  return {};
}

}  // namespace

Run addInfo(CLI::App& app) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App& command =
      *app.add_subcommand("info", "Print what a scene holds and calls for; without a scene, the context");
  command.add_option("scene", options->scene, "glTF 2.0 file");
  command.add_flag("--json", options->json, "as JSON");
  command.add_flag("--graph", options->graph, "the passes as Graphviz text");
  addContext(command, options->context);
  addStage(command, options->stage);
  return [options](const std::string&) { return info(*options); };
}

}  // namespace tessera::app
