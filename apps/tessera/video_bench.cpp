// tessera video-bench: what video coding does to real atlases, and to what is drawn from them.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/context_json.hpp"
#include "apps/tessera/measured_scene.hpp"
#include "apps/tessera/progress.hpp"
#include "codec/video.hpp"
#include "engine/core/file.hpp"
#include "engine/measure/metrics.hpp"
#include "engine/measure/statistics.hpp"
#include "engine/stream/feed.hpp"
#include "engine/stream/regions.hpp"
#include "engine/yuv/packer.hpp"
#include "engine/yuv/unpacker.hpp"

namespace tessera::app {

namespace {

struct VideoBenchOptions {
  std::string scene;
  std::string output;
  std::vector<double> megabits = {5, 10, 20, 40, 80};
  std::optional<double> quality;  // instead of bitrates
  std::vector<std::string> chroma = {"420", "444"};
  std::vector<std::string> encoders;
  std::string preset;
  int interval = 5;
  int threads = 2;
  bool regions = false;
  bool clear = false;
  std::string command;
  ContextChoice context;
  SizeChoice size;
  CameraChoice camera;
  StageChoice stage;
  AtlasChoice atlas;
};

/// One way to code the same frames, with what came of it.
struct Coding {
  Chroma chroma;
  double megabits;
  bool regions;
  VideoEncoder encoder;
  VideoDecoder decoder;
  std::vector<double> bytes, iBytes, encodeMs, decodeMs, atlasPsnr, psnr, mssim;
};

Result<std::vector<Coding>> makeCodings(const VideoBenchOptions& options, const gl::Texture& atlas) {
  std::vector<Coding> codings;
  for (const std::string& name : options.chroma)
    for (const double megabits : options.quality ? std::vector<double>{0.0} : options.megabits)
      for (const bool regions : {false, true}) {
        if (regions && !options.regions) continue;
        EncoderOptions wanted;
        wanted.width = atlas.width();
        wanted.height = atlas.height();
        wanted.chroma = name == "420" ? Chroma::Yuv420 : Chroma::Yuv444;
        wanted.framesPerSecond = options.camera.fps;
        wanted.bitrate = static_cast<std::int64_t>(megabits * 1e6);
        if (options.quality) {
          wanted.rate = RateControl::ConstantQuality;
          wanted.quality = *options.quality;
        }
        wanted.iFrameInterval = options.interval;
        wanted.threads = options.threads;
        wanted.encoders = options.encoders;
        wanted.preset = options.preset;
        auto encoder = VideoEncoder::create(wanted);
        if (!encoder) return tl::unexpected(encoder.error());
        auto decoder = VideoDecoder::create({.threads = options.threads});
        if (!decoder) return tl::unexpected(decoder.error());
        codings.push_back({wanted.chroma,
                           megabits,
                           regions,
                           std::move(*encoder),
                           std::move(*decoder),
                           {},
                           {},
                           {},
                           {},
                           {},
                           {},
                           {}});
      }
  return codings;
}

void copyTexture(const gl::Texture& from, const gl::Texture& to) {
  gl::api().CopyImageSubData(from.get(), GL_TEXTURE_2D, 0, 0, 0, 0, to.get(), GL_TEXTURE_2D, 0, 0, 0, 0,
                             to.width(), to.height(), 1);
}

Image imageOf(const gl::Texture& texture) {
  return {texture.width(), texture.height(), gl::readTexture(texture, GL_RGBA, GL_UNSIGNED_BYTE, 4)};
}

/// What it takes to code the frames of one engine.
struct Bench {
  Engine& engine;
  const gl::Texture& atlas;  // encoded values
  gl::Texture kept;
  YuvUnpacker unpacker;
  std::vector<Coding> codings;
  GeometryFeed feed;
  std::optional<YuvPacker> packers[2];  // 4:2:0, 4:4:4

