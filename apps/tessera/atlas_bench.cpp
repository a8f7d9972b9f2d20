#include "apps/tessera/atlas_bench.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include <fmt/core.h>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/report_output.hpp"
#include "engine/gl/timer.hpp"

namespace tessera::app {

namespace {

Result<std::vector<BenchStrategy>> strategiesOf(const AtlasBenchOptions& options) {
  static const std::map<std::string, BenchStrategy> kKnown = {
      {"S0", {"S0", AtlasStrategy::S0, true}},
      {"S0-unmerged", {"S0-unmerged", AtlasStrategy::S0, false}},
      {"S1", {"S1", AtlasStrategy::S1, false}},
      {"S2", {"S2", AtlasStrategy::S2, false}},
      {"S3", {"S3", AtlasStrategy::S3, false}}};
  std::vector<BenchStrategy> strategies;
  for (const std::string& name : options.strategies) {
    const auto known = kKnown.find(name);
    if (known == kKnown.end()) return fail("--strategies {}: not one of S0, S0-unmerged, S1, S2, S3", name);
    strategies.push_back(known->second);
  }
  return strategies;
}

/// `standard` first, then one size at a time changed. Not all of them need fit the atlas.
std::vector<RectMemoryOptions> variantsOf(const RectMemoryOptions& standard) {
  std::vector<RectMemoryOptions> variants = {standard};
  const auto largestOf = [](const RectMemoryOptions& o) { return std::min(o.largestLog2, o.superblockLog2); };
  for (int log2 = 4; log2 <= static_cast<int>(glsl::kMaxBlockLog2); ++log2) {
    RectMemoryOptions variant = standard;
    variant.superblockLog2 = log2;
    if (log2 != standard.superblockLog2) variants.push_back(variant);
  }
  for (int log2 = 4; log2 < standard.superblockLog2; ++log2) {
    RectMemoryOptions variant = standard;
    variant.largestLog2 = log2;
    if (log2 != largestOf(standard)) variants.push_back(variant);
  }
  for (int log2 = 0; log2 <= 2; ++log2) {
    RectMemoryOptions variant = standard;
    variant.smallestLog2 = log2;
    if (log2 != standard.smallestLog2) variants.push_back(variant);
  }
  for (int log2 = 1; log2 <= 6; ++log2) {
    RectMemoryOptions variant = standard;
    variant.aspectLog2 = log2;
    if (log2 != standard.aspectLog2) variants.push_back(variant);
  }
  return variants;
}

/// "256/1-256/1024": superblock, smallest and largest block, aspect.
std::string sizesOf(const BenchVariant& v) {
  return fmt::format("{}/{}-{}/{}", v.superblock, v.smallest, v.largest, v.aspect);
}

Result<std::vector<BenchVariant>> sweep(gl::Context& context, gl::ProgramCache& programs,
                                        const RequestStream& stream, const RectMemoryOptions& standard) {
  const auto variants = variantsOf(standard);
  std::vector<BenchVariant> results;
  Progress progress("sweep of " + stream.header().scene, variants.size() * stream.frames());
  for (const RectMemoryOptions& variant : variants) {
    BenchVariant result;
    result.superblock = 1 << variant.superblockLog2;
    result.smallest = 1 << variant.smallestLog2;
    result.largest = 1 << std::min(variant.largestLog2, variant.superblockLog2);
    result.aspect = 1 << variant.aspectLog2;
    result.standard = results.empty();
    auto memory = RectMemory::create(programs, variant, stream.header().patchInstances);
    if (memory) {
      auto run = runOnGpu(context, std::move(*memory), stream, sizesOf(result), progress);
      if (!run) return tl::unexpected(run.error());
      result.summary = summarize(*run);
    } else {
      result.skipped = memory.error().message;
    }
    results.push_back(std::move(result));
  }
  return results;
}

Result<BenchScene> benchScene(gl::Context& context, gl::ProgramCache& programs, const RequestStream& stream,
                              const std::vector<BenchStrategy>& strategies, const RectMemoryOptions& memory,
                              bool sweeping) {
  const RequestHeader& header = stream.header();
  BenchScene scene;
  scene.scene = header.scene;
  scene.width = static_cast<int>(header.width);
  scene.height = static_cast<int>(header.height);
  scene.fps = header.fps;
  scene.patchInstances = header.patchInstances;
  scene.atlasWidth = memory.width;
  scene.atlasHeight = memory.height;
  std::vector<double> frameMs;
  std::vector<double> memoryMs;
  RequestStream::Reader reader(stream);
  RequestFrame frame;
  for (std::size_t f = 0; f < stream.frames(); ++f) {
    if (auto read = reader.next(frame); !read) return tl::unexpected(read.error());
    scene.visiblePatches += static_cast<double>(frame.patches.size()) / static_cast<double>(stream.frames());
    if (frame.frameMs <= 0.0f) continue;
    frameMs.push_back(static_cast<double>(frame.frameMs));
    memoryMs.push_back(static_cast<double>(frame.memoryMs));
  }
  scene.frameMs = summarize(frameMs);
  scene.memoryMs = summarize(memoryMs);
  {
    Progress progress(header.scene, (strategies.size() + 1) * stream.frames());
    for (const BenchStrategy& strategy : strategies) {
      RectMemoryOptions options = memory;
      options.strategy = strategy.strategy;
      options.merge = strategy.merge;
      auto made = RectMemory::create(programs, options, header.patchInstances);
      if (!made) return tl::unexpected(made.error());
      auto run = runOnGpu(context, std::move(*made), stream, strategy.name, progress);
      if (!run) return tl::unexpected(run.error());
      scene.strategies.push_back(std::move(*run));
    }
    // The same levels and pressure as the strategies have, so the configuration that RectMemory makes of
    // them.
    auto config = RectMemory::create(programs, memory, header.patchInstances);
    if (!config) return tl::unexpected(config.error());
    auto run = runQuadtree(stream, config->readState().config, progress);
    if (!run) return tl::unexpected(run.error());
    scene.quadtree = std::move(*run);
  }
  if (sweeping) {
    auto swept = sweep(context, programs, stream, memory);
    if (!swept) return tl::unexpected(swept.error());
    scene.sweep = std::move(*swept);
  }
  return scene;
}

void print(const std::string& name, const BenchSummary& s) {
  fmt::print("  {:<13} {:>5} {:>7} {:>7} {:>7.1f} {:>8.2f} {:>8.2f} {:>8.2f} {:>7.2f} {:>9.3f} {:>9.3f}\n",
             name, s.oomFrames, s.reduced, s.resets, 100.0 * s.liveShare, 100.0 * s.keptPlace,
             100.0 * s.movedShare, 100.0 * s.movedShareOutsideResets, s.bias, s.ms.median, s.ms.p95);
}

void printSummary(const BenchScene& scene) {
  fmt::print("{} ({} frames of {:.0f} visible patches, atlas {} x {})\n", scene.scene,
             scene.quadtree.frames.size(), scene.visiblePatches, scene.atlasWidth, scene.atlasHeight);
  fmt::print("  {:<13} {:>5} {:>7} {:>7} {:>7} {:>8} {:>8} {:>8} {:>7} {:>9} {:>9}\n", "strategy", "oom",
             "reduced", "resets", "live %", "kept %", "moved %", "no reset", "bias", "ms", "p95");
  for (const BenchRun& run : scene.strategies) print(run.name, summarize(run));
  print(scene.quadtree.name, summarize(scene.quadtree));
  for (const BenchVariant& v : scene.sweep)
    if (v.skipped.empty())
      print(sizesOf(v), v.summary);
    else
      fmt::print("  {:<13} skipped: {}\n", sizesOf(v), v.skipped);
}

/// The file of each scene's requests, none without --record. Fails where one could not be written, or would
/// take the place of another.
Result<std::vector<std::filesystem::path>> recordsOf(const AtlasBenchOptions& options) {
  using std::filesystem::path;
  if (options.record.empty()) return std::vector<path>();
  if (options.scenes.empty())
    return fail("--record {}: without a scene there is nothing to record", options.record);
  const path target(options.record);
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(target, ignored);
  if (options.scenes.size() > 1 && !folder && std::filesystem::exists(target, ignored))
    return fail("--record {}: is a file, {} scenes need a folder", options.record, options.scenes.size());
  std::vector<path> files;
  for (const std::string& scene : options.scenes) {
    path file = target;
    if (folder || options.scenes.size() > 1 || !target.has_filename())
      file /= path(scene).stem().concat(".trs");
    for (std::size_t i = 0; i < files.size(); ++i)
      if (files[i] == file)
        return fail("--record {}: {} and {} would both be saved as {}", options.record, options.scenes[i],
                    scene, file.string());
    for (const std::string& loaded : options.load)
      if (std::filesystem::equivalent(file, loaded, ignored))
        return fail("--record {}: {} is one of the files to --load", options.record, file.string());
    for (const std::string& read : options.scenes)
      if (std::filesystem::equivalent(file, read, ignored))
        return fail("--record {}: {} is one of the scenes", options.record, file.string());
    if (auto writable = checkWritable(file); !writable) return fail("--record {}", writable.error().message);
    files.push_back(std::move(file));
  }
  return files;
}

Result<void> atlasBench(const AtlasBenchOptions& options) {
  if (options.scenes.empty() && options.load.empty())
    return fail("no scene, and no --load of recorded requests");
  if (!options.scenes.empty() && options.camera.frames < 2)
    return fail("--frames {}: the first is not timed, so that it takes 2", options.camera.frames);
  auto size = parseSize(options.size.text);
  if (!size) return tl::unexpected(size.error());
  auto strategies = strategiesOf(options);
  if (!strategies) return tl::unexpected(strategies.error());
  auto setup = engineOptions(options.atlas);
  if (!setup) return tl::unexpected(setup.error());
  const RectMemoryOptions& memory = setup->atlas.memory;
  // A file that cannot be read is known before minutes of recording.
  std::vector<RequestStream> loaded;
  for (const std::string& file : options.load) {
    auto stream = RequestStream::load(file);
    if (!stream) return tl::unexpected(stream.error());
    loaded.push_back(std::move(*stream));
  }
  auto records = recordsOf(options);
  if (!records) return tl::unexpected(records.error());
  auto files = ReportFiles::create(options.output, "atlas_bench");
  if (!files) return tl::unexpected(files.error());
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());
  gl::ProgramCache programs(**context);

