// A frame as it goes from the network's threads to the display: what was sent of one number, whole.
#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "codec/wire/message.hpp"
#include "codec/wire/visible_mirror.hpp"
#include "engine/image/yuv.hpp"

namespace tessera::view {

using Clock = std::chrono::steady_clock;

inline double millisecondsBetween(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

/// When a frame passed each stage.
struct FrameTimes {
  Clock::time_point posed;   // its pose was sent; the epoch where that is not known
  Clock::time_point header;  // its frame message came
  Clock::time_point video;   // its video was whole
  Clock::time_point decoded;
  Clock::time_point applied;  // its geometry was, and it could be shown
};

/// Geometry after the messages up to a frame, and that frame's atlas.
struct ShadedFrame {
  wire::FrameHeader header;
  wire::Method method = wire::Method::Rect;
  std::vector<glsl::StreamedVertex> vertices;
  std::vector<glm::vec2> maskAt;  // as vertices; empty where the stream has no masks
  std::vector<glsl::StreamedTriangle> triangles;
  std::vector<glsl::StreamedPatch> patches;  // of Method::Rect
  std::vector<glsl::StreamedTess> tess;      // of Method::Tess
  std::vector<std::uint32_t> pieces;
  std::vector<wire::ObjectTransform> objects;
  YuvImage atlas;
  /// All masks of the stream so far; a new list each time one comes. Never null.
  std::shared_ptr<const std::vector<wire::MaskImage>> masks =
      std::make_shared<const std::vector<wire::MaskImage>>();
  FrameTimes times;

  /// Takes the mirror's arrays.
  void take(const wire::VisibleMirror& mirror);
};

}  // namespace tessera::view