  Result<void> frame(const TimedView& timed, std::uint32_t number);
  Result<void> code(Coding& coding, const YuvView& planes, std::uint32_t number,
                    std::span<const Region> regions, const View& view, const Image& shaded,
                    const Image& picture);
};

Result<void> Bench::code(Coding& coding, const YuvView& planes, std::uint32_t number,
                         std::span<const Region> regions, const View& view, const Image& shaded,
                         const Image& picture) {
  auto sent = coding.encoder.encode(planes, number, {.iFrame = false, .regions = regions});
  if (!sent) return tl::unexpected(sent.error());
  const Decoded decoded = coding.decoder.decode(sent->bytes);
  if (!decoded.picture) return fail("{}: {}", nameOf(decoded.reason), decoded.detail);
  if (auto done = unpacker.unpack(*decoded.picture); !done) return done;
  copyTexture(unpacker.encoded(), atlas);
  engine.display(view);
  const Image drawn = engine.readColor();
  const auto atlasPsnr = psnr(shaded, imageOf(unpacker.encoded()));
  const auto drawnPsnr = psnr(picture, drawn);
  const auto drawnMssim = mssim(picture, drawn);
  if (!atlasPsnr) return tl::unexpected(atlasPsnr.error());
  if (!drawnPsnr) return tl::unexpected(drawnPsnr.error());
  if (!drawnMssim) return tl::unexpected(drawnMssim.error());
  coding.bytes.push_back(static_cast<double>(sent->bytes.size()));
  if (sent->iFrame()) coding.iBytes.push_back(static_cast<double>(sent->bytes.size()));
  coding.encodeMs.push_back(sent->milliseconds);
  coding.decodeMs.push_back(decoded.milliseconds);
  coding.atlasPsnr.push_back(*atlasPsnr);
  coding.psnr.push_back(*drawnPsnr);
  coding.mssim.push_back(drawnMssim->mean);
  return {};
}

Result<void> Bench::frame(const TimedView& timed, std::uint32_t number) {
  engine.display(timed.view);
  const Image picture = engine.readColor();
  const Image shaded = imageOf(atlas);
  copyTexture(atlas, kept);
  std::optional<YuvPacker::Read> packed[2];
  for (std::size_t i = 0; i < 2; ++i)
    if (packers[i]) {
      if (auto done = packers[i]->pack(atlas, number); !done) return done;
      packed[i] = packers[i]->read();
    }
  const bool any = std::any_of(codings.begin(), codings.end(), [](const Coding& one) { return one.regions; });
  const std::vector<Region> regions =
      any ? regionsOf(shownBlocks(engine, feed.visible(engine)), atlas.width(), atlas.height())
          : std::vector<Region>{};
  for (Coding& coding : codings) {
    const auto& planes = packed[coding.chroma == Chroma::Yuv420 ? 0 : 1];
    if (auto done = code(coding, planes->planes.view(), number,
                         coding.regions ? std::span<const Region>(regions) : std::span<const Region>(),
                         timed.view, shaded, picture);
        !done)
      return done;
  }
  copyTexture(kept, atlas);
  return {};
}

double meanOf(const std::vector<double>& values) { return summarize(values).mean; }

nlohmann::json jsonOf(const Coding& coding, double fps) {
  const auto spread = [](const std::vector<double>& values) {
    const Statistics s = summarize(values);
    return nlohmann::json{{"median", s.median}, {"min", s.min}, {"max", s.max}, {"interquartile", s.spread}};
  };
  return {{"chroma", nameOf(coding.chroma)},
          {"megabits_asked", coding.megabits},  // 0: at constant quality
          {"regions", coding.regions},
          {"encoder", coding.encoder.name()},
          {"megabits", meanOf(coding.bytes) * 8e-6 * fps},
          {"i_frame_bytes", meanOf(coding.iBytes)},
          {"frame_bytes", coding.bytes},
          {"encode_ms", spread(coding.encodeMs)},
          {"decode_ms", spread(coding.decodeMs)},
          {"atlas_psnr_db", meanOf(coding.atlasPsnr)},
          {"picture_psnr_db", meanOf(coding.psnr)},
          {"picture_mssim", meanOf(coding.mssim)}};
}

void print(const Coding& coding, double fps) {
  fmt::print(
      "{} {:5.1f} Mbit/s{}: {:6.2f} sent, I {:7.0f} bytes; atlas {:5.2f} dB; picture {:5.2f} dB, MSSIM "
      "{:.4f}; "
      "encode {:5.1f} ms, decode {:5.1f} ms\n",
      nameOf(coding.chroma), coding.megabits, coding.regions ? ", regions" : "",
      meanOf(coding.bytes) * 8e-6 * fps, meanOf(coding.iBytes), meanOf(coding.atlasPsnr), meanOf(coding.psnr),
      meanOf(coding.mssim), summarize(coding.encodeMs).median, summarize(coding.decodeMs).median);
}

Result<void> bench(const VideoBenchOptions& options) {
  auto size = parseSize(options.size.text);
  if (!size) return tl::unexpected(size.error());
  auto setup = engineOptions(options.atlas);
  if (!setup) return tl::unexpected(setup.error());
  auto loading = std::make_unique<Progress>("video-bench");
  const auto step = [&](const std::string& text) { loading->step(text); };
  auto measured = loadMeasured(options.scene, options.stage, options.camera, *size, step);
  if (!measured) return tl::unexpected(measured.error());
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());
  setup->request.forward = false;
  setup->visiblePixels = options.regions;
  setup->progress = step;
  auto made = Engine::create(**context, std::move(measured->scene), std::move(measured->stage), *setup);
  if (!made) return tl::unexpected(made.error());
  Engine& engine = **made;
  loading.reset();

