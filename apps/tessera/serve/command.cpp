// tessera serve: shades a scene for whoever watches, and streams the atlas as video and the geometry beside
// it.
#include <atomic>
#include <cmath>
#include <csignal>
#include <memory>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/measured_scene.hpp"
#include "apps/tessera/progress.hpp"
#include "apps/tessera/report_output.hpp"
#include "apps/tessera/serve/streaming.hpp"
#include "engine/core/file.hpp"

namespace tessera::app {

namespace {

struct ServeOptions {
  std::string scene;
  std::string listen = "127.0.0.1:7400";
  std::string method = "rect";
  double bitrate = 20e6;
  std::optional<double> quality;
  double fps = 30.0;
  std::string chroma = "420";
  int iFrames = 60;
  std::string encoder;
  bool regions = true;
  std::string token;
  std::string keys;
  int frames = 0;
  std::string stats;
  std::string csv;
  ContextChoice context;
  StageChoice stage;
  AtlasChoice atlas;
  PredictionChoice prediction;
  const CLI::Option* latency = nullptr;  // whether it was given
};

std::atomic<bool> stopAsked = false;

transport::ServerOptions listeningOf(const ServeOptions& options, const transport::Address& address) {
  transport::ServerOptions listening;
  listening.listen = address;
  listening.token = options.token;
  listening.folder = options.keys;
  listening.frameInterval = std::chrono::duration_cast<transport::Clock::duration>(
      std::chrono::duration<double>(1.0 / options.fps));
  listening.log = [](const std::string& line) { fmt::print(stderr, "{}\n", line); };
  return listening;
}

EncoderOptions codingOf(const ServeOptions& options, int width, int height) {
  EncoderOptions coding;
  coding.width = width;
  coding.height = height;
  coding.chroma = options.chroma == "444" ? Chroma::Yuv444 : Chroma::Yuv420;
  coding.framesPerSecond = options.fps;
  coding.bitrate = static_cast<std::int64_t>(options.bitrate);
  if (options.quality) {
    coding.rate = RateControl::ConstantQuality;
    coding.quality = *options.quality;
  }
  coding.iFrameInterval = 0;  // each is asked for, since messages name them
  if (!options.encoder.empty()) coding.encoders = {options.encoder};
  return coding;
}

/// Where `tessera render` would look from.
Result<wire::Camera> startOf(const Scene& scene, const Stage* stage) {
  const auto views = viewsOf(CameraChoice(), scene, stage, {1280, 720});
  if (!views) return tl::unexpected(views.error());
  return cameraOf(views->front().view);
}

/// What a new viewer is told: of a scene whose images are still there.
Result<std::vector<wire::Message>> greetingOf(const Scene& scene, const Stage* stage) {
  wire::StreamSetup setup;
  const auto start = startOf(scene, stage);
  if (!start) return tl::unexpected(start.error());
  setup.start = *start;
  std::vector<wire::Path> paths;
  if (stage != nullptr) paths = pathsOf(*stage);
  setup.paths = static_cast<std::uint16_t>(paths.size());
  std::vector<wire::Message> greeting = {std::move(setup)};
  for (wire::Path& path : paths) greeting.emplace_back(std::move(path));
  for (wire::MaskImage& mask : masksOf(scene)) greeting.emplace_back(std::move(mask));
  return greeting;
}

Result<void> serve(const ServeOptions& options) {
  // What needs no scene comes before it: scenes take long to load.
  const auto address = transport::parseAddress(options.listen);
  if (!address) return fail("--listen {}", address.error().message);
  if (!options.token.empty() && options.keys.empty())
    return fail("--token needs --keys: the folder of this side's certificate and pairings");
  if (!options.stats.empty())
    if (auto writable = checkWritable(options.stats); !writable)
      return fail("--stats {}", writable.error().message);
  if (!options.csv.empty())
    if (auto writable = checkWritable(options.csv); !writable)
      return fail("--csv {}", writable.error().message);
  auto pvs = pvsOptionsOf(options.prediction);
  if (!pvs) return tl::unexpected(pvs.error());
  if (*pvs && (*pvs)->prediction == Prediction::Reference)
    return fail("--prediction reference: nobody knows a viewer's path beforehand");
  AtlasChoice atlasChoice = options.atlas;
  atlasChoice.sampling = options.method == "tess" ? Sampling::Tess : Sampling::Rect;
  auto setup = engineOptions(atlasChoice);
  if (!setup) return tl::unexpected(setup.error());
  if (setup->atlas.format != AtlasFormat::Srgb8)
    return fail("--atlas-format {}: video takes display-encoded values", options.atlas.format);
  const transport::ServerOptions listening = listeningOf(options, *address);
  if (auto checked = transport::Server::check(listening); !checked)
    return fail("--listen {}", checked.error().message);
  if (auto encoder = VideoEncoder::create(codingOf(options, 256, 256)); !encoder)
    return tl::unexpected(encoder.error());
  auto stage = loadStageFor(options.stage, options.scene);
  if (!stage) return tl::unexpected(stage.error());
  auto loading = std::make_unique<Progress>("serve");
  const auto step = [&](const std::string& text) { loading->step(text); };
  auto scene = loadGltf(options.scene, {.loadImages = true, .progress = step});
  if (!scene) return tl::unexpected(scene.error());
  // Before the engine takes the scene: it keeps no pixels of it.
  auto greeting = greetingOf(*scene, *stage ? &**stage : nullptr);
  if (!greeting) return tl::unexpected(greeting.error());
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());
  setup->request = {
      .rect = true, .displayGeometry = true, .displayDeferred = false, .forward = false, .blended = true};
  setup->visiblePixels = options.regions;
  setup->progress = step;
  auto engine = Engine::create(**context, std::move(*scene), std::move(*stage), *setup);
  if (!engine) return tl::unexpected(engine.error());
  (*engine)->update(0.0);
  loading.reset();

