#include "apps/tessera/study/atlas_stream.hpp"

#include "apps/tessera/compare/drawing.hpp"
#include "apps/tessera/serve/shading.hpp"
#include "apps/tessera/study/margin.hpp"
#include "engine/stream/regions.hpp"
#include "engine/yuv/packer.hpp"

namespace tessera::app {

/// A frame as it left the server.
struct AtlasStream::Sent {
  wire::FrameHeader header;
  std::vector<Shot> shots;  // that show it
};

Result<AtlasStream> AtlasStream::create(const gl::Context& context, Engine& engine, const StudyPath& path,
                                        const StudySettings& settings, Masks masks) {
  auto display = view::StreamedDisplay::create(context);
  if (!display) return tl::unexpected(display.error());
  AtlasStream stream(context, engine, path, settings, std::move(*display));
  stream.masks_ = std::move(masks);
  return stream;
}

const GeometryFeed& AtlasStream::feed() {
  return feeds_.try_emplace(engine_->tess() != nullptr, *engine_).first->second;
}

Result<std::vector<TimedView>> AtlasStream::predict(double time, const StreamTiming& timing) const {
  PvsOptions pvs;
  pvs.prediction = Prediction::Linear;
  pvs.latency = longestUse(timing);
  pvs.steps = predictionSteps(timing);
  // Poses come at the display's rate.
  PoseTrack track;
  for (const double at : {time - 1.0 / settings_->displayHz, time}) track.add({at, path_->at(at).view});
  std::vector<TimedView> views = predictedViews(track, {}, pvs);
  for (TimedView& view : views) view.time = path_->sceneTime(view.time);
  return views;
}

Result<void> AtlasStream::show(const Sent& sent, const wire::VisibleMirror& mirror, std::size_t bitrate,
                               const StreamRun& run, const YuvView& planes, const Take& take) {
  view::ShadedFrame frame;
  frame.header = sent.header;
  frame.masks = masks_;
  frame.atlas = copyOf(planes);
  frame.take(mirror);
  if (auto uploaded = display_.upload(frame); !uploaded) return uploaded;
  const double posed = (sent.header.frame - 1) / run.serverHz;
  for (const Shot& shot : sent.shots) {
    display_.draw(cameraOf(path_->at(shot.time).view));
    Taken taken{bitrate, shot, display_.read(), kNotMeasured, 1e3 * (shot.time - posed)};
    taken.uncovered = static_cast<double>(display_.uncovered().value_or(0));
    if (auto done = take(std::move(taken)); !done) return done;
  }
  return {};
}

Result<StreamFacts> AtlasStream::run(const AtlasChoice& atlas, const StreamRun& run, const Take& take) {
  Method method;
  method.kind = Kind::Rect;
  method.atlas = atlas;
  if (auto made = useAtlas(*engine_, method); !made) return tl::unexpected(made.error());
  const gl::Texture& encoded = engine_->gatherer()->atlas().encoded;
  auto packer = YuvPacker::create(*context_, encoded.width(), encoded.height(), Chroma::Yuv420);
  if (!packer) return tl::unexpected(packer.error());
  auto coders = codersFor(encoded.width(), encoded.height(), run.serverHz, run.bitratesMbit);
  if (!coders) return tl::unexpected(coders.error());
  wire::VisibleDelta delta(feed().source());
  wire::VisibleMirror mirror(feed().source().method, {static_cast<std::uint32_t>(encoded.width()),
                                                      static_cast<std::uint32_t>(encoded.height())});
  StreamFacts facts;
  facts.width = encoded.width();
  facts.height = encoded.height();
  std::size_t metaBytes = 0;
  for (std::int64_t k = 0; k <= run.lastFrame(); ++k) {
    const double time = static_cast<double>(k) / run.serverHz;
    Sent sent;
    for (const Shot& shot : run.shots)
      if (shownFrame(shot.time, run.timing()) == k) sent.shots.push_back(shot);
    const auto views = predict(time, run.timing());
    if (!views) return tl::unexpected(views.error());
    const auto wide = widened(*views, marginOf(views->front().view, settings_->widening));
    if (!wide) return tl::unexpected(wide.error());
    const bool iFrame = k % settings_->iFrames == 0;
    engine_->update(path_->sceneTime(time));
    holdReset(*engine_, !iFrame);
    engine_->findVisible(*wide);
    const std::array ends = {views->front().view, views->back().view};
    if (auto placed = engine_->place(ends); !placed) return tl::unexpected(placed.error());
    shadeForVideo(*engine_, views->back().view, shadeOptions(atlas), iFrame);
    const auto number = static_cast<std::uint32_t>(k + 1);
    if (auto packed = packer->pack(encoded, number); !packed) return tl::unexpected(packed.error());
    const auto planes = packer->read();
    if (!planes) return fail("frame {}: no planes", number);

    const auto elements = feed().visible(*engine_);
    const auto objects = feed().objects(*engine_);
    const std::vector<Region> regions =
        regionsOf(shownBlocks(*engine_, elements), encoded.width(), encoded.height());
    const View& own = views->front().view;
    sent.header.frame = number;
    sent.header.iFrame = iFrame;
    sent.header.time = path_->sceneTime(time);
    sent.header.camera = cameraOf(own);
    const auto message =
        delta.next(visibleFrame(elements, objects, sent.header.camera, own, views->back().view));
    if (k == 0)
      facts.firstMetaBytes = static_cast<double>(message.size());
    else
      metaBytes += message.size();
    if (auto applied = mirror.apply(message); !applied) return tl::unexpected(applied.error());
    for (std::size_t i = 0; i < coders->size(); ++i) {
      auto picture = (*coders)[i].pass(planes->planes.view(), iFrame, regions);
      if (!picture) return tl::unexpected(picture.error());
      if (sent.shots.empty()) continue;
      if (auto shown = show(sent, mirror, i, run, *picture, take); !shown)
        return tl::unexpected(shown.error());
    }
  }
  const GatherStatistics gathered = engine_->gatherer()->readStatistics();
  facts.bias = gathered.bias;
  facts.atlasUsed =
      static_cast<double>(gathered.usedTexels) / (static_cast<double>(facts.width) * facts.height);
  if (run.lastFrame() > 0)
    facts.metaMbit =
        8e-6 * static_cast<double>(metaBytes) * run.serverHz / static_cast<double>(run.lastFrame());
  for (const Coder& coder : *coders) facts.videoMbit.push_back(coder.madeMbit());
  return facts;
}

}  // namespace tessera::app