  BenchReport report;
  report.context = reportContext((*context)->info(), options.command);
  report.settings = fmt::format(
      "Superblocks of {} texels a side; high-water mark {:.0f} %; target from {:.0f} to {:.0f} % of the "
      "atlas; lowest "
      "bias {}; hysteresis {}.",
      1 << memory.superblockLog2, 100.0f * memory.highWater, 100.0f * memory.targetShare,
      100.0f * memory.targetLargest, memory.biasFloor, memory.hysteresis);
  const auto bench = [&](const RequestStream& stream) -> Result<void> {
    auto scene = benchScene(**context, programs, stream, *strategies, memory, options.sweep);
    if (!scene) return fail("{}: {}", stream.header().scene, scene.error().message);
    printSummary(*scene);
    report.scenes.push_back(std::move(*scene));
    return {};
  };
  for (std::size_t i = 0; i < options.scenes.size(); ++i) {
    auto stream = recordRequests(**context, options.scenes[i], options, *size);
    if (!stream) return tl::unexpected(stream.error());
    if (!records->empty())
      if (auto saved = stream->save((*records)[i]); !saved) return saved;
    if (auto done = bench(*stream); !done) return done;
  }
  for (const RequestStream& stream : loaded)
    if (auto done = bench(stream); !done) return done;
  return files->write(toJson(report), toHtml(report));
}

}  // namespace

