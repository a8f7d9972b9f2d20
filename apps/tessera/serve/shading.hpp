// What is done for every frame whose atlas goes out as video, whoever it is for.
#pragma once

#include <span>
#include <vector>

#include "codec/wire/visible_delta.hpp"
#include "engine/frame/engine.hpp"
#include "engine/stream/feed.hpp"

namespace tessera::app {

/// The planes' vertices may be off by this much of a pixel.
inline constexpr double kVertexPixels = 0.1;

/// All blocks move in a reset of the atlas: only a frame that builds on none shows that at no cost, so that
/// it is held until the next I-frame.
void holdReset(Engine& engine, bool held);

/// Shades what is placed, as `from` sees it. What is free is made black where it costs bits: in I-frames.
void shadeForVideo(Engine& engine, const View& from, const ShadeOptions& options, bool iFrame);

/// What a viewer is told of a frame that it will watch from `own`, and from `later` when the next one comes.
/// Borrows elements and objects.
wire::VisibleFrame visibleFrame(std::span<const wire::VisibleElement> elements,
                                std::span<const wire::ObjectTransform> objects, const wire::Camera& camera,
                                const View& own, const View& later);

}  // namespace tessera::app
