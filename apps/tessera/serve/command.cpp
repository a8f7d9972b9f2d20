// tessera serve: shades a scene for whoever watches, and streams the atlas as video and the geometry beside
// it.
#include <algorithm>
#include <atomic>
#include <csignal>
#include <memory>
#include <numeric>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/measured_scene.hpp"
#include "apps/tessera/progress.hpp"
#include "apps/tessera/serve/coding.hpp"
#include "apps/tessera/serve/viewers.hpp"
#include "engine/core/file.hpp"
#include "engine/measure/statistics.hpp"
#include "engine/stream/feed.hpp"
#include "engine/yuv/packer.hpp"

namespace tessera::app {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kVertexPixels = 0.1;          // that a vertex may be off
constexpr int kLeastFramesBetweenIFrames = 3;  // whoever asks for them

struct ServeOptions {
  std::string scene;
  std::string listen = "127.0.0.1:7400";
  std::string method = "rect";
  double bitrate = 20e6;
  double fps = 30.0;
  std::string chroma = "420";
  int iFrames = 60;
  std::string encoder;
  std::string token;
  std::string keys;
  int frames = 0;
  std::string stats;
  ContextChoice context;
  StageChoice stage;
  AtlasChoice atlas;
  PredictionChoice prediction;
};

std::atomic<bool> stopAsked = false;

/// Milliseconds of a part of each frame.
struct Times {
  std::vector<double> visible, place, shade, convert, read, meta, encode;
};

class Streaming {
 public:
  Streaming(const ServeOptions& options, Engine& engine, transport::Server& server, PvsOptions pvs,
            YuvPacker packer, VideoEncoder encoder, wire::StreamSetup setup)
      : options_(options),
        engine_(engine),
        server_(server),
        pvs_(pvs),
        packer_(std::move(packer)),
        coding_(std::move(encoder)),
        feed_(engine),
        viewers_(server, feed_.source(), greetingOf(std::move(setup)),
                 [](const std::string& line) { say(line); }) {}

