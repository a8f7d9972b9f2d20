// What a geometry stream is fed with, taken from a running engine: its scene once, its visible set every
// frame.
#pragma once

#include <vector>

#include "codec/wire/visible_delta.hpp"
#include "engine/frame/engine.hpp"

namespace tessera::test {

/// A camera path of an engine, as a stream sees it.
struct Recording {
  struct Frame {
    std::vector<wire::VisibleElement> elements;
    std::vector<wire::ObjectTransform> objects;
    wire::Camera camera;
  };
  wire::GeometrySource source;
  std::vector<Frame> frames;
};

/// Slopes of a symmetric view, and its turn.
wire::Camera cameraOf(const View& view);

class EngineFeed {
 public:
  /// Vertices at one place of one object become one. What stands still is one object, in world coordinates;
  /// each node that moves is one more.
  explicit EngineFeed(const Engine& engine);
  [[nodiscard]] const wire::GeometrySource& source() const { return source_; }
  /// After place(); reads back.
  [[nodiscard]] std::vector<wire::VisibleElement> visible(const Engine& engine) const;
  [[nodiscard]] std::vector<wire::ObjectTransform> objects(const Engine& engine) const;

 private:
  wire::GeometrySource source_;
  std::vector<std::uint32_t> nodes_;  // of objects 1 and on
};

}  // namespace tessera::test
