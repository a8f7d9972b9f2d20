#include "apps/tessera/serve/streaming.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <thread>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "apps/tessera/serve/shading.hpp"
#include "engine/measure/statistics.hpp"
#include "engine/stream/regions.hpp"

namespace tessera::app {

namespace {

constexpr int kLeastFramesBetweenIFrames = 3;  // whoever asks for them

void say(const std::string& line) {
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

double megabits(std::uint64_t bytes, double seconds) {
  return seconds > 0.0 ? static_cast<double>(bytes) * 8e-6 / seconds : 0.0;
}

}  // namespace

Streaming::Streaming(const StreamingOptions& options, Engine& engine, transport::Server& server,
                     YuvPacker packer, VideoEncoder encoder, std::vector<wire::Message> greeting)
    : options_(options),
      engine_(engine),
      server_(server),
      packer_(std::move(packer)),
      coding_(std::move(encoder)),
      feed_(engine),
      viewers_(server, feed_.source(), std::move(greeting), say) {}

Result<void> Streaming::run(const std::atomic<bool>& stop) {
  const auto interval = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(1.0 / options_.framesPerSecond));
  const Clock::time_point start = Clock::now();
  Clock::time_point due = start;
  Clock::time_point looked = start;
  if (!options_.csv.empty()) {
    csv_.open(options_.csv);
    csv_ << "frame,i_frame,builds_on,video_bytes,encode_ms,viewers,meta_bytes,visible_ms,place_ms,shade_ms,"
            "convert_ms,read_ms,meta_ms\n";
    if (!csv_) return fail("--csv {}: cannot be written", options_.csv);
  }
  while (!stop && (options_.frames == 0 || frame_ < options_.frames)) {
    viewers_.poll();
    sendCoded();
    const Clock::time_point now = Clock::now();
    if (viewers_.watching() > 0) watched_ += std::chrono::duration<double>(now - looked).count();
    looked = now;
    if (now < due) {
      std::this_thread::sleep_for(std::min<Clock::duration>(due - now, std::chrono::milliseconds(1)));
      continue;
    }
    // A frame that took too long is not made up for by more than one.
    due = std::max(due + interval, now - interval);
    report();
    if (viewers_.watching() == 0) continue;
    if (auto drawn = frame(std::chrono::duration<double>(now - start).count()); !drawn) return drawn;
  }
  coding_.finish();
  sendCoded();
  // Packets are spread over a frame's time: the last ones are on their way by then.
  if (viewers_.watching() > 0)
    std::this_thread::sleep_for(std::min<Clock::duration>(interval, std::chrono::seconds(1)));
  if (frame_ > 0 && uncoded_ == frame_) return fail("no frame of {} was coded", frame_);
  return {};
}

nlohmann::json Streaming::statistics() const {
  const auto median = [](const std::vector<double>& values) {
    return values.empty() ? 0.0 : summarize(values).median;
  };
  const Times& t = times_;
  const double streaming = median(t.convert) + median(t.read) + median(t.meta) + median(t.send);
  const double own = median(t.visible) + median(t.place) + streaming;
  const double whole = own + median(t.shade) + median(t.encode);
  return {{"frames", frame_},
          {"seconds", watched_},
          {"viewers", mostWatching_},
          {"ms",
           {{"visible", median(t.visible)},
            {"place", median(t.place)},
            {"shade", median(t.shade)},
            {"convert", median(t.convert)},
            {"read", median(t.read)},
            {"meta", median(t.meta)},
            {"encode", median(t.encode)},
            {"send", median(t.send)}}},
          {"own_share", whole > 0.0 ? own / whole : 0.0},
          {"streaming_share", whole > 0.0 ? streaming / whole : 0.0},
          {"video_bytes", videoBytes_},
          {"video_mbit_s", megabits(videoBytes_, watched_)},
          {"meta_bytes", metaBytes_},
          {"meta_mbit_s", megabits(metaBytes_, watched_)},
          {"sent_video_bytes", sentBytes_},
          {"i_frames", iFrames_},
          {"atlas_resets", resetFrames_},
          {"frames_not_coded", uncoded_}};
}

/// Runs a part of a frame to its end, and keeps how long it took.
template <class Part>
void Streaming::timed(std::vector<double>& times, const Part& part) {
  const Clock::time_point before = Clock::now();
  part();
  if (options_.timeStages) gl::api().Finish();
  keep(times, std::chrono::duration<double, std::milli>(Clock::now() - before).count());
}

void Streaming::keep(std::vector<double>& times, double milliseconds) {
  if (times.size() >= 2 * kRemembered)
    times.erase(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(kRemembered));
  times.push_back(milliseconds);
}

void Streaming::noteRow(std::size_t metaBytes) {
  if (!csv_.is_open()) return;
  const Times& t = times_;
  std::string row = fmt::format("{},{}", viewers_.watching(), metaBytes);
  for (const auto* part : {&t.visible, &t.place, &t.shade, &t.convert, &t.read, &t.meta})
    row += fmt::format(",{:.3f}", part->back());
  rows_[frame_] = std::move(row);
}

Result<void> Streaming::writeRow(const EncodedFrame& coded) {
  const auto row = rows_.find(static_cast<std::uint32_t>(coded.frame));
  if (row == rows_.end()) return {};
  csv_ << fmt::format("{},{},{},{},{:.3f},{}\n", coded.frame, coded.iFrame() ? 1 : 0, coded.reference,
                      coded.bytes.size(), coded.milliseconds, row->second);
  csv_.flush();  // whoever follows the file sees whole rows
  rows_.erase(rows_.begin(), std::next(row));
  if (!csv_) return fail("--csv {}: cannot be written", options_.csv);
  return {};
}

/// From a pose to the picture that it makes: there and back, and the frame that is made for it.
double Streaming::latencyOf(const transport::ViewerStatus* status) const {
  if (!options_.measureLatency) return options_.pvs.latency;
  const double roundTrip = status != nullptr ? 1e-3 * status->roundTripMs : 0.0;
  return std::clamp(roundTrip + 1.0 / options_.framesPerSecond, 0.0, 1.0);
}

/// Where each viewer will look until the frame after this one has come to it.
std::vector<TimedView> Streaming::predict(double time) {
  const std::vector<transport::ViewerStatus> statuses = server_.viewers();
  std::vector<TimedView> all;
  std::vector<View> last;
  ends_.clear();
  for (auto& [id, viewer] : viewers_.all()) {
    if (!viewer.watches()) continue;
    const auto status = std::find_if(statuses.begin(), statuses.end(),
                                     [id = id](const auto& one) { return one.viewer == id; });
    PvsOptions pvs = options_.pvs;
    pvs.latency = viewer.latency = latencyOf(status == statuses.end() ? nullptr : &*status);
    const std::vector<TimedView> predicted = predictedViews(viewer.track, {}, pvs);
    // A field of view of nearly half the world has no room for a margin.
    const auto wide = widened(predicted, pvs.margin);
    for (TimedView view : wide ? *wide : predicted) {
      view.time += time - predicted.front().time;
      all.push_back(view);
    }
    ends_.push_back(predicted.front().view);
    last.push_back(predicted.back().view);
  }
  shadedFrom_ = last.front();
  // Everybody's present view comes before anybody's later one.
  ends_.insert(ends_.end(), last.begin(), last.end());
  if (ends_.size() > Engine::kMaxViews) ends_.resize(Engine::kMaxViews);
  return all;
}

/// Whether the atlas was reset in this frame, and whether it waits for an I-frame to be: then one is wished
/// for.
void Streaming::noteReset() {
  const auto of = [](const auto& state) { return Resets{state.resets, state.pressure.pending != 0}; };
  Resets now;
  if (const RectAtlas* atlas = engine_.atlas(); atlas != nullptr) now = of(atlas->memory().readState());
  if (const TessAtlas* tess = engine_.tess(); tess != nullptr) now = of(tess->memory().readState());
  reset_ = now.count != resets_.count;
  resetFrames_ += reset_ ? 1 : 0;
  wish_ = wish_ || now.pending;
  resets_ = now;
}

/// Numbers a frame; whether it is an I-frame.
bool Streaming::beginFrame() {
  ++frame_;
  const bool wished = viewers_.takeIFrameWish() || wish_;
  const bool regular = options_.iFrames > 0 && sinceIFrame_ + 1 >= options_.iFrames;
  const bool iFrame = frame_ == 1 || regular || (wished && sinceIFrame_ + 1 >= kLeastFramesBetweenIFrames);
  wish_ = wished && !iFrame;
  sinceIFrame_ = iFrame ? 0 : sinceIFrame_ + 1;
  iFrames_ += iFrame ? 1 : 0;
  mostWatching_ = std::max(mostWatching_, viewers_.watching());
  return iFrame;
}

Result<void> Streaming::frame(double time) {
  engine_.update(time);
  const std::vector<TimedView> views = predict(time);
  const bool iFrame = beginFrame();
  // All blocks move in a reset: only a frame that builds on none shows that at no cost.
  holdReset(engine_, !iFrame);
  // Between its parts the frame before is sent as soon as it is coded, not a frame later.
  timed(times_.visible, [&] { engine_.findVisible(views); });
  sendCoded();
  Result<void> placed;
  timed(times_.place, [&] { placed = engine_.place(ends_); });
  if (!placed) return placed;
  sendCoded();
  const gl::Texture& atlas = engine_.gatherer()->atlas().encoded;
  timed(times_.shade, [&] { shadeForVideo(engine_, shadedFrom_, options_.shade, iFrame); });
  sendCoded();
  std::optional<YuvPacker::Read> planes;
  Result<void> packed;
  timed(times_.convert, [&] {
    packed = packer_.pack(atlas, frame_);
    if (packed) planes = packer_.read();
  });
  if (!packed) return packed;
  std::vector<wire::VisibleElement> elements;
  std::vector<wire::ObjectTransform> objects;
  std::vector<Region> regions;
  double background = 0.0;
  timed(times_.read, [&] {
    elements = feed_.visible(engine_);
    objects = feed_.objects(engine_);
    // None where the engine does not count pixels.
    regions = regionsOf(shownBlocks(engine_, elements), atlas.width(), atlas.height());
    background = engine_.readBackgroundShare();
    noteReset();
  });
  // Before the messages, so that both are made at once.
  coding_.push(std::move(planes->planes), frame_, iFrame, std::move(regions));
  const std::uint64_t metaBefore = metaBytes_;
  timed(times_.meta, [&] {
    wire::FrameHeader header;
    header.frame = frame_;
    header.iFrame = iFrame;
    header.atlasReset = reset_;
    header.time = time;
    header.background = static_cast<float>(background);
    // Tessellated samples are even in the picture of the first view that was placed.
    header.camera = cameraOf(ends_.front());
    header.lights =
        lightsOf(evaluateLights(engine_.scene(), engine_.state(), engine_.stage(), time), header.camera.eye);
    tellFrame(header, elements, objects);
  });
  noteRow(metaBytes_ - metaBefore);
  return {};
}

/// To each viewer by its own pose.
void Streaming::tellFrame(const wire::FrameHeader& told, const std::vector<wire::VisibleElement>& elements,
                          const std::vector<wire::ObjectTransform>& objects) {
  std::vector<transport::ViewerId> ids;
  for (const auto& [id, viewer] : viewers_.all())
    if (viewer.watches()) ids.push_back(id);
  // Of these a viewer may remember some more that are gone.
  if (const std::size_t most = wire::kMostElements - wire::DeltaOptions().keepMost; elements.size() > most) {
    for (const transport::ViewerId id : ids)
      viewers_.dismiss(id,
                       fmt::format("{} elements are visible, and a viewer takes {}", elements.size(), most));
    return;
  }
  for (const transport::ViewerId id : ids) {
    Viewer& viewer = viewers_.all().at(id);
    wire::FrameHeader header = told;
    header.pose = viewer.pose;
    const View own = viewer.track.last()->view;
    const std::optional<View> later = viewer.track.at(viewer.track.last()->time + viewer.latency);
    wire::Geometry geometry;
    geometry.frame = frame_;
    geometry.changes =
        viewer.delta->next(visibleFrame(elements, objects, viewer.camera, own, later.value_or(own)));
    const std::size_t bytes = viewers_.tell(id, header);
    if (bytes != 0) metaBytes_ += bytes + viewers_.tell(id, geometry);
  }
}

void Streaming::sendCoded() {
  std::vector<Result<EncodedFrame>> done = coding_.take();
  if (done.empty()) return;
  const Clock::time_point before = Clock::now();
  for (Result<EncodedFrame>& coded : done) {
    if (!coded) {
      // The encoder's next frame builds on none; messages that name it as one are sent with the wish.
      say(fmt::format("a frame was not coded: {}", coded.error().message));
      ++uncoded_;
      wish_ = true;
      continue;
    }
    keep(times_.encode, coded->milliseconds);
    if (auto written = writeRow(*coded); !written) {
      say(written.error().message);
      csv_.close();
    }
    videoBytes_ += coded->bytes.size();
    const auto number = static_cast<std::uint32_t>(coded->frame);
    const auto shared = std::make_shared<const transport::Bytes>(std::move(coded->bytes));
    for (const auto& [id, viewer] : viewers_.all()) {
      if (!viewer.videoOpen) continue;
      // Who is gone is an event of the next poll.
      if (server_.sendVideo(id, number, shared)) sentBytes_ += shared->size();
    }
  }
  keep(times_.send, std::chrono::duration<double, std::milli>(Clock::now() - before).count());
}

/// A line a second while somebody watches.
void Streaming::report() {
  const Clock::time_point now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - reported_).count();
  if (seconds < 1.0) return;
  if (frame_ != reportedFrame_)
    say(fmt::format("{} watching, {:.1f} frames/s, video {:.2f} Mbit/s, meta {:.2f} Mbit/s, {} I-frames",
                    viewers_.watching(), (frame_ - reportedFrame_) / seconds,
                    megabits(videoBytes_ - reportedVideo_, seconds),
                    megabits(metaBytes_ - reportedMeta_, seconds), iFrames_));
  reported_ = now;
  reportedFrame_ = frame_;
  reportedVideo_ = videoBytes_;
  reportedMeta_ = metaBytes_;
}

}  // namespace tessera::app