Run addAtlasBench(CLI::App& app) {
  auto options = std::make_shared<AtlasBenchOptions>();
  options->camera.pathUnlessChosen = "tour";
  options->camera.frames = 1000;
  options->camera.fps = 0.0;  // unless given: as many as show the whole path
  options->atlas.megapixels = 4.0;
  options->atlas.biasFloor = -2.0;
  CLI::App& command = *app.add_subcommand(
      "atlas-bench",
      "Allocators of the atlas memory over the same requests; writes atlas_bench.json and atlas_bench.html");
  command.add_option("scenes", options->scenes, "glTF 2.0 files, of which the requests are recorded");
  command.add_option("-o,--output", options->output, "folder for the results")->required();
  command.add_option("--record", options->record,
                     "save the requests to this file; into this folder for several scenes");
  command.add_option("--load", options->load,
                     "files of requests that were saved before: nothing is rendered");
  command.add_option("--strategies", options->strategies, "comma-separated: S0, S0-unmerged, S1, S2, S3")
      ->delimiter(',')
      ->capture_default_str();
  command.add_flag("--sweep", options->sweep, "also S0 with other superblocks, block sizes and aspects");
  addContext(command, options->context);
  addSize(command, options->size);
  addCamera(command, options->camera);
  addStage(command, options->stage);
  addAtlas(command, options->atlas);
  // All strategies run, and no texel is drawn that would have a format.
  for (const char* unused : {"--strategy", "--no-merge", "--atlas-format"})
    command.remove_option(command.get_option(unused));
  return [options](const std::string& line) {
    options->command = line;
    return atlasBench(*options);
  };
}

}  // namespace tessera::app
