// What a stream of geometry is fed with, taken from a running engine: its scene once, its visible set every
// frame.
#pragma once

#include <span>
#include <vector>

#include "codec/wire/message.hpp"
#include "codec/wire/visible_delta.hpp"
#include "engine/frame/engine.hpp"

namespace tessera {

/// Slopes of a symmetric view, and its turn.
wire::Camera cameraOf(const View& view);
/// The other way round. Fails for a picture that is not as the engine draws them: slopes that are not even to
/// both sides, do not fit square pixels or are not in [wire::kLeastSlope, wire::kMostSlope], and a size, near
/// plane or place beyond wire's bounds and those below, which keep what a viewer asks for within what memory
/// and floats hold.
Result<View> viewOf(const wire::Camera& camera);
inline constexpr double kLeastNear = 1e-6;  // metres
inline constexpr double kMostNear = 1e6;
inline constexpr double kFarthestEye = 1e9;  // metres from the origin, along each axis

/// Alpha of a scene's masked materials, and of the blended ones that have an image, numbered as the styles of
/// elements name them: vertex colours have no part in it, and materials that agree in the rest share one. A
/// material without an image, and one whose image is of one alpha, has one texel. Images beyond
/// wire::kMostMaskSide are halved. Of a scene before an engine takes it: that keeps no pixels.
std::vector<wire::MaskImage> masksOf(const Scene& scene);

/// Lights as a frame is told of them, places relative to `eye`. Those beyond wire::kMostLights are left out,
/// and those whose place or radiance is not finite: the engine shades without them too.
std::vector<wire::SentLight> lightsOf(std::span<const LightSample> lights, const glm::dvec3& eye);

/// The camera paths of a stage; at most wire::kMostPaths.
std::vector<wire::Path> pathsOf(const Stage& stage);

class GeometryFeed {
 public:
  /// Vertices at one place of one object become one. What stands still is one object, in world coordinates;
  /// each node that moves is one more.
  /// Blended elements have the alpha of their material and, in the mean, of their corners' colours. There are
  /// any only with FrameRequest::blended.
  explicit GeometryFeed(const Engine& engine);
  [[nodiscard]] const wire::GeometrySource& source() const { return source_; }
  /// After place(); reads back.
  [[nodiscard]] std::vector<wire::VisibleElement> visible(const Engine& engine) const;
  [[nodiscard]] std::vector<wire::ObjectTransform> objects(const Engine& engine) const;

 private:
  wire::GeometrySource source_;
  std::vector<std::uint32_t> nodes_;  // of objects 1 and on
};

}  // namespace tessera