  Result<void> run() {
    const auto interval =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / options_.fps));
    const Clock::time_point start = Clock::now();
    Clock::time_point due = start;
    while (!stopAsked && (options_.frames == 0 || frame_ < static_cast<std::uint32_t>(options_.frames))) {
      viewers_.poll();
      if (auto sent = sendCoded(); !sent) return sent;
      if (Clock::now() < due) {
        std::this_thread::sleep_for(
            std::min<Clock::duration>(due - Clock::now(), std::chrono::milliseconds(1)));
        continue;
      }
      due = std::max(due + interval, Clock::now() - interval);
      report();
      if (viewers_.watching() == 0) continue;
      if (auto drawn = frame(std::chrono::duration<double>(Clock::now() - start).count()); !drawn)
        return drawn;
    }
    return sendCoded();
  }

  [[nodiscard]] nlohmann::json statistics() const {
    const auto median = [](const std::vector<double>& values) {
      return values.empty() ? 0.0 : summarize(values).median;
    };
    const Times& t = times_;
    const double own =
        median(t.visible) + median(t.place) + median(t.convert) + median(t.read) + median(t.meta);
    const double whole = own + median(t.shade) + median(t.encode);
    return {{"frames", frame_},
            {"ms",
             {{"visible", median(t.visible)},
              {"place", median(t.place)},
              {"shade", median(t.shade)},
              {"convert", median(t.convert)},
              {"read", median(t.read)},
              {"meta", median(t.meta)},
              {"encode", median(t.encode)}}},
            {"own_share", whole > 0.0 ? own / whole : 0.0},
            {"video_bytes", videoBytes_},
            {"meta_bytes", metaBytes_},
            {"i_frames", iFrames_}};
  }

 private:
  static void say(const std::string& line) {
    fmt::print("{}\n", line);
    std::fflush(stdout);
  }

  [[nodiscard]] std::vector<wire::Message> greetingOf(wire::StreamSetup setup) const {
    std::vector<wire::Message> greeting;
    greeting.emplace_back(std::move(setup));
    for (wire::MaskImage& mask : masksOf(engine_.scene())) greeting.emplace_back(std::move(mask));
    return greeting;
  }

  /// Runs a part of a frame to its end, and keeps how long it took.
  template <class Part>
  void timed(std::vector<double>& times, const Part& part) {
    const Clock::time_point before = Clock::now();
    part();
    if (!options_.stats.empty()) gl::api().Finish();
    times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - before).count());
  }

  /// Where each viewer will look until the frame after this one has come to it.
  std::vector<TimedView> predict(double time) {
    std::vector<TimedView> all;
    ends_.clear();
    for (auto& [id, viewer] : viewers_.all()) {
      if (!viewer.watches()) continue;
      const auto predicted = predictedViews(viewer.track, {}, pvs_);
      const auto wide = widened(predicted, pvs_.margin);
      if (!wide) continue;  // a field of view of nearly half the world: its poses are not followed
      for (TimedView view : *wide) {
        view.time += time - predicted.front().time;
        all.push_back(view);
      }
      for (const View& end : {predicted.front().view, predicted.back().view})
        if (ends_.size() < Engine::kMaxViews) ends_.push_back(end);
    }
    return all;
  }

  void holdReset(bool held) {
    if (RectAtlas* atlas = engine_.atlas(); atlas != nullptr) atlas->memory().holdReset(held);
    if (TessAtlas* tess = engine_.tess(); tess != nullptr) tess->memory().holdReset(held);
  }

  Result<void> frame(double time) {
    engine_.update(time);
    const std::vector<TimedView> views = predict(time);
    if (views.empty()) return {};
    ++frame_;
    const bool wished = wish_ || viewers_.takeIFrameWish();
    const bool regular = options_.iFrames > 0 && sinceIFrame_ + 1 >= options_.iFrames;
    const bool iFrame = frame_ == 1 || regular || (wished && sinceIFrame_ + 1 >= kLeastFramesBetweenIFrames);
    wish_ = wished && !iFrame;
    sinceIFrame_ = iFrame ? 0 : sinceIFrame_ + 1;
    iFrames_ += iFrame ? 1 : 0;
    // All blocks move in a reset: only a frame that builds on none shows that at no cost.
    holdReset(!iFrame);
    timed(times_.visible, [&] { engine_.findVisible(views); });
    Result<void> placed;
    timed(times_.place, [&] { placed = engine_.place(ends_); });
    if (!placed) return placed;
    const gl::Texture& atlas = engine_.gatherer()->atlas().encoded;
    timed(times_.shade, [&] {
      // What is free is black where it costs bits: in frames that build on none.
      if (iFrame) gl::api().ClearTexImage(atlas.get(), 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
      engine_.shade(ends_.back(), shadeOptions(options_.atlas));
    });
    std::optional<YuvPacker::Read> planes;
    Result<void> packed;
    timed(times_.convert, [&] {
      packed = packer_.pack(atlas, frame_);
      if (packed) planes = packer_.read();
    });
    if (!packed) return packed;
    std::vector<wire::VisibleElement> elements;
    std::vector<wire::ObjectTransform> objects;
    timed(times_.read, [&] {
      elements = feed_.visible(engine_);
      objects = feed_.objects(engine_);
    });
    timed(times_.meta, [&] { tellFrame(time, iFrame, elements, objects); });
    coding_.push(std::move(planes->planes), frame_, iFrame);
    return {};
  }

  void tellFrame(double time, bool iFrame, const std::vector<wire::VisibleElement>& elements,
                 const std::vector<wire::ObjectTransform>& objects) {
    std::vector<transport::ViewerId> ids;
    for (const auto& [id, viewer] : viewers_.all())
      if (viewer.watches()) ids.push_back(id);
    for (const transport::ViewerId id : ids) {
      Viewer& viewer = viewers_.all().at(id);
      wire::FrameHeader header;
      header.frame = frame_;
      header.iFrame = iFrame;
      header.time = time;
      // Tessellated samples are even in the picture of the first view that was placed.
      header.camera = cameraOf(ends_.front());
      const View own = viewer.track.last()->view;
      const std::optional<View> later = viewer.track.at(viewer.track.last()->time + pvs_.latency);
      const double reach = (later ? glm::length(later->eye - own.eye) : 0.0) + 4.0 * own.zNear;
      wire::Geometry geometry;
      geometry.frame = frame_;
      geometry.changes = viewer.delta->next(
          {elements, objects, {}, wire::boundOf(viewer.camera, kVertexPixels, reach), own.eye});
      const std::size_t bytes = viewers_.tell(id, header);
      if (bytes != 0) metaBytes_ += bytes + viewers_.tell(id, geometry);
    }
  }

  Result<void> sendCoded() {
    for (Result<EncodedFrame>& coded : coding_.take()) {
      if (!coded) {
        // The next frame is an I-frame; the one that was lost is asked for by nobody.
        say(fmt::format("a frame was not coded: {}", coded.error().message));
        wish_ = true;
        continue;
      }
      times_.encode.push_back(coded->milliseconds);
      videoBytes_ += coded->bytes.size();
      const auto number = static_cast<std::uint32_t>(coded->frame);
      const auto shared = std::make_shared<const transport::Bytes>(std::move(coded->bytes));
      for (const auto& [id, viewer] : viewers_.all()) {
        if (!viewer.videoOpen) continue;
        // Who is gone is an event of the next poll.
        if (auto sent = server_.sendVideo(id, number, shared); !sent) continue;
      }
    }
    return {};
  }

  /// A line a second while somebody watches.
  void report() {
    const Clock::time_point now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - reported_).count();
    if (seconds < 1.0) return;
    if (frame_ != reportedFrame_)
      say(fmt::format("{} watching, {:.1f} frames/s, video {:.2f} Mbit/s, meta {:.2f} Mbit/s",
                      viewers_.watching(), (frame_ - reportedFrame_) / seconds,
                      static_cast<double>(videoBytes_ - reportedVideo_) * 8e-6 / seconds,
                      static_cast<double>(metaBytes_ - reportedMeta_) * 8e-6 / seconds));
    reported_ = now;
    reportedFrame_ = frame_;
    reportedVideo_ = videoBytes_;
    reportedMeta_ = metaBytes_;
  }

  const ServeOptions& options_;
  Engine& engine_;
  transport::Server& server_;
  PvsOptions pvs_;
  YuvPacker packer_;
  CodingThread coding_;
  GeometryFeed feed_;
  Viewers viewers_;
  std::vector<View> ends_;  // of each viewer's predicted views the first and the last
  std::uint32_t frame_ = 0;
  int sinceIFrame_ = 0;
  bool wish_ = false;
  std::uint64_t videoBytes_ = 0, metaBytes_ = 0, iFrames_ = 0;
  Times times_;
  Clock::time_point reported_ = Clock::now();
  std::uint32_t reportedFrame_ = 0;
  std::uint64_t reportedVideo_ = 0, reportedMeta_ = 0;
};