  const gl::Texture& atlas = engine.gatherer()->atlas().encoded;
  if (!atlas) return fail("--atlas-format {}: video takes display-encoded values", options.atlas.format);
  auto unpacker = YuvUnpacker::create(**context);
  if (!unpacker) return tl::unexpected(unpacker.error());
  auto codings = makeCodings(options, atlas);
  if (!codings) return tl::unexpected(codings.error());
  engine.update(measured->views.front().time);
  Bench state{engine,
              atlas,
              gl::Texture(GL_RGBA8, atlas.width(), atlas.height()),
              std::move(*unpacker),
              std::move(*codings),
              GeometryFeed(engine),
              {}};
  for (const Coding& coding : state.codings) {
    auto& packer = state.packers[coding.chroma == Chroma::Yuv420 ? 0 : 1];
    if (packer) continue;
    auto one = YuvPacker::create(**context, atlas.width(), atlas.height(), coding.chroma);
    if (!one) return tl::unexpected(one.error());
    packer.emplace(std::move(*one));
  }

  Progress progress("frames", measured->views.size());
  for (std::size_t i = 0; i < measured->views.size(); ++i) {
    const TimedView& timed = measured->views[i];
    engine.update(timed.time);
    engine.findVisible({&timed.view, 1});
    if (auto placed = engine.place({&timed.view, 1}); !placed) return placed;
    // Every block that is held is shaded anew: what is free stays cleared.
    if (options.clear && i % static_cast<std::size_t>(options.interval) == 0)
      gl::api().ClearTexImage(atlas.get(), 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    engine.shade(timed.view, shadeOptions(options.atlas));
    if (auto done = state.frame(timed, static_cast<std::uint32_t>(i)); !done) return done;
    progress.step();
  }
  nlohmann::json results = nlohmann::json::array();
  for (const Coding& coding : state.codings) {
    print(coding, options.camera.fps);
    results.push_back(jsonOf(coding, options.camera.fps));
  }
  if (options.output.empty()) return {};
  const nlohmann::json json = {{"schema", 1},
                               {"command", options.command},
                               {"context", contextJson((*context)->info(), engine.timerMode())},
                               {"scene", options.scene},
                               {"size", {size->x, size->y}},
                               {"atlas", {atlas.width(), atlas.height()}},
                               {"frames", measured->views.size()},
                               {"fps", options.camera.fps},
                               {"i_frame_interval", options.interval},
                               {"cleared", options.clear},
                               {"threads", options.threads},
                               {"codings", results}};
  return writeFile(options.output, json.dump(2) + "\n");
}

}  // namespace

Run addVideoBench(CLI::App& app) {
  auto options = std::make_shared<VideoBenchOptions>();
  options->atlas.megapixels = 4.0;
  options->camera.frames = 15;
  options->camera.pathUnlessChosen = "tour";
  CLI::App& command =
      *app.add_subcommand("video-bench", "Code a scene's atlases as video, and look at what is left");
  command.add_option("scene", options->scene, "glTF 2.0 file, .gltf or .glb")->required();
  command.add_option("-o,--output", options->output, "JSON file for all figures");
  command.add_option("--megabits", options->megabits, "bitrates, Mbit/s")
      ->delimiter(',')
      ->check(CLI::Range(0.01, 2000.0))
      ->capture_default_str();
  command.add_option("--quality", options->quality, "constant quality, less is better, instead of bitrates")
      ->check(CLI::Range(0.0, 51.0));
  command.add_option("--chroma", options->chroma, "420, 444 or both")
      ->delimiter(',')
      ->check(CLI::IsMember({"420", "444"}))
      ->capture_default_str();
  command
      .add_option("--encoder", options->encoders, "libavcodec's names, in the order in which they are tried")
      ->delimiter(',');
  command.add_option("--preset", options->preset, "the encoder's own name of a trade of time for bits");
  command.add_option("--interval", options->interval, "frames from one I-frame to the next")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_option("--threads", options->threads, "of the encoder and of the decoder")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command.add_flag("--regions", options->regions,
                   "each bitrate also with regions of interest: macroblocks by the pixels that they fill");
  command.add_flag("--clear", options->clear, "clear what no block holds at I-frames");
  addContext(command, options->context);
  addSize(command, options->size);
  addCamera(command, options->camera);
  addStage(command, options->stage);
  addAtlas(command, options->atlas);
  return [options](const std::string& line) -> Result<void> {
    options->command = line;
    return bench(*options);
  };
}

}  // namespace tessera::app
