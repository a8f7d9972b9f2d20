#include "apps/tessera/atlas_bench.hpp"

#include <filesystem>
#include <memory>

#include <fmt/core.h>

#include "apps/tessera/commands.hpp"

namespace tessera::app {

namespace {

Result<void> atlasBench(const AtlasBenchOptions& options) {
  auto size = parseSize(options.size.text);
  if (!size) return tl::unexpected(size.error());
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());
  for (const std::string& scene : options.scenes) {
    auto stream = recordRequests(**context, scene, options, *size);
    if (!stream) return tl::unexpected(stream.error());
    if (!options.record.empty())
      if (auto saved = stream->save(options.record); !saved) return saved;
  }
  return {};
}

}  // namespace

Run addAtlasBench(CLI::App& app) {
  auto options = std::make_shared<AtlasBenchOptions>();
  options->camera.path = "tour";
  options->camera.frames = 1000;
  options->camera.fps = 0.0;  // unless given: as it takes to see the whole path
  options->atlas.megapixels = 4.0;
  options->atlas.biasFloor = -2.0;
  CLI::App& command = *app.add_subcommand(
      "atlas-bench",
      "Allocators of the atlas memory over the same requests; writes atlas_bench.json and atlas_bench.html");
  command.add_option("scenes", options->scenes, "glTF 2.0 files");
  command.add_option("-o,--output", options->output, "folder for the results")->required();
  command.add_option("--record", options->record,
                     "save the requests to this file; a folder for several scenes");
  command.add_option("--load", options->load, "take requests that were saved before, instead of rendering");
  addContext(command, options->context);
  addSize(command, options->size);
  addCamera(command, options->camera);
  addStage(command, options->stage);
  addAtlas(command, options->atlas);
  // All strategies run, and no texel is drawn that would have a format.
  for (const char* unused : {"--strategy", "--no-merge", "--atlas-format"})
    command.remove_option(command.get_option(unused));
  return [options] { return atlasBench(*options); };
}

}  // namespace tessera::app