Result<void> serve(const ServeOptions& options) {
  const auto address = transport::parseAddress(options.listen);
  if (!address) return fail("--listen {}", address.error().message);
  if (!options.token.empty() && options.keys.empty())
    return fail("--token needs --keys: the folder of this side's certificate and pairings");
  auto pvs = pvsOptionsOf(options.prediction);
  if (!pvs) return tl::unexpected(pvs.error());
  if (*pvs && (*pvs)->prediction == Prediction::Reference)
    return fail("--prediction reference: nobody knows a viewer's path beforehand");
  AtlasChoice atlasChoice = options.atlas;
  atlasChoice.sampling = options.method == "tess" ? Sampling::Tess : Sampling::Rect;
  auto setup = engineOptions(atlasChoice);
  if (!setup) return tl::unexpected(setup.error());
  auto stage = loadStageFor(options.stage, options.scene);
  if (!stage) return tl::unexpected(stage.error());
  auto loading = std::make_unique<Progress>("serve");
  const auto step = [&](const std::string& text) { loading->step(text); };
  auto scene = loadGltf(options.scene, {.loadImages = true, .progress = step});
  if (!scene) return tl::unexpected(scene.error());
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());
  setup->request = {.rect = true, .displayGeometry = true, .displayDeferred = false, .forward = false};
  setup->progress = step;
  auto engine = Engine::create(**context, std::move(*scene), std::move(*stage), *setup);
  if (!engine) return tl::unexpected(engine.error());
  (*engine)->update(0.0);
  loading.reset();

  const gl::Texture& atlas = (*engine)->gatherer()->atlas().encoded;
  if (!atlas) return fail("--format {}: video takes display-encoded values", options.atlas.format);
  const Chroma chroma = options.chroma == "444" ? Chroma::Yuv444 : Chroma::Yuv420;
  auto packer = YuvPacker::create(**context, atlas.width(), atlas.height(), chroma);
  if (!packer) return tl::unexpected(packer.error());
  EncoderOptions coding;
  coding.width = atlas.width();
  coding.height = atlas.height();
  coding.chroma = chroma;
  coding.framesPerSecond = options.fps;
  coding.bitrate = static_cast<std::int64_t>(options.bitrate);
  coding.iFrameInterval = 0;  // each is asked for, since messages name them
  if (!options.encoder.empty()) coding.encoders = {options.encoder};
  auto encoder = VideoEncoder::create(coding);
  if (!encoder) return tl::unexpected(encoder.error());

  wire::StreamSetup stream;
  stream.method = options.method == "tess" ? wire::Method::Tess : wire::Method::Rect;
  stream.chroma = chroma == Chroma::Yuv444 ? wire::Chroma::C444 : wire::Chroma::C420;
  stream.fullRange = true;
  stream.width = static_cast<std::uint32_t>(atlas.width());
  stream.height = static_cast<std::uint32_t>(atlas.height());
  stream.fpsNumerator = static_cast<std::uint32_t>(std::lround(options.fps * 1000.0));
  stream.fpsDenominator = 1000;
  transport::ServerOptions listening;
  listening.listen = *address;
  listening.token = options.token;
  listening.folder = options.keys;
  listening.frameInterval = std::chrono::duration_cast<transport::Clock::duration>(
      std::chrono::duration<double>(1.0 / options.fps));
  listening.log = [](const std::string& line) { fmt::print(stderr, "{}\n", line); };
  auto server = transport::Server::start(listening);
  if (!server) return tl::unexpected(server.error());
  fmt::print("listening on {}, atlas {} x {}, {} by {}\n", transport::describe((*server)->address()),
             atlas.width(), atlas.height(), nameOf(chroma), encoder->name());
  if (!(*server)->fingerprint().empty()) fmt::print("certificate {}\n", (*server)->fingerprint());
  std::fflush(stdout);
  std::signal(SIGINT, [](int) { stopAsked = true; });
  std::signal(SIGTERM, [](int) { stopAsked = true; });

  Streaming streaming(options, **engine, **server, pvs->value_or(PvsOptions{.prediction = Prediction::None}),
                      std::move(*packer), std::move(*encoder), std::move(stream));
  if (auto ran = streaming.run(); !ran) return ran;
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
  command.add_option("--bitrate", options->bitrate, "of the video, bits a second; 20M, 800k")
      ->transform(CLI::AsNumberWithUnit(std::map<std::string, double>{{"k", 1e3}, {"M", 1e6}, {"G", 1e9}},
                                        CLI::AsNumberWithUnit::CASE_SENSITIVE))
      ->check(CLI::Range(1e4, 2e9));
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
  command.add_option("--token", options->token,
                     "that a viewer must give too; needed for all but loopback addresses");
  command.add_option("--keys", options->keys, "folder of the certificate and of who was paired");
  command.add_option("--frames", options->frames, "ends after so many; 0: goes on")
      ->check(CLI::Range(0, 1000000000));
  command.add_option("--stats", options->stats,
                     "JSON file for times by stage and bytes; each stage then ends before the next");
  addContext(command, options->context);
  addStage(command, options->stage);
  addAtlas(command, options->atlas);
  addPrediction(command, options->prediction);
  return [=](const std::string&) { return serve(*options); };
}

}  // namespace tessera::app
