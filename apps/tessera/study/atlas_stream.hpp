// A shading atlas as it is streamed: what `tessera serve` does for a frame and what `tessera view` does with
// it, without the network between.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "apps/tessera/study/coder.hpp"
#include "apps/tessera/study/shots.hpp"
#include "engine/stream/feed.hpp"
#include "engine/view/display.hpp"

namespace tessera::app {

class AtlasStream {
 public:
  using Masks = std::shared_ptr<const std::vector<wire::MaskImage>>;
  /// Engine, context and path outlive this. `masks` of the scene from before its engine, which lets their
  /// texels go. Fails where the viewer's display does.
  static Result<AtlasStream> create(const gl::Context& context, Engine& engine, const StudyPath& path,
                                    const StudySettings& settings, Masks masks);

  /// Streams with a new atlas of the choice, and gives `take` every shot at every bitrate, in order of their
  /// times.
  Result<StreamFacts> run(const AtlasChoice& atlas, const StreamRun& run, const Take& take);

 private:
  AtlasStream(const gl::Context& context, Engine& engine, const StudyPath& path,
              const StudySettings& settings, view::StreamedDisplay display)
      : context_(&context),
        engine_(&engine),
        path_(&path),
        settings_(&settings),
        display_(std::move(display)) {}
  struct Sent;
  Result<void> show(const Sent& sent, const wire::VisibleMirror& mirror, std::size_t bitrate,
                    const StreamRun& run, const YuvView& planes, const Take& take);
  [[nodiscard]] Result<std::vector<TimedView>> predict(double time, const StreamTiming& timing) const;
  const GeometryFeed& feed();

  const gl::Context* context_;
  Engine* engine_;
  const StudyPath* path_;
  const StudySettings* settings_;
  view::StreamedDisplay display_;
  std::map<bool, GeometryFeed> feeds_;  // by whether elements are triangles
  Masks masks_;
};

}  // namespace tessera::app
