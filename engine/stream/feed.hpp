// What a stream of geometry is fed with, taken from a running engine: its scene once, its visible set every
// frame.
#pragma once

#include <vector>

#include "codec/wire/message.hpp"
#include "codec/wire/visible_delta.hpp"
#include "engine/frame/engine.hpp"

namespace tessera {

/// Slopes of a symmetric view, and its turn.
wire::Camera cameraOf(const View& view);
/// The other way round. Fails for a picture that is not as the engine draws them: slopes that are not even to
/// both sides, do not fit square pixels or are not in [kLeastSlope, kMostSlope], and a size, near plane or
/// place beyond the bounds below, which keep what a viewer asks for within what memory and floats hold.
Result<View> viewOf(const wire::Camera& camera);
inline constexpr std::uint32_t kMostViewSide = 8192;
inline constexpr std::uint32_t kMostViewPixels = 1u << 24;
inline constexpr double kLeastSlope = 1e-3;
inline constexpr double kMostSlope = 11.0;  // 85 degrees off the axis
inline constexpr double kLeastNear = 1e-6;  // metres
inline constexpr double kMostNear = 1e6;
inline constexpr double kFarthestEye = 1e9;  // metres from the origin, along each axis

/// Alpha of a scene's masked materials, numbered as the styles of elements name them: vertex colours have no
/// part in it. A material without an image has one texel. Images beyond wire::kMostMaskSide are halved.
/// Of a scene before an engine takes it: that keeps no pixels.
std::vector<wire::MaskImage> masksOf(const Scene& scene);

class GeometryFeed {
 public:
  /// Vertices at one place of one object become one. What stands still is one object, in world coordinates;
  /// each node that moves is one more.
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
