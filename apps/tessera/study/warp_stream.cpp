#include "apps/tessera/study/warp_stream.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/tessera/study/margin.hpp"
#include "engine/gl/readback.hpp"
#include "engine/yuv/packer.hpp"

namespace tessera::app {

WarpStream::Target::Target(int width, int height)
    : color(GL_RGBA8, width, height), depth(GL_DEPTH_COMPONENT32F, width, height) {
  const std::array<const gl::Texture*, 1> colors = {&color};
  framebuffer = gl::Framebuffer(colors, &depth);
}

WarpStream::WarpStream(const gl::Context& context, Engine& engine, const StudyPath& path,
                       const StudySettings& settings, YuvUnpacker unpacker)
    : context_(&context),
      engine_(&engine),
      path_(&path),
      settings_(&settings),
      unpacker_(std::move(unpacker)),
      programs_(std::make_unique<gl::ProgramCache>(context)),
      target_(settings.size.x, settings.size.y) {}

Result<WarpStream> WarpStream::create(const gl::Context& context, Engine& engine, const StudyPath& path,
                                      const StudySettings& settings, std::vector<Warp> wanted) {
  auto unpacker = YuvUnpacker::create(context);
  if (!unpacker) return tl::unexpected(unpacker.error());
  WarpStream stream(context, engine, path, settings, std::move(*unpacker));
  auto warp = ImageWarp::create(*stream.programs_, wanted);
  if (!warp) return tl::unexpected(warp.error());
  stream.warp_ = std::move(*warp);
  stream.wanted_ = std::move(wanted);
  return stream;
}

Result<View> WarpStream::sourceView(double time, double latency) const {
  View view = path_->at(time).view;
  if (settings_->warpPose == WarpPose::Predicted) {
    PoseTrack track;
    for (const double at : {time - 1.0 / settings_->displayHz, time}) track.add({at, path_->at(at).view});
    view = *track.at(time + latency);
  }
  return widened(view, marginOf(view, settings_->widening));
}

Result<std::vector<View>> WarpStream::sourceViews(std::int64_t count, double serverHz, double latency) const {
  std::vector<View> views;
  int width = 0;
  int height = 0;
  for (std::int64_t k = 0; k < count; ++k) {
    auto view = sourceView(static_cast<double>(k) / serverHz, latency);
    if (!view) return tl::unexpected(view.error());
    width = std::max(width, view->width);
    height = std::max(height, view->height);
    views.push_back(*view);
  }
  // Whole squares of chroma.
  width += width % 2;
  height += height % 2;
  // A camera that zooms asks for a few pixels more here and there, and a video has one size. A pixel stays as
  // large as it is in the middle of the viewer's picture.
  for (View& view : views) {
    const double pixel = 2.0 * std::tan(0.5 * view.fovY) / view.height;  // at distance 1
    view.width = width;
    view.height = height;
    view.fovY = 2.0 * std::atan(0.5 * pixel * height);
  }
  return views;
}

Result<std::vector<StreamFacts>> WarpStream::run(const std::vector<StreamRun>& runs, const TakeWarp& take) {
  std::vector<StreamFacts> facts;
  const std::size_t together = settings_->warpPose == WarpPose::Present ? runs.size() : 1;
  for (std::size_t first = 0; first < runs.size(); first += together) {
    auto one = stream(runs, first, together, take);
    if (!one) return tl::unexpected(one.error());
    facts.insert(facts.end(), together, *one);
  }
  return facts;
}

Result<void> WarpStream::show(const WarpSource& source, std::int64_t frame, const StreamRun& run,
                              std::size_t number, std::size_t bitrate, const TakeWarp& take) {
  const double posed = static_cast<double>(frame) / run.serverHz;
  for (const Shot& shot : run.shots) {
    if (shownFrame(shot.time, run.timing()) != frame) continue;
    for (std::size_t i = 0; i < wanted_.size(); ++i) {
      if (auto drawn = warp_.draw(wanted_[i], source, path_->at(shot.time).view, target_.framebuffer,
                                  engine_->encodedBackground());
          !drawn)
        return drawn;
      Taken taken{bitrate, shot, {}, kNotMeasured, 1e3 * (shot.time - posed)};
      taken.picture = flipped(target_.color.width(), target_.color.height(),
                              gl::readTexture(target_.color, GL_RGBA, GL_UNSIGNED_BYTE, 4));
      if (auto done = take(i, number, taken); !done) return done;
    }
  }
  return {};
}

Result<StreamFacts> WarpStream::stream(const std::vector<StreamRun>& runs, std::size_t first,
                                       std::size_t count, const TakeWarp& take) {
  const StreamRun& lead = runs[first];
  std::int64_t last = 0;
  for (std::size_t r = first; r < first + count; ++r) last = std::max(last, runs[r].lastFrame());
  const auto views = sourceViews(last + 1, lead.serverHz, lead.latency);
  if (!views) return tl::unexpected(views.error());
  const View& size = views->front();
  auto packer = YuvPacker::create(*context_, size.width, size.height, Chroma::Yuv420);
  if (!packer) return tl::unexpected(packer.error());
  auto coders = codersFor(size.width, size.height, lead.serverHz, lead.bitratesMbit);
  if (!coders) return tl::unexpected(coders.error());
  for (std::int64_t k = 0; k <= last; ++k) {
    const double time = static_cast<double>(k) / lead.serverHz;
    const View& view = (*views)[static_cast<std::size_t>(k)];
    engine_->update(path_->sceneTime(time));
    engine_->forward(view);
    WarpSource source = engine_->warpSource(view);
    if (auto packed = packer->pack(*source.encoded, static_cast<std::uint32_t>(k + 1)); !packed)
      return tl::unexpected(packed.error());
    const auto planes = packer->read();
    if (!planes) return fail("frame {}: no planes", k);
    for (std::size_t i = 0; i < coders->size(); ++i) {
      auto picture = (*coders)[i].pass(planes->planes.view(), k % settings_->iFrames == 0);
      if (!picture) return tl::unexpected(picture.error());
      if (auto unpacked = unpacker_.unpack(*picture); !unpacked) return tl::unexpected(unpacked.error());
      source.encoded = &unpacker_.encoded();
      for (std::size_t r = first; r < first + count; ++r)
        if (auto shown = show(source, k, runs[r], r, i, take); !shown) return tl::unexpected(shown.error());
    }
  }
  StreamFacts facts;
  facts.width = size.width;
  facts.height = size.height;
  for (const Coder& coder : *coders) facts.videoMbit.push_back(coder.madeMbit());
  return facts;
}

}  // namespace tessera::app