  const gl::Texture& atlas = (*engine)->gatherer()->atlas().encoded;
  const EncoderOptions coding = codingOf(options, atlas.width(), atlas.height());
  auto packer = YuvPacker::create(**context, atlas.width(), atlas.height(), coding.chroma);
  if (!packer) return tl::unexpected(packer.error());
  auto encoder = VideoEncoder::create(coding);
  if (!encoder) return tl::unexpected(encoder.error());

  auto& stream = std::get<wire::StreamSetup>(greeting->front());
  stream.method = options.method == "tess" ? wire::Method::Tess : wire::Method::Rect;
  stream.chroma = coding.chroma == Chroma::Yuv444 ? wire::Chroma::C444 : wire::Chroma::C420;
  stream.fullRange = true;
  stream.width = static_cast<std::uint32_t>(atlas.width());
  stream.height = static_cast<std::uint32_t>(atlas.height());
  stream.fpsNumerator = static_cast<std::uint32_t>(std::lround(options.fps * 1000.0));
  stream.fpsDenominator = 1000;
  auto server = transport::Server::start(listening);
  if (!server) return fail("--listen {}", server.error().message);
  fmt::print("listening on {}, atlas {} x {}, {} by {}\n", transport::describe((*server)->address()),
             atlas.width(), atlas.height(), nameOf(coding.chroma), encoder->name());
  if (!(*server)->fingerprint().empty()) fmt::print("certificate {}\n", (*server)->fingerprint());
  std::fflush(stdout);
  std::signal(SIGINT, [](int) { stopAsked = true; });
  std::signal(SIGTERM, [](int) { stopAsked = true; });

  StreamingOptions streamed;
  streamed.framesPerSecond = options.fps;
  streamed.iFrames = options.iFrames;
  streamed.frames = static_cast<std::uint32_t>(options.frames);
  streamed.pvs = pvs->value_or(PvsOptions{.prediction = Prediction::None});
  streamed.measureLatency = options.latency->count() == 0;
  streamed.shade = shadeOptions(options.atlas);
  streamed.timeStages = !options.stats.empty() || !options.csv.empty();
  streamed.csv = options.csv;
  Streaming streaming(streamed, **engine, **server, std::move(*packer), std::move(*encoder),
                      std::move(*greeting));
  if (auto ran = streaming.run(stopAsked); !ran) return ran;
  if (options.stats.empty()) return {};
  return writeFile(options.stats, streaming.statistics().dump(2) + "\n");
}

}  // namespace

Run addServe(CLI::App& app) {
  auto options = std::make_shared<ServeOptions>();
  options->atlas.megapixels = 4.0;
  options->prediction.mode = "linear";
  CLI::App& command = *app.add_subcommand("serve", "Shade a scene for viewers and stream it to them");
  command.add_option("scene", options->scene, "glTF 2.0 file")->required();
  command.add_option("--listen", options->listen, "HOST:PORT; port 0: any that is free, which is printed")
      ->capture_default_str();
  command.add_option("--method", options->method, "what fills the atlas")
      ->check(CLI::IsMember({"rect", "tess"}))
      ->capture_default_str();
  auto* bitrate =
      command.add_option("--bitrate", options->bitrate, "of the video, bits a second; 20M, 800k")
          ->transform(CLI::AsNumberWithUnit(std::map<std::string, double>{{"k", 1e3}, {"M", 1e6}, {"G", 1e9}},
                                            CLI::AsNumberWithUnit::CASE_SENSITIVE))
          ->check(CLI::Range(1e4, 2e9));
  command
      .add_option("--quality", options->quality,
                  "constant instead of a bitrate: CRF of libx264, quantizer of others; less is better")
      ->check(CLI::Range(0.0, 51.0))
      ->excludes(bitrate);
  command.add_option("--fps", options->fps, "frames a second that are shaded")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command.add_option("--chroma", options->chroma, "how finely colours are sent")
      ->check(CLI::IsMember({"420", "444"}))
      ->capture_default_str();
  command
      .add_option("--i-frames", options->iFrames,
                  "from one I-frame to the next; 0: only when one is asked for")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command.add_option("--encoder", options->encoder,
                     "libavcodec's name of one; else the first of several that opens");
  command.add_flag("--no-regions{false}", options->regions,
                   "spend bits alike on all of the atlas, not more where more pixels show it");
  command.add_option("--token", options->token,
                     "that a viewer must give too; needed for all but loopback addresses");
  command.add_option("--keys", options->keys, "folder of the certificate and of who was paired");
  command.add_option("--frames", options->frames, "ends after so many; 0: goes on")
      ->check(CLI::Range(0, 1000000000));
  command.add_option("--stats", options->stats,
                     "JSON file for times by stage and bytes; each stage then ends before the next");
  command.add_option("--csv", options->csv, "CSV file for a row a coded frame, with bytes and times");
  addContext(command, options->context);
  addStage(command, options->stage);
  addAtlas(command, options->atlas);
  addPrediction(command, options->prediction);
  options->latency = command.get_option("--latency-ms")
                         ->description(
                             "how far ahead is predicted; without it, each viewer's round trip and a "
                             "frame's time");
  return [=](const std::string&) { return serve(*options); };
}

}  // namespace tessera::app
